"""What a diagnosis remarks on records: a stop that was hit, and no more than a sensor of few counts shows."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import stepid
from made_up_releases import released
from stepid.diagnosis.notes import _is_clipped, _open_parameters, notes_on
from stepid.effects import resolve
from stepid.effects.base import Effect
from stepid.fitting.fit import prepare
from stepid.fitting.fit_effects import fit_effects
from stepid.fitting.levenberg_marquardt import Optimum

TIME = 0.01 * np.arange(470)
SWING = np.exp(-0.3 * TIME) * np.cos(4.0 * TIME + 0.7)


@pytest.mark.parametrize("count", [1e-4, 1e-2, 0.05, 0.1])
def test_a_peak_within_one_count_is_no_stop(count: float) -> None:
    assert not _is_clipped(count * np.round(SWING / count), count)


@pytest.mark.parametrize("count", [0.0, 1e-4, 1e-2])
def test_a_stop_is_told(count: float) -> None:
    held = np.maximum(SWING, -0.4)
    assert _is_clipped(held if count == 0 else count * np.round(held / count), count)


def test_a_peak_within_one_count_of_readings_on_no_even_grid_is_no_stop() -> None:
    angle = np.round(np.round(9.0 * SWING / 0.352) * 0.352, 1)  # degrees to a tenth: 0.4, 0.7, 1.1, 1.4, 1.8
    run = stepid.Experiment(
        name="swing", time=TIME, position=np.radians(angle), input=0.0 * TIME, added_mass=0.0, spring="s", damper="d",
        starts="motion",
    )  # fmt: skip
    assert run.resolution is None
    fit = prepare(
        stepid.Campaign(
            name="swings", experiments=(run, run.model_copy(update={"name": "b", "position": -run.position}))
        )
    )
    said = notes_on(fit, fit.linear, (), {}, 0.5)
    assert not any("hit a stop" in note for note in said)


def test_a_cart_that_comes_to_rest_has_hit_nothing() -> None:
    assert not _is_clipped(np.minimum(1.0, 0.02 * np.arange(470)), 0.0)


def test_no_gain_is_asked_of_releases() -> None:
    fit = prepare(stepid.Campaign(name="releases", experiments=(released(0.0), released(0.5))))
    parameters = stepid.fit(stepid.Campaign(name="releases", experiments=(released(0.0), released(0.5)))).parameters
    said = notes_on(fit, fit.linear, (), parameters, 0.5)
    assert parameters["force_gain"].uncertainty is None
    assert not any("gain" in note for note in said)


@pytest.mark.parametrize(("uncertainty", "said"), [(1e-4, False), (0.4, False), (0.6, True)])
def test_an_angle_of_zero_is_determined_as_well_as_any(uncertainty: float, said: bool) -> None:
    phase = stepid.Estimate(value=-4e-5, uncertainty=uncertainty, unit="rad")
    found = list(_open_parameters(*with_cogging(), {"cogging.phase": phase}, 0.5))
    assert any("hardly determine the phase of cogging" in note for note in found) is said


@pytest.mark.parametrize(("pitch", "said"), [(1.15e-5, True), (1.25e-5, False)])
def test_what_ends_where_its_range_begins_is_hardly_determined(pitch: float, said: bool) -> None:
    """A tenth of itself, and more or less than half of what it is above its least."""
    optimum, effects = with_cogging()
    shared = optimum.shared.copy()
    shared[-2] = pitch
    value = stepid.Estimate(value=pitch, uncertainty=1e-6, unit="m")
    found = list(_open_parameters(replace(optimum, shared=shared), effects, {"cogging.pitch": value}, 0.5))
    assert any("hardly determine the pitch of cogging" in note for note in found) is said


@cache
def with_cogging() -> tuple[Optimum, tuple[Effect, ...]]:
    """A fit of cogging to releases of a linear plant."""
    effects = resolve(["cogging"])
    fit = prepare(stepid.Campaign(name="releases", experiments=(released(0.0), released(0.5))))
    optimum = fit_effects(fit, effects)
    assert optimum is not None
    return optimum, effects
