"""The standing sets: every effect in turn, none, pairs, what is outside the catalogue, the new effects in turn."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from pathlib import Path
from typing import Any

import numpy as np

from .campaigns import Request, make_campaigns
from .outside import OUTSIDE
from .plant import NAMES, NEW

PAIRS = (
    ("coulomb_friction", "cubic_stiffness"),
    ("coulomb_friction", "quadratic_damping"),
    ("coulomb_friction", "viscoelastic_spring"),
    ("coulomb_friction", "flexible_coupling"),
    ("coulomb_friction", "actuator_lag"),
    ("coulomb_friction", "periodic_disturbance"),
    ("coulomb_friction", "sensor_drift"),
    ("load_proportional_friction", "end_stop"),
    ("cubic_stiffness", "quadratic_damping"),
    ("input_delay", "cubic_stiffness"),
    ("coulomb_friction", "quadratic_stiffness"),
    ("coulomb_friction", "position_dependent_damping"),
    ("coulomb_friction", "input_delay"),
    ("coulomb_friction", "free_play"),
    ("coulomb_friction", "cogging"),
    ("asymmetric_friction", "viscoelastic_spring"),
    ("actuator_lag", "cubic_stiffness"),
    ("load_proportional_friction", "periodic_disturbance"),
    ("viscoelastic_spring", "sensor_drift"),
    ("stribeck_friction", "flexible_coupling"),
)
SETS = ("single", "none", "pairs", "outside", "new")
_FIRST_SEED = {"single": 10_000, "none": 40_000, "pairs": 60_000, "outside": 80_000, "new": 120_000}
# bands of r0 that each effect goes through in turn; None is whatever a natural strength gives
_BANDS = ((2, 10), (1.1, 2), (10, 100), (1.0, 1.05), (5, 30), None, (1.1, 2), (2, 100))
Found = tuple[Any, dict[str, Any]]


def _visibility(seed: int, turn: int) -> float | None:
    band = _BANDS[turn % len(_BANDS)]
    if band is None:
        return None
    low, high = band
    return float(low * (high / low) ** np.random.default_rng([seed, 9]).random())


def requests(which: str, count: int, *, skip: int = 0) -> list[Request]:
    """`count` requests of a set; `skip` leaves out the first ones, for campaigns nobody has developed against."""
    seeds = range(skip, skip + count)
    first = _FIRST_SEED[which]
    if which == "single":
        return [Request(first + i, (NAMES[i % len(NAMES)],), r0=_visibility(first + i, i // len(NAMES))) for i in seeds]
    if which == "new":
        return [Request(first + i, (NEW[i % len(NEW)],), r0=_visibility(first + i, i // len(NEW))) for i in seeds]
    if which == "none":
        return [Request(first + i) for i in seeds]
    if which == "pairs":
        return [Request(first + i, PAIRS[i % len(PAIRS)]) for i in seeds]
    if which == "outside":
        return [Request(first + i, (), OUTSIDE[i % len(OUTSIDE)]) for i in seeds]
    raise KeyError(which)


def one(which: str, number: int) -> Found:
    """Campaign and truth of the given number in a set."""
    return make(requests(which, 1, skip=number), which=which)[0]


def make(
    wanted: Sequence[Request],
    *,
    which: str = "",
    executor: Executor | None = None,
    chunk: int = 100,
    progress: Callable[[int], object] = lambda done: None,
) -> list[Found]:
    """Campaigns and truths, in chunks; an executor spreads the chunks."""
    pieces = [wanted[i : i + chunk] for i in range(0, len(wanted), chunk)]
    made: list[Found] = []
    for some in map(make_campaigns, pieces) if executor is None else executor.map(make_campaigns, pieces):
        for _, truth in some:
            truth["number"] = truth["seed"] - _FIRST_SEED.get(which, 0)
        made.extend(some)
        progress(len(made))
    return made


def cached(folder: Path | None, which: str, count: int, *, skip: int = 0, **options: Any) -> list[Found]:
    """The set from `folder` if it is there, else made (and kept there)."""
    file = None if folder is None else folder / f"{which}-{skip}-{count}.pkl"
    if file is not None and file.exists():
        found: list[Found] = pickle.loads(file.read_bytes())
        return found
    made = make(requests(which, count, skip=skip), which=which, **options)
    if file is not None:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(pickle.dumps(made))
    return made
