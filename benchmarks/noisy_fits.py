"""Fits of fast, noisy records: is the truth within the uncertainty that `stepid.fit` gives?

    python benchmarks/noisy_fits.py [campaigns]

The paper's plant (base mass 0.95 kg, 216 N/m, 12 N·s/m), linear and with 0.3 N of Coulomb friction, four masses,
steps of 0.5 V up and back. The sample time goes from 0.5 to 18 ms, white noise from 5 to 500 µm; the true effects are
given. Listed are campaigns off by more than five standard errors, those in which something is not determined, and
those that say that they converged with more than twice the noise left.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")

import sys
import time
from itertools import product
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

import stepid
from hidden.fast import fast
from hidden.plant import Run

SAMPLE_TIMES = (0.5e-3, 0.885e-3, 1.77e-3, 4.427e-3, 8.854e-3, 18e-3)
NOISES = (5e-6, 20e-6, 50e-6, 100e-6, 200e-6, 500e-6)
EFFECTS = ({}, {"coulomb_friction": {"level": 0.3}})
DURATION = 4.0
TRUTH = {"base_mass": 0.95, "stiffness[medium]": 216.0, "damping[1/2 turn]": 12.0, "force_gain": 7.8}


def clean(sample_time: float, effects: dict[str, dict[str, float]]) -> list[tuple[float, np.ndarray, np.ndarray]]:
    """Added mass, input and position of four runs."""
    n = round(DURATION / sample_time)
    inputs = np.repeat([0.0, 0.5, 0.0], [n // 20, n // 2, n - n // 20 - n // 2])
    masses = (0.0, 0.5, 1.5, 2.0)
    runs = [Run(0.95 + added, 216.0, 12.0, 7.8, sample_time, inputs, effects) for added in masses]
    return [(added, inputs, x) for added, x in zip(masses, fast(runs), strict=True)]


Records = list[tuple[float, np.ndarray, np.ndarray]]


def campaign(records: Records, sample_time: float, noise: float, seed: int) -> stepid.Campaign:
    rng = np.random.default_rng([seed, 12])
    return stepid.Campaign(
        name=f"noisy {seed}",
        experiments=tuple(
            stepid.Experiment(
                name=f"run {i + 1}",
                time=sample_time * np.arange(u.size),
                position=x + noise * rng.standard_normal(x.size),
                input=u,
                added_mass=added,
                spring="medium",
                damper="1/2 turn",
            )
            for i, (added, u, x) in enumerate(records)
        ),
    )


def main(count: int) -> None:
    cells = list(product(EFFECTS, SAMPLE_TIMES, NOISES))
    known: dict[tuple[str, float], list[tuple[float, np.ndarray, np.ndarray]]] = {}
    off = open_ = unsure = 0
    deviations: list[float] = []
    start = time.process_time()
    for number in range(count):
        effects, sample_time, noise = cells[number % len(cells)]
        key = ("+".join(effects), sample_time)
        if key not in known:
            known[key] = clean(sample_time, effects)
        say = f"{number}: T = {sample_time * 1e3:g} ms, {noise * 1e6:g} µm, {key[0] or 'linear'}"
        try:
            found = stepid.fit(campaign(known[key], sample_time, noise, number), effects=tuple(effects))
        except stepid.errors.StepidError as error:
            print(f"{say}: {error}")
            open_ += 1
            continue
        truth = TRUTH | {f"{e}.{p}": v for e, values in effects.items() for p, v in values.items()}
        estimates = {name: found.parameters[name] for name in truth}
        lost = [name for name, e in estimates.items() if e.uncertainty is None]
        z = {n: (e.value - truth[n]) / e.uncertainty for n, e in estimates.items() if e.uncertainty}
        deviations += [abs(v) for v in z.values()]
        worst = max(z, key=lambda n: abs(z[n]), default="")
        if worst and abs(z[worst]) > 5:
            off += 1
            print(
                f"{say}: {worst} is {estimates[worst].value:.4g} ± {estimates[worst].uncertainty:.2g}, {z[worst]:+.1f}"
            )
        if lost:
            open_ += 1
            print(f"{say}: not determined: {', '.join(lost)}")
        if found.converged and found.rms > 2 * found.noise:
            unsure += 1
            print(f"{say}: converged at {found.rms / found.noise:.2f} times the noise")
    inside = np.mean(np.array(deviations) < 1.96)
    print(f"{count} campaigns: {off} off by more than 5 standard errors (at most 1), {open_} not determined", end=" ")
    print(
        f"(at most {count // 50}), {unsure} converged above 2 floors (0); 95 % intervals cover {inside:.1%}", end="; "
    )
    print(f"{time.process_time() - start:.0f} s CPU")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 1000)
