"""What a diagnosis remarks on records: a stop that was hit, and no more than a sensor of few counts shows."""

from __future__ import annotations

import numpy as np
import pytest

import stepid
from made_up_releases import released
from stepid.diagnosis.notes import _is_clipped, _open_parameters, notes_on
from stepid.effects import resolve
from stepid.fitting.fit import prepare

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
    effects = resolve(["cogging"])
    fit = prepare(stepid.Campaign(name="releases", experiments=(released(0.0), released(0.5))))
    phase = stepid.Estimate(value=-4e-5, uncertainty=uncertainty, unit="rad")
    found = list(_open_parameters(fit.linear, effects, {"cogging.phase": phase}, 0.5))
    assert any("hardly determine the phase of cogging" in note for note in found) is said
