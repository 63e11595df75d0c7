"""The picture of the calibration is drawn from any lines, also from few."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "benchmarks"))

import calibration  # noqa: E402


def record(right: bool, **fields: Any) -> dict[str, Any]:
    effects = ["coulomb_friction"] if right else ["cogging"]
    told = {"verdict": "named", "effects": effects, "alternatives": [], "probability": 0.9}
    return {"set": "single", "number": 0, "truth": ["coulomb_friction"], "outside": None, **told, **fields}


def test_bins_are_apart_for_clean_and_perturbed() -> None:
    records = [record(True), record(False), record(True, perturbations=["gain"]), {"error": "no"}]
    (clean,), (perturbed,) = (calibration.bins(records, kind) for kind in ("clean", "perturbed"))
    assert (clean["count"], clean["right"]) == (2, 0.5)
    assert (perturbed["count"], perturbed["right"]) == (1, 1.0)


def test_the_picture_is_drawn(tmp_path: Path) -> None:
    for name, records in (("some", [record(True)] * 3), ("none", [])):
        calibration.draw(records, tmp_path / f"{name}.png")
        assert (tmp_path / f"{name}.png").read_bytes().startswith(b"\x89PNG")
