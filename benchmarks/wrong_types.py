"""Calls of every public function with one argument of a wrong type or value: only stepid's own errors may come out.

python benchmarks/wrong_types.py [calls] [seed]
"""

from __future__ import annotations

import random
import sys
import tempfile
import time
import warnings
from collections import Counter
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np

mpl.use("Agg")
import matplotlib.pyplot as plt

import stepid
from public_calls import Call, made, of_methods, of_models, of_readers
from public_calls_more import of_bridges, of_classes, of_pictures, of_results
from stepid.core.takes import described
from stepid.errors import StepidError

SLOWEST = 5.0  # s


def wrong_values(own: Any) -> list[Any]:
    """What an argument is not; some may be right by chance."""
    masked = np.ma.masked_greater(np.linspace(0, 1, 300), 0.9)
    return [
        None,
        0,
        -1,
        3,
        1.5,
        -2.5,
        float("nan"),
        float("inf"),
        10**400,
        True,
        1j,
        "",
        "x",
        "coulomb_friction",
        "\0",
        "../x",
        b"x",
        (),
        [],
        {},
        [None],
        ["x"],
        (1, 2),
        {"a": 1},
        {"case 1": None},
        set(),
        frozenset({1}),
        object(),
        type,
        len,
        lambda: 1,
        iter(()),
        np.array(1.0),
        np.zeros(300),
        np.full(300, np.nan),
        np.zeros((3, 3)),
        masked,
        np.array(["a"]),
        np.float32(1),
        np.int64(-3),
        Path("nowhere"),
        stepid.WeightedLeastSquares,
        stepid.InterpolatedPeak,
        stepid.StepInput(level=1.0),
        slice(3),
        range(3),
        ValueError("x"),
        10**5000,
        own,
    ]


def calls(folder: Path) -> list[Call]:
    """Each public function with arguments that are right."""
    folder.mkdir(exist_ok=True)
    m = made(folder)
    return [
        *of_models(m),
        *of_methods(m),
        *of_readers(m),
        *of_bridges(m),
        *of_classes(m),
        *of_pictures(m),
        *of_results(m),
    ]


def attack(folder: Path, count: int, seed: int, *, only: str = "") -> tuple[Counter[str], list[str]]:
    """Call `count` times; return how the calls ended, and what came out that is not stepid's."""
    prepared = [
        (function, arguments, name)
        for function, arguments in calls(folder)
        for name in arguments
        if only in f"{getattr(function, '__qualname__', function)}.{name}"
    ]
    every = [(f, a, n, i) for f, a, n in prepared for i in range(len(wrong_values(None)))]
    rng = random.Random(seed)
    chosen = rng.sample(every, min(count, len(every)))
    ends: Counter[str] = Counter()
    foreign = []
    for function, arguments, name, i in chosen:
        value = wrong_values(arguments[name])[i]
        who = f"{getattr(function, '__qualname__', function)}({name}={described(value)})"
        began = time.process_time()
        by_place = function.__name__ in ("__getitem__",)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                function(value) if by_place else function(**{**arguments, name: value})
            ends["accepted"] += 1
        except StepidError as error:
            ends["stepid's error"] += 1
            if not error.remedy:
                foreign.append(f"{who}: no remedy: {error}")
        except Exception as error:  # what is looked for
            ends["foreign"] += 1
            foreign.append(f"{who}: {type(error).__name__}: {str(error)[:100]}")
        if (took := time.process_time() - began) > SLOWEST:
            foreign.append(f"{who}: took {took:.1f} s")
        plt.close("all")
    return ends, foreign


def main() -> None:
    """Attack, and list what is wrong."""
    count, seed = (int(v) for v in [*sys.argv[1:3], *("4000", "1")[len(sys.argv[1:3]) :]])
    with tempfile.TemporaryDirectory() as scratch:
        ends, foreign = attack(Path(scratch), count, seed, only=sys.argv[3] if len(sys.argv) > 3 else "")
    print(*foreign, sep="\n")
    print(f"{sum(ends.values())} calls: {dict(ends)}; {len(foreign)} wrong")


if __name__ == "__main__":
    main()
