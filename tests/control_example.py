"""A plant and runs for the tests of the bridge to python-control, with one strong effect of each kind."""

from __future__ import annotations

import numpy as np

import stepid
from stepid.effects import CATALOGUE

PERIOD, SAMPLES, REST = 0.012, 160, 0.01
VALUES = {
    "coulomb_friction": (0.2,),
    "load_proportional_friction": (0.02,),
    "stribeck_friction": (0.2, 0.3, 0.02),
    "asymmetric_friction": (0.2, 0.3),
    "presliding_hysteresis": (0.5, 1e-3),
    "quadratic_damping": (20.0,),
    "position_dependent_damping": (15.0,),
    "cubic_stiffness": (4e4,),
    "quadratic_stiffness": (1500.0,),
    "free_play": (2e-3,),
    "end_stop": (2000.0, 0.035),
    "viscoelastic_spring": (60.0, 8.0),
    "flexible_coupling": (0.2, 400.0, 0.5),
    "actuator_lag": (0.02,),
    "input_delay": (0.012,),
    "actuator_dead_zone": (0.1,),
    "actuator_saturation": (0.8,),
    "periodic_disturbance": (0.3, 7.0),
    "cogging": (0.4, 0.012, 0.5),
    "sensor_drift": (1e-3,),
    "sine_stiffness": (25.0,),
    "power_damping": (0.5, 0.6),
    "actuator_rate_limit": (8.0,),
}


def step_run(*, input_before: float = 0.0) -> stepid.Experiment:
    """A step up, a step down to the other side, a step back to zero."""
    inputs = np.repeat([input_before, 1.0, -0.6, 0.0], [5, 75, 55, SAMPLES - 135])
    return stepid.Experiment(
        name="steps",
        time=3.0 + PERIOD * np.arange(SAMPLES),
        position=np.zeros(SAMPLES),
        input=inputs,
        added_mass=0.5,
        spring="medium",
        damper="plug",
        input_before=input_before,
    )


def release_run(*, held: int = 0) -> stepid.Experiment:
    """A free release from 3 cm, after a hand has held the cart for some samples."""
    t = PERIOD * np.arange(SAMPLES - held)
    decay, frequency = 4.0 / 3.0, np.sqrt(216.0 / 1.5)
    free = 0.03 * np.exp(-decay * t) * np.cos(frequency * t)
    return stepid.Experiment(
        name="release",
        time=PERIOD * np.arange(SAMPLES),
        position=REST + np.concatenate([np.full(held, 0.03), free]),
        input=np.zeros(SAMPLES),
        added_mass=0.5,
        spring="medium",
        damper="plug",
    )


def model(*effects: str) -> stepid.PlantModel:
    """The plant with effects from `VALUES`; it knows where both runs begin."""
    catalogue = {effect.name: effect for effect in CATALOGUE}
    phases = {"periodic_disturbance.phase": 0.4}
    return stepid.PlantModel(
        base_mass={"cart": 1.0},
        stiffness={"medium": 216.0},
        damping={"plug": 4.0},
        force_gain=7.8,
        effects=tuple(
            stepid.EffectModel(
                name=name,
                values=dict(zip((q.name for q in catalogue[name].parameters), VALUES[name], strict=True)),
            )
            for name in effects
        ),
        runs={
            "steps": stepid.RunState(rest=REST, phases=phases),
            "release": stepid.RunState(rest=REST, displacement=0.028, velocity=-0.05, phases=phases),
        },
    )


def simulated(model: stepid.PlantModel, run: stepid.Experiment) -> np.ndarray:
    """What `stepid.simulate` says."""
    return stepid.simulate(model, stepid.Campaign(name="one", experiments=(run,)))[run.name]
