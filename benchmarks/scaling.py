"""How the time and the memory of a joint fit grow with samples and with runs.

    python benchmarks/scaling.py            exponents from 10³ to 10⁵ samples a run, from 4 to 64 runs
    python benchmarks/scaling.py --large    four runs of 10⁵ samples: CPU time and memory

The plant is the paper's with 0.3 N of Coulomb friction, 20 µm of white noise; the fit knows the effect. Times are those
of warm processes; memory is the largest resident set of a process of its own, above that after loading the data.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")

import argparse
import resource
import time

import numpy as np

import stepid

DURATION = 4.0
MODEL = stepid.PlantModel(
    base_mass={"cart": 0.95},
    stiffness={"medium": 216.0},
    damping={"plug": 12.0},
    force_gain=7.8,
    effects=(stepid.EffectModel(name="coulomb_friction", values={"level": 0.3}),),
)


def campaign(samples: int, runs: int) -> stepid.Campaign:
    time_ = DURATION / samples * np.arange(samples)
    volts = np.where((time_ > 0.1) & (time_ < 2.1), 0.5, 0.0)
    noise = np.random.default_rng([samples, runs])

    def run(i: int, position: np.ndarray) -> stepid.Experiment:
        return stepid.Experiment(
            name=f"run {i}",
            time=time_,
            position=position,
            input=volts,
            added_mass=2.0 * i / max(runs - 1, 1),
            spring="medium",
            damper="plug",
        )

    still = stepid.Campaign(name="scaling", experiments=tuple(run(i, np.zeros(samples)) for i in range(runs)))
    clean = stepid.simulate(MODEL, still)
    noisy = [run(i, x + 2e-5 * noise.standard_normal(samples)) for i, x in enumerate(clean.values())]
    return stepid.Campaign(name="scaling", experiments=tuple(noisy))


def seconds(samples: int, runs: int, repeats: int) -> float:
    data = campaign(samples, runs)
    best = np.inf
    for _ in range(repeats):
        start = time.process_time()
        found = stepid.fit(data, effects=["coulomb_friction"])
        best = min(best, time.process_time() - start)
    error = abs(found.parameters["coulomb_friction.level"].value - 0.3)
    sure = found.parameters["coulomb_friction.level"].uncertainty
    print(f"{runs:3d} runs of {samples:6d} samples: {best:7.3f} s CPU, level off by {error / sure:.1f} standard errors")
    return best


def exponent(sizes: list[int], times: list[float]) -> float:
    return float(np.polyfit(np.log(sizes), np.log(times), 1)[0])


def main(large: bool) -> None:
    seconds(1000, 4, 1)  # compiled, loaded
    if large:
        data = campaign(100_000, 4)
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        start = time.process_time()
        stepid.fit(data, effects=["coulomb_friction"])
        spent = time.process_time() - start
        after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        per = (after - before) * 1024 / 400_000
        print(f"4 runs of 100000 samples: {spent:.2f} s CPU (asked 8), {after / 1024:.0f} MB (600), {per:.0f} bytes")
        print("a sample above the data (600)")
        return
    samples = [1000, 3000, 10_000, 30_000, 100_000]
    times = [seconds(n, 4, 3 if n < 20_000 else 1) for n in samples]
    print(f"exponent from 10³ to 10⁵ samples: {exponent(samples, times):.2f} (asked 1.05)")
    runs = [4, 8, 16, 32, 64]
    times = [seconds(1000, n, 3 if n < 20 else 1) for n in runs]
    print(f"exponent from 4 to 64 runs: {exponent(runs, times):.2f} (asked 1.05)")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--large", action="store_true")
    main(parser.parse_args().large)
