"""Who waits for the kernel to be compiled is told, once an installation."""

from __future__ import annotations

from pathlib import Path

import pytest

from stepid.simulation import laws, warm_up
from stepid.simulation.compiled import JIT


@pytest.mark.skipif(not JIT, reason="nothing is compiled")
def test_compiling_is_told_once_an_installation(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(laws, "cache_folder", lambda: tmp_path)
    monkeypatch.setattr(warm_up, "_loaded", [])
    told: list[str] = []
    warm_up.warm_up(told.append)
    assert told == ["compiling once (some seconds)"]
    warm_up.warm_up(told.append)
    monkeypatch.setattr(warm_up, "_loaded", [])  # another process
    warm_up.warm_up(told.append)
    assert len(told) == 1
