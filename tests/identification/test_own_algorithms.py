"""A solver and a peak of one's own: any object with their one method."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest

import stepid
from stepid.core.base import Array
from stepid.identification.parameters import StackedSystem
from stepid.identification.peak import Peak, PeakReading, SampledPeak
from stepid.identification.solvers import Solver


class Halfway(NamedTuple):
    """Halfway from the weighted to the paper's answer."""

    share: float = 0.5

    def unknowns(
        self, system: StackedSystem, measured: Array, differences: Array, *, start: Array | None = None
    ) -> Array:
        one = stepid.WeightedLeastSquares().unknowns(system, measured, differences, start=start)
        two = stepid.OrdinaryLeastSquares().unknowns(system, measured, differences)
        return (1 - self.share) * one + self.share * two


class LatePeak:
    """The largest sample, one sample late."""

    def locate(self, time: Array, swing: Array, *, level: float, noise: float) -> PeakReading:
        found = SampledPeak().locate(time, swing, level=level, noise=noise)
        return found._replace(time=found.time + float(time[1] - time[0]))


def test_a_solver_of_ones_own() -> None:
    data = stepid.datasets.burchett()
    system = stepid.assemble(data.characteristics, data.mass_offsets)
    own: Solver = Halfway()
    found = stepid.solve(system, solver=own)
    ends = [stepid.solve(system, solver=s) for s in (stepid.WeightedLeastSquares(), stepid.OrdinaryLeastSquares())]
    for name, mass in found.masses.items():
        assert mass == pytest.approx(np.mean([end.masses[name] for end in ends]))
        spread = sorted(end.uncertainty.masses[name] for end in ends)
        assert 0.3 * spread[0] < found.uncertainty.masses[name] < 2 * spread[1]
    assert found.solver == "Halfway()"


def test_a_peak_of_ones_own() -> None:
    own: Peak = LatePeak()
    campaign = stepid.datasets.lab_campaign()
    run = campaign["case 4"]
    late, plain = (stepid.characterize(run, peak=p) for p in (own, stepid.SampledPeak()))
    assert late.peak_time == pytest.approx((plain.peak_time or 0.0) + run.sample_time)
    assert late.damped_frequency < plain.damped_frequency
    assert stepid.identify(campaign, peak=own).masses["case 4"] > 0
