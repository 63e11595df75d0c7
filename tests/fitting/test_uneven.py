"""Samples at uneven times: the motion as measured, the weak form and the missing force use the stamps."""

from __future__ import annotations

import numpy as np
import pytest

import stepid
from stepid.core.base import Array
from stepid.core.experiment import Campaign
from stepid.diagnosis.phases import phase_of_samples
from stepid.diagnosis.residual_force import residual_force, shape
from stepid.fitting.noise_floor import noise_floor
from stepid.fitting.problem import fit_linear
from stepid.fitting.spectrum import strongest_period
from stepid.fitting.weak_form import WeakForm, measured_motion
from stepid.simulation.records import lay_out
from stepid.simulation.simulate import solve_model

MODEL = stepid.PlantModel(
    base_mass={"cart": 0.8},
    stiffness={"s": 200.0},
    damping={"d": 1.5},
    force_gain=8.0,
    effects=(stepid.EffectModel(name="coulomb_friction", values={"level": 0.3}),),
)


def campaign(*, jitter: float, gap: int, effects: bool) -> tuple[Campaign, Array]:
    """Steps at times that jitter, twice as far apart from sample `gap` on; and the true velocity, m/s."""
    rng = np.random.default_rng(1)
    steps = np.where(np.arange(700) < gap, 0.008, 0.016) * (1 + jitter * rng.uniform(-1, 1, 700))
    time = np.cumsum(steps)
    runs = tuple(
        stepid.Experiment(
            name=f"{added}",
            time=time,
            position=np.zeros(700),
            input=np.where(np.arange(700) < 20, 0.0, 1.0),
            added_mass=added,
            spring="s",
            damper="d",
            starts="rest",
        )
        for added in (0.0, 1.0)
    )
    plain = Campaign(name="uneven", experiments=runs)
    model = MODEL if effects else MODEL.model_copy(update={"effects": ()})
    records, solved = solve_model(model, plain)
    noisy = (
        run.model_copy(update={"position": solved.reading[piece] + 2e-6 * rng.standard_normal(700)})
        for run, piece in zip(runs, records.pieces(), strict=True)
    )
    return plain.model_copy(update={"experiments": tuple(noisy)}), solved.states[1]


@pytest.mark.parametrize(("jitter", "gap"), [(0.4, 700), (0.0, 250), (0.3, 300)])
def test_velocity_and_weak_form_follow_the_stamps(jitter: float, gap: int) -> None:
    made, velocity = campaign(jitter=jitter, gap=gap, effects=False)
    records = lay_out(made)
    linear = fit_linear(records)
    assert linear is not None
    period = strongest_period(records)
    motion = measured_motion(records, linear.shared, noise_floor(records), period)
    assert np.sqrt(np.mean((motion.v - velocity) ** 2)) < 0.03 * np.sqrt(np.mean(velocity**2))
    found = WeakForm(records, 0.6 * period, fixed_mass=None).solve()
    assert found is not None
    np.testing.assert_allclose(found.shared[:3], [0.8, 200.0, 1.5], rtol=0.05)


@pytest.mark.parametrize(("jitter", "gap"), [(0.4, 700), (0.0, 250)])
def test_the_missing_force_of_uneven_samples_is_the_friction(jitter: float, gap: int) -> None:
    made, _ = campaign(jitter=jitter, gap=gap, effects=True)
    records = lay_out(made)
    linear = fit_linear(records)
    assert linear is not None
    floor = noise_floor(records)
    motion = measured_motion(records, linear.shared, floor, strongest_period(records))
    found = shape(residual_force(records, linear, motion, phase_of_samples(records, linear, motion, floor), floor))
    assert found is not None
    assert found.name == "sign of velocity"
    assert -found.coefficient == pytest.approx(0.3, rel=0.2)
