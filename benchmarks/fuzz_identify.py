"""Mutated campaigns to `stepid.identify`: nothing but stepid's errors, none slower than 5 s.

python benchmarks/fuzz_identify.py [CASES] [SEED]
"""

from __future__ import annotations

import sys
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Callable
from typing import Any

import numpy as np

import stepid
from public_calls import record
from stepid.errors import StepidError

SLOWEST = 5.0  # s CPU
Fields = dict[str, Any]
Act = Callable[[Fields, np.random.Generator], None]
HARD = (0.0, -1.0, 1e-300, 1e-12, 1e-3, 1e3, 1e9, 1e150, 1e300, -1e300, np.pi)


def part(n: int, rng: np.random.Generator) -> slice:
    """A stretch of a record."""
    a, b = np.sort(rng.integers(0, n + 1, 2))
    return slice(int(a), int(b))


def any_array(f: Fields, rng: np.random.Generator) -> str:
    """Which of the three arrays."""
    return str(rng.choice(["position", "position", "input", "time"]))


def scaled(f: Fields, rng: np.random.Generator) -> None:
    f[any_array(f, rng)] *= rng.choice(HARD)


def shifted(f: Fields, rng: np.random.Generator) -> None:
    f[any_array(f, rng)] += rng.choice(HARD)


def spiked(f: Fields, rng: np.random.Generator) -> None:
    values = f[any_array(f, rng)]
    values[rng.integers(values.size, size=rng.integers(1, 5))] = rng.choice([*HARD, np.nan, np.inf])


def frozen(f: Fields, rng: np.random.Generator) -> None:
    values = f[any_array(f, rng)]
    values[part(values.size, rng)] = rng.choice([0.0, values[0], values[-1]])


def noisy(f: Fields, rng: np.random.Generator) -> None:
    values = f[any_array(f, rng)]
    values += 10.0 ** rng.uniform(-9, 3) * rng.standard_normal(values.size)


def cut(f: Fields, rng: np.random.Generator) -> None:
    kept = part(f["time"].size, rng)
    for name in ("time", "position", "input"):
        f[name] = f[name][kept].copy()


def uneven(f: Fields, rng: np.random.Generator) -> None:
    f["time"] = np.cumsum(10.0 ** rng.uniform(-4, -1, f["time"].size))


def turned(f: Fields, rng: np.random.Generator) -> None:
    name = any_array(f, rng)
    f[name] = f[name][::-1].copy()


def walk(f: Fields, rng: np.random.Generator) -> None:
    f["position"] = 1e-4 * np.cumsum(rng.standard_normal(f["time"].size))


def steps(f: Fields, rng: np.random.Generator) -> None:
    levels = rng.choice([0.0, 0.5, -0.5, 1e-9, 3.0], f["time"].size // int(rng.integers(1, 60)) + 1)
    f["input"] = np.resize(np.repeat(levels, rng.integers(1, 60)), f["time"].size)


def clipped(f: Fields, rng: np.random.Generator) -> None:
    f["position"] = np.clip(f["position"], *np.sort(rng.choice(f["position"], 2)))


def coarse(f: Fields, rng: np.random.Generator) -> None:
    step = 10.0 ** rng.uniform(-7, 0)
    f["position"] = np.round(f["position"] / step) * step


def swung(f: Fields, rng: np.random.Generator) -> None:
    t, w, z = f["time"], 10.0 ** rng.uniform(-1, 3), rng.choice([-0.1, 0.0, 1e-4, 0.01, 0.3, 1.0, 5.0])
    with np.errstate(all="ignore"):
        f["position"] = 10.0 ** rng.uniform(-6, 1) * np.exp(-z * w * t) * np.cos(w * t)


def field(f: Fields, rng: np.random.Generator) -> None:
    name = rng.choice(["added_mass", "input_before", "counts_per_meter"])
    f[str(name)] = float(rng.choice(HARD))


def label(f: Fields, rng: np.random.Generator) -> None:
    choices = {"spring": "stiff", "damper": "none", "base": "other", "input_between": "smooth", "starts": "motion"}
    name = str(rng.choice(list(choices)))
    f[name] = choices[name]


ACTS: tuple[Act, ...] = (
    scaled, shifted, spiked, frozen, noisy, cut, uneven, turned, walk, steps, clipped, coarse, swung, field, label,
)  # fmt: skip
RUNS = tuple(
    record(f"run {i}", added, volts=volts, seed=i)
    for i, (added, volts) in enumerate(((0.0, 0.5), (0.5, -0.5), (1.5, 0.5)))
)


def campaign(rng: np.random.Generator) -> stepid.Campaign:
    """A good campaign with some of its runs damaged."""
    experiments = []
    for run in RUNS[: rng.integers(1, 4)]:
        f = {name: getattr(run, name) for name in type(run).model_fields}
        f |= {name: f[name].copy() for name in ("time", "position", "input")}
        for _ in range(rng.choice([0, 1, 1, 2, 4])):
            if f["time"].size:
                ACTS[rng.integers(len(ACTS))](f, rng)
        experiments.append(stepid.Experiment(**f))
    return stepid.Campaign(name="mutated", experiments=experiments)


def main() -> None:
    """Attack, and list what is wrong."""
    cases, seed = (int(v) for v in [*sys.argv[1:3], *("5000", "1")[len(sys.argv[1:3]) :]])
    ends: Counter[str] = Counter()
    slowest = 0.0
    for i in range(cases):
        rng = np.random.default_rng((seed, i))
        try:
            with np.errstate(all="ignore"):
                damaged = campaign(rng)
        except StepidError:
            ends["refused as a record"] += 1
            continue
        began = time.process_time()
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                stepid.identify(damaged)
            ends["identified"] += 1
        except StepidError as error:
            ends["refused"] += 1
            if not error.cause:
                print(i, "mute", repr(error))
        except Exception:
            ends["foreign"] += 1
            print(i, traceback.format_exc(limit=-3), flush=True)
        if i % 500 == 499:
            print(i + 1, dict(ends), f"{slowest:.2f} s", flush=True)
        slowest = max(slowest, time.process_time() - began)
    print(f"{cases} campaigns: {dict(ends)}; the slowest took {slowest:.2f} s CPU")
    sys.exit(bool(ends["foreign"]) or slowest > SLOWEST)


if __name__ == "__main__":
    main()
