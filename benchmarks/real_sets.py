"""Recordings of real one-mass plants, made by others: read from a folder beside the project, never part of it.

The environment variable `STEPID_REAL_DATA` names the folder. Every cut is the one that its README gives.
"""

from __future__ import annotations

import itertools
import math
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

import stepid
from stepid import Campaign, Diagnosis, Experiment

IMITATORS = {"periodic_disturbance", "cogging", "free_play"}
DRY = {
    "coulomb_friction",
    "load_proportional_friction",
    "asymmetric_friction",
    "stribeck_friction",
    "presliding_hysteresis",
}
DAMPING = {"quadratic_damping", "power_damping", "position_dependent_damping"}
MODES = {"flexible_coupling", "viscoelastic_spring"}
COUNTS = 56000.0  # per m, ECP Model 210
_SILVERBOX_STEP = 2**14 / 1e7  # s
_SILVERBOX_OFFSET = 6.182e-3  # V, mean of the whole record's input
_AMPLIFIER_OFF = 980  # samples of one record of steps, at which the plant rests although 3 V is recorded


@dataclass(frozen=True)
class RealSet:
    """One campaign of a real plant: where it is from, what is known of it, and what a good answer says.

    Parameters
    ----------
    name, source, known : str
        Of the set; where it was published; what its plant is known to do.
    build : callable
        Reads the campaign.
    unit : tuple of str and float
        Unit that positions are told in, and how many of it are 1.
    most : float
        In that unit: what a good answer leaves at most, RMS; inf where nothing is asked.
    right : callable
        Whether the effects of a diagnosis are right.
    """

    name: str
    source: str
    known: str
    build: Callable[[], Campaign]
    unit: tuple[str, float]
    most: float
    right: Callable[[Diagnosis], bool]


def folder(variable: str = "STEPID_REAL_DATA") -> Path:
    """Folder of recordings that an environment variable names; FileNotFoundError where it is not known."""
    named = os.environ.get(variable)
    if not named:
        raise FileNotFoundError(f"{variable} does not name the folder of real recordings")
    return Path(named)


# ---- campaigns ----------------------------------------------------------------------------------------------------


def roll(seconds: float) -> Campaign:
    """Two roll decays of a ship model, position in rad, from the first extreme after the release on."""
    runs = []
    for number in (21337, 21338):
        time, angle = np.loadtxt(
            folder() / "roll-kvlcc2" / f"model_test_{number}.csv", delimiter=",", skiprows=1, unpack=True
        )
        first = int(np.argmax(np.abs(angle)))
        last = int(np.searchsorted(time, time[first] + seconds))
        runs.append(record(str(number), time[first:last], angle[first:last], starts="motion"))
    return Campaign(name="roll", experiments=tuple(runs))


def silverbox(kind: str, between: Literal["smooth", "lines"]) -> Campaign:
    """Three slices of one long driven record, position in V; each starts in motion."""
    runs = []
    for number in (1, 2, 3):
        file = folder() / "silverbox" / f"{kind}-{number}.csv"
        volts, position = np.loadtxt(file, delimiter=",", skiprows=1, unpack=True)
        time = np.arange(volts.size) * _SILVERBOX_STEP
        run = record(file.stem, time, position, volts=volts - _SILVERBOX_OFFSET, starts="motion")
        runs.append(run.model_copy(update={"input_between": between}))
    return Campaign(name=f"silverbox {kind}", experiments=tuple(runs))


def pendulum() -> Campaign:
    """Three free swings of a pendulum, position in rad, from where the hand is off."""
    runs = []
    for number, begin in ((1, 400), (2, 300), (3, 300)):
        file = folder() / "pendulum-freeswing" / f"pendulum_free_swing_data_{number:02}.txt"
        angle = np.radians(np.loadtxt(file, skiprows=2))[begin:]
        runs.append(record(f"swing {number}", 1e-3 * np.arange(angle.size), angle, starts="motion"))
    return Campaign(name="pendulum", experiments=tuple(runs))


