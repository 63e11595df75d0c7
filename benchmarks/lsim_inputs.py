"""Records made by `scipy.signal.lsim`, which joins the samples of an input by straight lines, diagnosed both ways.

    python benchmarks/lsim_inputs.py [draws]

Seven kinds of input that change all the time, linear plants and runs with three masses, three draws of each. With
``input_between="lines"`` a campaign must be adequate; with "held", which is the default, the fault must be told and no
effect named. Printed is every campaign that is neither, and how many are right.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")

import sys
from collections.abc import Callable
from typing import Literal

import numpy as np
from scipy.signal import lsim

import stepid

PERIOD, SAMPLES = 0.0088542, 450
TIME = PERIOD * np.arange(SAMPLES, dtype=np.float64)
MASSES = (0.0, 0.5, 1.0)  # kg, added
INPUTS: dict[str, Callable[[np.random.Generator], np.ndarray]] = {
    "multisine": lambda rng: 0.15 * np.sum([_sine(f, rng) for f in (0.4, 1.1, 1.9, 2.7, 4.3)], axis=0),
    "slow sine": lambda rng: 0.4 * _sine(0.5, rng),
    "sine near resonance": lambda rng: 0.2 * _sine(rng.uniform(1.5, 2.5), rng),
    "sweep": lambda rng: 0.4 * np.sin(2 * np.pi * (0.2 * TIME + 0.6 * TIME**2) + rng.uniform(0, 6)),
    "random": lambda rng: 0.5 * rng.standard_normal(SAMPLES),
    "ramps": lambda rng: rng.uniform(0.3, 0.7) * np.abs((TIME + rng.uniform(0, 2)) % 2 - 1),
    "smoothed random": lambda rng: np.convolve(rng.standard_normal(SAMPLES + 19), np.full(20, 0.1), "valid"),
}
Way = Literal["held", "lines"]


def _sine(frequency: float, rng: np.random.Generator) -> np.ndarray:
    return np.asarray(np.sin(2 * np.pi * frequency * TIME + rng.uniform(0, 6)))


def campaign(kind: str, draw: int) -> stepid.Campaign:
    rng = np.random.default_rng([sorted(INPUTS).index(kind), draw])
    stiffness, damping, gain = rng.uniform((100, 3, 5), (400, 12, 10)).tolist()
    noise = 10 ** rng.uniform(-5.5, -4.5)
    runs = []
    for added in MASSES:
        volts, mass = INPUTS[kind](rng), 0.95 + added
        plant = [[0.0, 1.0], [-stiffness / mass, -damping / mass]], [[0.0], [gain / mass]], [[1.0, 0.0]], [[0.0]]
        _, position, _ = lsim(plant, volts, TIME)
        position = position + noise * rng.standard_normal(SAMPLES)
        runs.append(
            stepid.Experiment(
                name=f"{added:g} kg",
                time=TIME,
                position=position,
                input=volts,
                added_mass=added,
                spring="s",
                damper="d",
            )
        )
    return stepid.Campaign(name=f"{kind} {draw}", experiments=tuple(runs))


def said(made: stepid.Campaign, way: Way) -> tuple[bool, str]:
    """Whether the diagnosis is right, and what it says."""
    runs = tuple(run.model_copy(update={"input_between": way}) for run in made.experiments)
    d = stepid.diagnose(made.model_copy(update={"experiments": runs}))
    told = any("joined by straight lines" in note for note in d.notes)
    words = f"{d.verdict} {list(d.effects)} {[list(a) for a in d.alternatives]}, fault {'told' if told else 'not told'}"
    if way == "lines":
        return d.verdict == "adequate" and not told, words
    return told and not d.effects and not d.alternatives, words


def main(draws: int) -> None:
    right = dict.fromkeys(("lines", "held"), 0)
    for kind in INPUTS:
        for draw in range(draws):
            for way in ("lines", "held"):
                good, words = said(campaign(kind, draw), way)
                right[way] += good
                if not good:
                    print(f"{kind} {draw}, {way}: {words}", flush=True)
    total = draws * len(INPUTS)
    print(f"said to be lines: {right['lines']} of {total} adequate; said to be held: {right['held']} of {total} told")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 3)
