"""A plan's promises beside the hidden simulator: scatter of `stepid.fit` over its prediction, pairs told apart.

`python -m benchmarks.planning scatter --plants 10 --count 100` and `python -m benchmarks.planning pairs --count 40`,
with tests/ on the path.
"""

from __future__ import annotations

import argparse
import time
from typing import Any

import numpy as np

import stepid
from hidden.fast import fast
from hidden.plant import runs_like
from stepid.effects import resolve
from stepid.lab.design.check import refitted
from stepid.lab.design.information import lay_out_steps, simulated

WEIGHT = 0.5
EFFECTS = (None, None, "coulomb_friction", "cubic_stiffness", "actuator_lag", "quadratic_damping")
PAIRS = (
    ("coulomb_friction", "quadratic_damping"),
    ("coulomb_friction", "load_proportional_friction"),
    ("coulomb_friction", "presliding_hysteresis"),
    ("cubic_stiffness", "quadratic_stiffness"),
    ("cubic_stiffness", "actuator_saturation"),
    ("actuator_dead_zone", "coulomb_friction"),
    ("viscoelastic_spring", "quadratic_damping"),
    ("actuator_lag", "input_delay"),
    ("free_play", "coulomb_friction"),
)


def draw_guess(rng: np.random.Generator) -> dict[str, float]:
    mass, rate = float(np.exp(rng.uniform(np.log(0.6), np.log(2.0)))), float(rng.uniform(8.0, 22.0))
    stiffness = mass * rate**2
    ratio = float(rng.uniform(0.08, 0.5))
    reach = float(rng.uniform(0.006, 0.02))
    damping = 2 * ratio * np.sqrt(stiffness * mass)
    return {"base_mass": mass, "stiffness": stiffness, "damping": float(damping), "force_gain": reach * stiffness / 0.5}


def true_positions(plan: stepid.Plan, effects: Any, errors: np.ndarray | None = None) -> list[np.ndarray]:
    campaign = plan.advice.campaign(plan.plant)
    runs = runs_like(
        campaign,
        base_mass=dict(plan.plant.base_mass),
        stiffness=dict(plan.plant.stiffness),
        damping=dict(plan.plant.damping),
        force_gain=plan.plant.force_gain,
        effects=effects,
    )
    if errors is not None:
        for run, error in zip(runs, errors, strict=True):
            object.__setattr__(run, "mass", run.mass + float(error))
    return fast(runs)


def weights(added: tuple[float, ...], spread: float, rng: np.random.Generator) -> np.ndarray:
    """Weights are put on one after another, each with its own error."""
    steps, place = np.unique(np.array(added), return_inverse=True)
    return np.cumsum(spread * np.sqrt(np.diff(steps, prepend=0.0) / WEIGHT) * rng.standard_normal(steps.size))[place]


def _head(*names: str) -> None:
    print("| " + " | ".join(names) + " |\n" + "| --- " * len(names) + "|")


def scatter(plants: int, count: int, seed: int, first: int, *, quick: bool, weighed: bool) -> None:
    every: list[float] = []
    print(
        "| plant | effect | noise, µm | weights, g | runs | every, ms | scatter over prediction |\n"
        + "| --- " * 7
        + "|"
    )
    for number in range(first, first + plants):
        rng = np.random.default_rng([seed, number])
        guess, noise = draw_guess(rng), float(np.exp(rng.uniform(np.log(5e-6), np.log(200e-6))))
        effect = EFFECTS[int(rng.integers(len(EFFECTS)))]
        spread = float(rng.choice([0.0, 0.005])) if weighed else 0.0
        plan = stepid.plan(
            guess,
            noise=noise,
            effects=() if effect is None else (effect,),
            weight_uncertainty=spread,
            runs=(int(rng.integers(2, 7)),),
            sample_times=(float(rng.choice([0.004, 0.01])),),
            duration=float(rng.uniform(2.0, 5.0)),
        )
        effects = {e.name: dict(e.values) for e in plan.plant.effects}
        clean = true_positions(plan, effects)
        found: list[Any] = []
        whole = simulated(
            plan.plant, resolve(list(effects)), lay_out_steps(plan.advice.steps, plan.plant, plan.advice.duration)
        )
        names = list(plan.advice.uncertainty)
        for _ in range(count):
            if spread:
                clean = true_positions(plan, effects, weights(plan.advice.added_masses, spread, rng))
            noisy = [x + noise * rng.standard_normal(x.size) for x in clean]
            if quick:
                found.append(refitted(plan, whole, np.concatenate(noisy)))
                continue
            campaign = plan.advice.campaign(plan.plant, positions=noisy, weight_uncertainty=spread or 1e-9)
            fitted = stepid.fit(campaign, effects=() if effect is None else (effect,))
            found.append([fitted.parameters[n].value for n in names])
        truth = np.array([plan.values[n] for n in names])
        error = np.sqrt(np.mean((np.array(found) - truth) ** 2, axis=0))
        ratios = error / np.array([plan.advice.uncertainty[n] for n in names], dtype=float)
        every += ratios.tolist()
        told = ", ".join(f"{n.partition('[')[0]} {r:.2f}" for n, r in zip(names, ratios, strict=True))
        print(
            f"| {number} | {effect or 'none'} | {noise * 1e6:.0f} | {spread * 1e3:g} | {plan.advice.runs} "
            f"| {plan.advice.sample_time * 1e3:g} | {told} |",
            flush=True,
        )
    inside = float(np.mean(np.abs(np.array(every) - 1) <= 0.15))
    print(f"{len(every)} parameters: {inside:.1%} within 15 %, chance alone spreads by {np.sqrt(0.5 / count):.1%};"
          f" mean {np.mean(every):.3f}, least {min(every):.2f}, largest {max(every):.2f}")  # fmt: skip


