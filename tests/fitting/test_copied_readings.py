"""Readings that repeat the one before to the last digit: where noise makes all others different none was taken."""

from __future__ import annotations

import numpy as np

from made_up_readings import campaign, runs
from stepid.fitting.reading_faults import _copied, mend


def test_where_noise_makes_all_readings_different_one_that_is_the_same_was_not_taken() -> None:
    """Lost samples that a program filled with the reading before: at rest as well, and near a turning point."""
    random = np.random.default_rng(1)
    y = runs(friction=0.02)[2]
    y = y + 5e-6 * random.standard_normal(y.size)
    lost = np.random.default_rng(5).choice(np.arange(4, y.size - 4), size=y.size // 40, replace=False)
    for at in np.sort(lost):
        y[at] = y[at - 1]
    found = mend(campaign([y] * 4).experiments[0])
    assert np.flatnonzero(found.wrong).tolist() == np.sort(lost).tolist()
    assert [fault.kind for fault in found.faults] == ["stuck readings"]
    rounded = 2e-6 * np.round(y / 2e-6)
    assert _copied(rounded, 5e-6, 0.0) == []  # on a grid noise repeats readings by itself


def test_a_rest_without_noise_repeats_no_reading() -> None:
    still = np.concatenate([np.zeros(60), runs(friction=0.02)[2]])
    assert not mend(campaign([still] * 4).experiments[0]).wrong.any()
