"""The force of presliding hysteresis along a measured path, against its closed form."""

from __future__ import annotations

import numpy as np
import pytest

from stepid.core.base import Array
from stepid.effects import resolve
from stepid.effects.base import Motion, Scales

(EFFECT,) = resolve(["presliding_hysteresis"])
SCALES = Scales(0.01, 0.1, 2.0, 1.0, 200.0, 8.0, 1.0, 1.0, 0.004, 1.0, 1e-5, -0.01, 0.01)
STEPS = 100


def along(*paths: Array) -> list[Array]:
    """Unit forces along the paths of some runs, one array for each distance of the regressors."""
    x = np.concatenate(paths)
    time = np.concatenate([np.arange(path.size) * SCALES.sample_time for path in paths])
    motion = Motion(x, np.gradient(x), np.where(np.gradient(x) < 0, -1.0, 1.0), time, x, x, x, x)
    return [r.forces[0] for r in EFFECT.regressors(SCALES, motion)]


def distances() -> list[float]:
    motion = Motion(*(np.zeros(3) for _ in Motion._fields))
    out = []
    for r in EFFECT.regressors(SCALES, motion):
        values = r.values(np.ones(1))
        assert values is not None
        out.append(values[1])
    return out


def test_the_force_builds_up_over_its_distance_whatever_the_speed() -> None:
    x = SCALES.displacement * np.linspace(0.0, 1.0, STEPS) ** 2
    for distance, force in zip(distances(), along(x), strict=True):
        assert force == pytest.approx(-(1.0 - np.exp(-x / distance)), abs=1e-12)


def test_unloading_is_elastic_and_the_other_way_mirrors() -> None:
    up = SCALES.displacement * np.linspace(0.0, 1.0, STEPS)
    back = SCALES.displacement * np.linspace(1.0, 0.0, STEPS)
    for distance, force in zip(distances(), along(np.concatenate([up, back])), strict=True):
        built = 1.0 - np.exp(-up[-1] / distance)
        moved = up[-1] - back
        elastic = moved < built * distance
        assert force[STEPS:][elastic] == pytest.approx(moved[elastic] / distance - built, abs=1e-12)
        beyond = moved[~elastic] / distance - built
        assert force[STEPS:][~elastic] == pytest.approx(1.0 - np.exp(-beyond), abs=1e-12)


def test_each_run_begins_without_memory() -> None:
    x = SCALES.displacement * np.linspace(0.0, 1.0, STEPS)
    for both, alone, mirrored in zip(along(x, -x), along(x), along(-x), strict=True):
        assert both == pytest.approx(np.concatenate([alone, mirrored]), abs=0)
        assert mirrored == pytest.approx(-alone, abs=0)
