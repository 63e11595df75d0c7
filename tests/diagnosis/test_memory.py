"""A diagnosis goes with its result: who diagnoses a hundred campaigns in one process keeps none of them."""

from __future__ import annotations

import gc

import pytest

import stepid
from hidden.campaigns import Request, make_campaigns
from stepid.core.experiment import Experiment
from stepid.fitting.levenberg_marquardt import Problem


def alive() -> int:
    gc.collect()
    return sum(isinstance(one, Experiment | Problem) for one in gc.get_objects())


@pytest.mark.parametrize("effects", [(), ("viscoelastic_spring",)])
def test_nothing_of_a_campaign_is_kept(effects: tuple[str, ...]) -> None:
    """The rates of a fit had been kept by what holds the fit."""
    stepid.diagnose(make_campaigns([Request(4, (), None, None, "four")])[0][0], effort=stepid.Effort.quick())
    before = alive()
    made = make_campaigns([Request(5, effects, None, 8.0 if effects else None, "four")])[0][0]
    assert stepid.diagnose(made).effects == effects
    del made
    assert alive() == before
