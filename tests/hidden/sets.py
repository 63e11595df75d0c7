"""The standing sets: effects in turn, none, pairs, triples, what is outside the catalogue, and all of it perturbed.

Sets that end in `-seen` draw only kinds that may be looked at while the diagnosis is developed; `outside-new` draws
only laws that may not.
"""

from __future__ import annotations

import hashlib
import pickle
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from .campaigns import Request, make_campaigns
from .draw import choose_kind
from .outside import DRIVEN_OUTSIDE, EVERY_OUTSIDE, NEW_OUTSIDE, OUTSIDE, SEEN_OUTSIDE
from .perturb import DRIVEN, HOLDS, choose
from .perturbed import CLEAREST, FAINTEST
from .plant import DRAWN, DRY, NAMES, NEW

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
LEGACY = ("single", "none", "pairs", "outside", "new")  # numbered seeds, unless a salt is given
PERTURBED = tuple(f"perturbed-{what}{seen}" for what in ("none", "single", "outside") for seen in ("", "-seen"))
SETS = (
    *LEGACY,
    "single-all",
    "pairs-all",
    "triples",
    "outside-seen",
    "outside-new",
    "outside-all",
    *PERTURBED,
)
_FIRST_SEED = {"single": 10_000, "none": 40_000, "pairs": 60_000, "outside": 80_000, "new": 120_000}
_OUTSIDE = {"outside": OUTSIDE, "outside-seen": SEEN_OUTSIDE, "outside-new": NEW_OUTSIDE, "outside-all": EVERY_OUTSIDE}
# bands of r0 that each effect goes through in turn; None is whatever a natural strength gives
_BANDS = ((2, 10), (1.1, 2), (10, 100), (1.0, 1.05), (5, 30), None, (1.1, 2), (2, 100))
Found = tuple[Any, dict[str, Any]]


def _visibility(seed: int, turn: int) -> float | None:
    band = _BANDS[turn % len(_BANDS)]
    if band is None:
        return None
    low, high = band
    return float(low * (high / low) ** np.random.default_rng([seed, 9]).random())


def seed_of(which: str, number: int, salt: str = "") -> int:
    """Seed of a campaign: from SHA-256 of salt, set and number; the old sets without a salt count on from a first."""
    if not salt and which in _FIRST_SEED:
        return _FIRST_SEED[which] + number
    return int.from_bytes(hashlib.sha256(f"{salt}/{which}/{number}".encode()).digest()[:6], "big")


def requests(which: str, count: int, *, skip: int = 0, salt: str = "") -> list[Request]:
    """`count` requests of a set; `skip` leaves out the first ones, for campaigns nobody has developed against."""
    if which not in SETS:
        raise KeyError(which)
    ask = _perturbed if which in PERTURBED else _plain
    return [replace(ask(which, i, seed_of(which, i, salt)), number=i) for i in range(skip, skip + count)]


def _plain(which: str, i: int, seed: int) -> Request:
    turns = {"single": NAMES, "new": NEW, "single-all": DRAWN}.get(which)
    if turns is not None:
        return Request(seed, (turns[i % len(turns)],), r0=_visibility(seed, i // len(turns)))
    if which in _OUTSIDE:
        laws = _OUTSIDE[which]
        return Request(seed, (), laws[i % len(laws)])
    if which == "pairs":
        return Request(seed, PAIRS[i % len(PAIRS)])
    if which in ("pairs-all", "triples"):
        return Request(seed, _several(seed, 2 if which == "pairs-all" else 3))
    return Request(seed)


def _several(seed: int, count: int) -> tuple[str, ...]:
    """Different effects of the whole catalogue, at most one of them plain dry friction: two would be one."""
    rng = np.random.default_rng([seed, 10])
    while True:
        some = tuple(str(name) for name in rng.choice(DRAWN, size=count, replace=False))
        if len(set(some) & set(DRY)) < 2:
            return some


def _perturbed(which: str, i: int, seed: int) -> Request:
    """A perturbed campaign; protocols without what its kinds need are drawn anew."""
    rng = np.random.default_rng([seed, 11])
    what, seen = which.removeprefix("perturbed-").removesuffix("-seen"), which.endswith("-seen")
    effects = (DRAWN[i % len(DRAWN)],) if what == "single" else ()
    laws = SEEN_OUTSIDE if seen else EVERY_OUTSIDE
    outside = laws[i % len(laws)] if what == "outside" else None
    kinds = choose(rng, i, effects, outside, seen=seen)
    needs = ("actuator_lag",) if outside in DRIVEN_OUTSIDE or set(kinds) & set(DRIVEN) else ()
    kind = "release" if set(kinds) & set(HOLDS) else choose_kind(rng, (*effects, *needs))
    r0 = float(np.exp(rng.uniform(np.log(FAINTEST), np.log(CLEAREST)))) if what == "single" else None
    return Request(seed, effects, outside, r0, kind, kinds)


def one(which: str, number: int, salt: str = "") -> Found:
    """Campaign and truth of the given number in a set."""
    return make(requests(which, 1, skip=number, salt=salt))[0]


def make(
    wanted: Sequence[Request],
    *,
    executor: Executor | None = None,
    chunk: int = 100,
    progress: Callable[[int], object] = lambda done: None,
) -> list[Found]:
    """Campaigns and truths, in chunks; an executor spreads the chunks."""
    pieces = [wanted[i : i + chunk] for i in range(0, len(wanted), chunk)]
    made: list[Found] = []
    for some in map(make_campaigns, pieces) if executor is None else executor.map(make_campaigns, pieces):
        made.extend(some)
        progress(len(made))
    return made


def cached(
    folder: Path | None, which: str, count: int, *, skip: int = 0, salt: str = "", **options: Any
) -> list[Found]:
    """The set from `folder` if it is there, else made (and kept there)."""
    file = None if folder is None else folder / "-".join([which, *filter(None, [salt]), str(skip), f"{count}.pkl"])
    if file is not None and file.exists():
        found: list[Found] = pickle.loads(file.read_bytes())
        return found
    made = make(requests(which, count, skip=skip, salt=salt), **options)
    if file is not None:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(pickle.dumps(made))
    return made