def milan_releases(spring: str) -> Campaign:
    """Six hand releases with one spring, three of them with two weights."""
    runs = []
    for place in sorted((folder() / "ecp210-milan" / "free-release").glob(f"K{spring}_hand_*")):
        position = 0.01 * np.concatenate([np.loadtxt(file) for file in sorted(place.glob("data*.txt"))])
        added = 0.986 if "2mass" in place.name else 0.0
        run = record(place.name, 0.005 * np.arange(position.size), position, added=added, counts=COUNTS)
        runs.append(run)
    return Campaign(name=f"Milan releases, {spring}", experiments=tuple(runs))


def milan_steps() -> Campaign:
    """Square waves of 3 V with two springs, each with and without two weights."""
    runs = []
    for place in sorted((folder() / "ecp210-milan" / "steps").iterdir()):
        table = np.concatenate([np.loadtxt(file) for file in sorted(place.glob("data*.txt"))])
        first = _AMPLIFIER_OFF if place.name == "steps_kmed_nomass" else 0
        added = 0.986 if "2mass" in place.name else 0.0
        time = 0.005 * np.arange(len(table))
        run = record(
            place.name, time, -table[:, 2] / COUNTS, volts=table[:, 0], added=added, counts=-COUNTS,
            spring="high" if "kbig" in place.name else "medium",
        )  # fmt: skip
        runs.append(run.slice(first) if first else run)
    return Campaign(name="Milan steps", experiments=tuple(runs))


def ucsd(which: Literal["steps", "releases"]) -> Campaign:
    """Genuine exports of the ECP program: three steps of one cart, or three hand releases of the other."""
    pattern, encoder = ("DOF1_en1_input1_test*.csv", 1) if which == "steps" else ("DOF1_en2_manual2_test*.csv", 2)
    files = sorted((folder() / "ecp210-ucsd").glob(pattern))
    if which == "steps":
        files.append(folder() / "ecp210-ucsd" / "test_2_1.csv")
    runs = tuple(stepid.read_ecp(file, counts_per_meter=-COUNTS, encoder=encoder) for file in files)
    return Campaign(name=f"ucsd {which}", experiments=runs)


def trento() -> Campaign:
    """The first of three carts in series, four steps of 5 s with pauses of 5 s."""
    time, first, _, _, volts = np.loadtxt(folder() / "ecp210-trento" / "data_steps.txt", unpack=True)
    whole = record("steps", time, first / 226600.0, volts=volts, counts=226600.0)
    edges = [*range(0, time.size - 1000, 2000), time.size]
    parts = itertools.pairwise(edges)
    runs = tuple(whole.slice(a, b, name=f"step {i}") for i, (a, b) in enumerate(parts, 1))
    return Campaign(name="Trento", experiments=runs)


def record(
    name: str,
    time: np.ndarray,
    position: np.ndarray,
    *,
    volts: np.ndarray | None = None,
    added: float = 0.0,
    counts: float | None = None,
    spring: str = "spring",
    starts: Literal["auto", "motion"] = "auto",
) -> Experiment:
    return Experiment(
        name=name,
        time=time,
        position=position,
        input=np.zeros(time.size) if volts is None else volts,
        added_mass=added,
        spring=spring,
        damper="own",
        counts_per_meter=counts,
        starts=starts,
    )


# ---- what a good answer says --------------------------------------------------------------------------------------


def named(effects: tuple[str, ...], alternatives: tuple[tuple[str, ...], ...]) -> str:
    """The sets of an answer in one line; "none" where nothing is named."""
    return " or ".join(" + ".join(one) for one in (effects, *alternatives)) or "none"


def value(d: Diagnosis, name: str) -> float:
    """One parameter of the answer; NaN where it has none of that name."""
    return d.parameters[name].value if name in d.parameters else math.nan


def _hull_damping(d: Diagnosis) -> bool:
    effects = set(d.effects)
    power = "power_damping" in effects and 1.5 <= value(d, "power_damping.exponent") <= 3
    return d.verdict in ("named", "ambiguous") and not effects & IMITATORS and ("quadratic_damping" in effects or power)


