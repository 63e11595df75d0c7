"""Where the fitted plant runs away, nothing is promised and nothing is ruled out."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from stepid.fitting import deviations
from stepid.fitting.score_test import promises


def test_no_step_is_promised_along_a_runaway(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(deviations, "_Basis", lambda _: SimpleNamespace(finite=False))
    optimum: Any = None
    gain, value, error = deviations.promised_by(optimum, np.ones((5, 3)))
    assert gain.tolist() == value.tolist() == [0.0, 0.0, 0.0]
    assert np.isposinf(error).tolist() == [True, True, True]


@pytest.mark.parametrize("bad", [np.inf, np.nan])
def test_starts_beside_a_runaway_all_race(bad: float) -> None:
    inner: Any = SimpleNamespace(solved=None, problem=SimpleNamespace(jacobian=lambda _: np.array([[1.0, bad]])))
    context: Any = None
    starts: Any = [object(), object()]
    assert promises(context, inner, (), starts) == [np.inf, np.inf]
    assert promises(context, inner, (), []) == []
