"""The first readings of a record, where a buffer was empty."""

from __future__ import annotations

import numpy as np
import pytest

import stepid
from stepid.core.outliers import outliers
from stepid.fitting.reading_faults import mend


@pytest.mark.parametrize("count", [1, 2, 3])
def test_the_first_readings_are_wrong_where_no_motion_comes_from_them(count: int) -> None:
    """An empty buffer reads 0, while the cart rests at 50 mm."""
    t = np.maximum(np.arange(200) - 40, 0) / 20
    y = 0.05 + 0.02 * (1.0 - np.exp(-0.1 * t) * np.cos(t)) + 1e-6 * np.random.default_rng(2).standard_normal(200)
    assert not outliers(y, 1e-6, 0.0)
    garbage = y.copy()
    garbage[:count] = 0.0
    assert [block[1:] for block in outliers(garbage, 1e-6, 0.0)] == [(0, count)]
    found = mend(
        stepid.Experiment(
            name="r", time=0.01 * np.arange(200), position=garbage, input=np.where(np.arange(200) < 40, 0.0, 1.0),
            added_mass=0.0, spring="s", damper="d",
        )
    )  # fmt: skip
    assert np.flatnonzero(found.wrong).tolist() == list(range(count))
    assert found.run.position[:count] == pytest.approx(y[:count], abs=1e-4)
    (fault,) = found.faults
    assert fault.size == pytest.approx(0.05, rel=0.05)
    moving = np.concatenate([garbage[:count], y[60:]])  # readings may have been lost
    assert not outliers(moving, 1e-6, 0.0)