def _hull_damping_or_rest(d: Diagnosis) -> bool:
    return d.verdict == "unexplained" or _hull_damping(d)


def _cubic_spring(share: float) -> Callable[[Diagnosis], bool]:
    def right(d: Diagnosis) -> bool:
        stiffness = next((e.value for name, e in d.parameters.items() if name.startswith("stiffness")), math.nan)
        ratio = value(d, "cubic_stiffness.coefficient") / stiffness
        named = d.verdict == "named" and d.effects == ("cubic_stiffness",) and not d.alternatives
        return named and abs(ratio / 3.95 - 1) <= share

    return right


def _sine_and_damping(d: Diagnosis) -> bool:
    curvature = value(d, "sine_stiffness.curvature")
    return d.verdict in ("named", "ambiguous") and bool(set(d.effects) & (DRY | DAMPING)) and abs(curvature - 1) <= 0.01


def _dry(d: Diagnosis) -> bool:
    return d.verdict in ("named", "ambiguous") and bool(set(d.effects) & DRY) and not set(d.effects) & IMITATORS


def _mode_or_unexplained(d: Diagnosis) -> bool:
    return d.verdict == "unexplained" or set(d.effects) <= MODES


_HULL = "SSPA, KVLCC2 at 1:68 (Mendeley Data 10.17632/2stvkyngj9.1)"
_BOX = "Wigren and Schoukens, ECC 2013 (nonlinearbenchmark.org)"
_MILAN = "rssalessio/Control-Linear-Vibrations, Politecnico di Milano"
_UCSD = "Parker-Knopf/MAE171A, UC San Diego"
_MRAD, _MV, _UM = ("mrad", 1e3), ("mV", 1e3), ("µm", 1e6)

_ALL = (
    RealSet(
        "roll-44s", _HULL, "quadratic damping, a slightly hardening spring",
        lambda: roll(44.0), _MRAD, 0.50, _hull_damping,
    ),
    RealSet("roll-whole", _HULL, "the same", lambda: roll(math.inf), _MRAD, 1.45, _hull_damping_or_rest),
    RealSet(
        "silverbox-multisine-smooth", _BOX, "cubic spring, k₃/k = 3.95 V⁻²",
        lambda: silverbox("multisine", "smooth"), _MV, 0.40, _cubic_spring(0.01),
    ),
    RealSet(
        "silverbox-multisine-lines", _BOX, "the same",
        lambda: silverbox("multisine", "lines"), _MV, 0.95, _cubic_spring(0.02),
    ),
    RealSet(
        "silverbox-arrow-smooth", _BOX, "the same",
        lambda: silverbox("arrow", "smooth"), _MV, 0.50, _cubic_spring(0.01),
    ),
    RealSet(
        "silverbox-arrow-lines", _BOX, "the same",
        lambda: silverbox("arrow", "lines"), _MV, 1.25, _cubic_spring(0.02),
    ),
    RealSet(
        "pendulum", "jensen-benard/rotary-inverted-pendulum", "sine of the angle, dry friction and air drag",
        pendulum, _MRAD, 14.0, _sine_and_damping,
    ),
    RealSet("milan-releases-high", _MILAN, "dry friction", lambda: milan_releases("high"), _UM, 315.0, _dry),
    RealSet("milan-releases-medium", _MILAN, "dry friction", lambda: milan_releases("med"), _UM, 405.0, _dry),
    RealSet("milan-steps", _MILAN, "dry friction or a dead zone of the drive", milan_steps, _UM, math.inf, _dry),
    RealSet("ucsd-steps", _UCSD, "dry friction", lambda: ucsd("steps"), _UM, math.inf, _dry),
    RealSet("ucsd-releases", _UCSD, "dry friction", lambda: ucsd("releases"), _UM, math.inf, _dry),
    RealSet(
        "trento", "frank1789/MechanicalVibrationProject, University of Trento", "two further carts",
        trento, _UM, math.inf, _mode_or_unexplained,
    ),
)  # fmt: skip

SETS: Mapping[str, RealSet] = {s.name: s for s in _ALL}
