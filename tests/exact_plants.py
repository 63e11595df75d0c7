"""Noise-free campaigns of plants with one effect, from the reference integrator, and the same plants as models."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

import stepid
from hidden import Run, reference

COUNTS, PERIOD = 226600.0, 0.0088542  # counts/m, s: the paper's
EFFECTS: dict[str, dict[str, float]] = {
    "coulomb_friction": {"level": 0.3},
    "load_proportional_friction": {"coefficient": 0.015},
    "stribeck_friction": {"level": 0.2, "breakaway": 0.4, "velocity": 0.006},
    "asymmetric_friction": {"level_forward": 0.2, "level_backward": 0.35},
    "presliding_hysteresis": {"level": 0.25, "distance": 1.5e-4},
    "quadratic_damping": {"coefficient": 40.0},
    "position_dependent_damping": {"slope": -14.0},
    "cubic_stiffness": {"coefficient": 4e5},
    "quadratic_stiffness": {"coefficient": -1500.0},
    "free_play": {"gap": 0.0008},
    "end_stop": {"stiffness": 6000.0, "position": 0.02},
    "viscoelastic_spring": {"stiffness": 60.0, "damping": 6.0},
    "flexible_coupling": {"mass": 0.25, "stiffness": 800.0, "damping": 0.8},
    "actuator_lag": {"time_constant": 0.01},
    "input_delay": {"delay": 0.013},
    "actuator_dead_zone": {"level": 0.05},
    "actuator_saturation": {"level": 0.45},
    "periodic_disturbance": {"amplitude": 0.2, "frequency": 5.3},
    "cogging": {"amplitude": 0.3, "pitch": 0.005, "phase": 1.0},
    "sensor_drift": {"rate": 3e-4},
}
NEW_EFFECTS: dict[str, dict[str, float]] = {
    "sine_stiffness": {"curvature": 40.0},
    "power_damping": {"coefficient": 0.6, "exponent": 0.5},
    "actuator_rate_limit": {"rate": 5.0},
}
PROTOCOL = ((0.0, 0.5), (0.5, 0.5), (1.5, 0.5), (2.0, -0.5), (1.0, 0.3))  # added kg, V


def exact_campaign(
    effects: Mapping[str, Mapping[str, float]], protocol: Sequence[tuple[float, float]] = PROTOCOL
) -> stepid.Campaign:
    """Steps up and back: four masses, one of another size the other way."""
    experiments = []
    for i, (added, volts) in enumerate(protocol):
        inputs = np.repeat([0.0, volts, 0.0], [5, 220, 225])
        run = Run(0.95 + added, 216.0, 8.0, 7.8, PERIOD, inputs, effects, phase=0.7 + i)
        experiments.append(
            stepid.Experiment(
                name=f"case {i + 1}",
                time=PERIOD * np.arange(inputs.size),
                position=reference(run),
                input=inputs,
                added_mass=added,
                spring="medium",
                damper="1/2 turn",
            )
        )
    return stepid.Campaign(name="exact", experiments=tuple(experiments))


def true_model(campaign: stepid.Campaign, name: str, values: Mapping[str, float]) -> stepid.PlantModel:
    """The plant of `exact_campaign` as stepid writes it."""
    states = {}
    for i, e in enumerate(campaign.experiments):
        phases = {"periodic_disturbance.phase": 0.7 + i} if name == "periodic_disturbance" else {}
        states[e.name] = stepid.RunState(phases=phases)
    return stepid.PlantModel(
        base_mass={"cart": 0.95},
        stiffness={"medium": 216.0},
        damping={"1/2 turn": 8.0},
        force_gain=7.8,
        effects=(stepid.EffectModel(name=name, values=values),),
        runs=states,
    )
