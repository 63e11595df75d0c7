"""What long records are computed with instead of the plain way: the same numbers."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import savgol_filter

from stepid.identification import steady_state


def test_a_long_tail_is_solved_as_a_short_one(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(3)
    time = np.linspace(0.0, 4.0, 2000)
    basis = np.column_stack([np.ones_like(time), np.exp(-time) * np.cos(9 * time), np.exp(-time) * np.sin(9 * time)])
    values = basis @ [0.02, 0.003, -0.004] + 1e-5 * rng.standard_normal(time.size)
    plain, spread = steady_state._solved(basis, values)
    monkeypatch.setattr(steady_state, "_MANY", 1000)
    assert steady_state._solved(basis, values)[0] == pytest.approx(plain, rel=1e-9)
    assert steady_state._solved(basis, values)[1] == pytest.approx(spread, rel=1e-9)
    assert spread == pytest.approx(1 / np.sqrt(time.size), rel=0.05)  # of a mean, nearly
    near = np.column_stack([basis, basis[:, 1] + 1e-9 * time])  # nearly alike: the normal equations would lose them
    assert steady_state._solved(near, values)[0][:1] == pytest.approx([0.02], abs=1e-6)


@pytest.mark.parametrize("size", [64, 200])
def test_a_wide_window_smooths_as_a_narrow_one(size: int, monkeypatch: pytest.MonkeyPatch) -> None:
    values = np.cumsum(np.random.default_rng(4).standard_normal(size))
    monkeypatch.setattr(steady_state, "_LONG", 21)
    for window in (21, 23, 63):
        assert steady_state._smoothed(values, window) == pytest.approx(savgol_filter(values, window, 3), abs=1e-9)


def test_a_cubic_is_smoothed_into_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    x = np.linspace(-1, 2, 301)
    cubic = 2 * x**3 - x + 0.3
    for long in (1001, 5):
        monkeypatch.setattr(steady_state, "_LONG", long)
        assert steady_state._smoothed(cubic, 41) == pytest.approx(cubic, abs=1e-11)
