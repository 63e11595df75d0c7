"""How far stepid's simulator is from tight-tolerance, event-located integration, effect by effect.

    python benchmarks/simulator_accuracy.py [--only NAME] [--fit]

Five runs at the paper's sample time are computed by `hidden.reference` (tests/hidden) and by `stepid.simulate` with the
same plant; the difference is in counts of the paper's encoder (226600 counts/m; asked: RMS at most 0.1). The time is
that of one call of `stepid.simulate`, after a first one. With --fit, `stepid.fit` is given the reference's data and the
true effect: what it leaves, and what the simulator's error does to the effect's parameters.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")

import argparse
import sys
import time
from collections.abc import Mapping
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests"))

import stepid  # noqa: E402
from hidden import Run, reference  # noqa: E402
from stepid.model import EffectModel, PlantModel, RunState  # noqa: E402

COUNTS, PERIOD = 226600.0, 0.0088542
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


def exact_campaign(effects: Mapping[str, Mapping[str, float]]) -> stepid.Campaign:
    """Five runs: four masses up and back, one of another size the other way."""
    experiments = []
    for i, (added, volts) in enumerate(((0.0, 0.5), (0.5, 0.5), (1.5, 0.5), (2.0, -0.5), (1.0, 0.3))):
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


def true_model(campaign: stepid.Campaign, name: str, values: Mapping[str, float]) -> PlantModel:
    """The plant of `exact_campaign` as stepid writes it."""
    states = {}
    for i, e in enumerate(campaign.experiments):
        phases = {"periodic_disturbance.phase": 0.7 + i} if name == "periodic_disturbance" else {}
        states[e.name] = RunState(phases=phases)
    return PlantModel(
        base_mass={"cart": 0.95},
        stiffness={"medium": 216.0},
        damping={"1/2 turn": 8.0},
        force_gain=7.8,
        effects=(EffectModel(name=name, values=values),),
        runs=states,
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", help="one effect")
    parser.add_argument("--fit", action="store_true", help="also fit the reference's data")
    args = parser.parse_args()
    print("| effect | RMS, counts | largest | CPU ms | after a fit, RMS | worst parameter |")
    print("| --- | --- | --- | --- | --- | --- |")
    worst = 0.0
    for name, values in EFFECTS.items():
        if args.only and name != args.only:
            continue
        campaign = exact_campaign({name: values})
        model = true_model(campaign, name, values)
        stepid.simulate(model, campaign)
        start = time.process_time()
        ours = stepid.simulate(model, campaign)
        seconds = time.process_time() - start
        off = np.concatenate([ours[e.name] - e.position for e in campaign.experiments]) * COUNTS
        rms = float(np.sqrt(np.mean(off**2)))
        worst = max(worst, rms)
        row = f"| {name} | {rms:.4f} | {np.max(np.abs(off)):.3f} | {1e3 * seconds:.1f} |"
        if args.fit:
            f = stepid.fit(campaign, effects=(name,))
            error = max(abs(f.parameters[f"{name}.{p}"].value / v - 1) for p, v in values.items())
            row += f" {f.rms * COUNTS:.4f} | {100 * error:.2g} % |"
        print(row if args.fit else row + " | |", flush=True)
    print(f"worst RMS: {worst:.4f} counts, asked: at most 0.1")


if __name__ == "__main__":
    main()