def pairs(count: int, seed: int, first: int) -> None:
    right = named = done = 0
    number = first
    print(
        "| case | truth | rival | noise, µm | runs | samples | left/noise | χ² promised | χ² found | diagnosis | |\n"
        + "| --- " * 11
        + "|"
    )
    while done < count:
        rng = np.random.default_rng([seed, 1, number])
        number += 1
        guess = draw_guess(rng)
        pair = PAIRS[int(rng.integers(len(PAIRS)))]
        pair = pair if rng.random() < 0.5 else pair[::-1]
        noise = float(np.exp(rng.uniform(np.log(20e-6), np.log(400e-6))))
        try:
            plan = stepid.plan(guess, noise=noise, separate=pair, wanted={}, runs=(2, 3, 4, 6, 8))
        except stepid.errors.StepidError as error:
            print(f"| {number - 1} | {pair[0]} | {pair[1]} | {noise * 1e6:.0f} | refused: {error} |")
            continue
        if not plan.suffices:
            print(f"| {number - 1} | {pair[0]} | {pair[1]} | {noise * 1e6:.0f} | no design suffices |", flush=True)
            continue
        which = int(rng.integers(2))
        truth = plan.pair[which]
        clean = true_positions(plan, {truth.name: dict(truth.values)})
        noisy = [x + noise * rng.standard_normal(x.size) for x in clean]
        campaign = plan.advice.campaign(plan.plant, positions=noisy)
        ends = [stepid.fit(campaign, effects=(name,)) for name in (truth.name, plan.pair[1 - which].name)]
        size = sum(e.time.size for e in campaign.experiments)
        apart = (ends[1].rms ** 2 - ends[0].rms ** 2) * size / noise**2
        began = time.process_time()
        said = stepid.diagnose(campaign)
        took = time.process_time() - began
        sets = (said.effects, *said.alternatives)
        rival = (plan.pair[1 - which].name,)
        good = said.effects == (truth.name,) and rival not in sets
        done, right, named = done + 1, right + (apart > 0), named + good
        print(
            f"| {number - 1} | {truth.name} | {rival[0]} | {noise * 1e6:.0f} | {plan.advice.runs} "
            f"| {plan.advice.samples} | {plan.advice.misfit:.2f} | {plan.advice.separation or 0.0:.0f} | {apart:.0f} "
            f"| {said.verdict} {' or '.join(' + '.join(s) for s in sets)} | {'yes' if good else 'NO'} {took:.1f} s |",
            flush=True,
        )
    print(f"{done} cases: the right one fits better in {right}, diagnosed without the rival in {named}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("what", choices=("scatter", "pairs"))
    parser.add_argument("--plants", type=int, default=10)
    parser.add_argument("--count", type=int, default=40)
    parser.add_argument("--seed", type=int, default=14)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--quick", action="store_true", help="begin each fit at the truth, without searching")
    parser.add_argument("--exact", action="store_true", help="exact weights: each plant is simulated once")
    given = parser.parse_args()
    if given.what == "scatter":
        scatter(given.plants, given.count, given.seed, given.first, quick=given.quick, weighed=not given.exact)
    else:
        pairs(given.count, given.seed, given.first)


if __name__ == "__main__":
    main()
