"""More recordings of real plants: public files of others, read from a folder beside the project.

The environment variable `STEPID_MORE_DATA` names the folder. In it stands a folder for each plant, with one CSV file
a run: a line of names, then time [s], position and, where one was recorded, the input. Samples are those of the source.
A record with one run is cut into three slices, so that two of them predict the third.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from real_sets import DAMPING, DRY, folder, record
from stepid import Campaign, Experiment

SPRING = {"cubic_stiffness", "sine_stiffness", "quadratic_stiffness"}
LOSSES = DRY | DAMPING


@dataclass(frozen=True)
class MoreSet:
    """A campaign, where it is from, what is known of its plant, the effects in it, and those of which no one knows.

    `measured` are parameters that a balance and a ruler told.
    """

    name: str
    source: str
    known: str
    allowed: frozenset[str]
    build: Callable[[], Campaign]
    unknown: frozenset[str] = frozenset()
    measured: Mapping[str, float] = field(default_factory=dict)


def run(
    file: str, *, after: float | None = None, until: float = np.inf, scale: float = 1.0, added: float = 0.0
) -> Experiment:
    """A free swing from its farthest point on, or from a time [s] on."""
    path = folder("STEPID_MORE_DATA") / f"{file}.csv"
    time, position = np.loadtxt(path, delimiter=",", skiprows=1, usecols=(0, 1), unpack=True)
    position = scale * position
    if after is None:
        rest = np.median(position[-max(len(position) // 5, 10) :])
        begin = int(np.argmax(np.abs(position - rest)))
    else:
        begin = int(np.searchsorted(time, after))
    kept = slice(begin, int(np.searchsorted(time, until)))
    return record(path.stem, time[kept], position[kept], added=added, starts="motion")


def campaign(name: str, *runs: Experiment) -> Campaign:
    """A campaign of the runs, of one run in three slices."""
    if len(runs) == 1:
        edges = np.linspace(0, runs[0].time.size, 4).round().astype(int).tolist()
        runs = tuple(runs[0].slice(a, b, name=f"part {i}") for i, (a, b) in enumerate(pairwise(edges), 1))
    return Campaign(name=name, experiments=runs)


def _hanging(spring: str, sail: str, light: str, heavy: str, mass: float) -> MoreSet:
    """Two weights on one spring; a third of the spring's mass, kg, is in the lighter one's."""
    files = [f"springmass-milano/free_{spring}_{sail}_{one}" for one in (light, heavy)]
    stiffness = 3.226 if spring == "soft" else 24.25
    return MoreSet(
        f"hanging-{spring}-{sail}", "Mattia04/Smorzamento", "hung freely: no dry friction", frozenset(DAMPING),
        lambda: campaign("hanging", run(files[0], scale=1e-3), run(files[1], scale=1e-3, added=0.0395)),
        frozenset(SPRING), {"base_mass": mass, "stiffness[spring]": stiffness},
    )  # fmt: skip


def _string(number: int) -> MoreSet:
    return MoreSet(
        f"string-pendulum-{number}", "jiarui-wen/PHY180-Pendulum-Project", "sine of the angle, air drag",
        frozenset(DAMPING | {"cubic_stiffness", "sine_stiffness"}),
        lambda: campaign("string", run(f"pendulum-phy180/free_{number}")),
    )  # fmt: skip


_WHEEL = "martin8ner/P1, Pohl's wheel at KIT"
_DISC = "Sven-vandenBergh/M24-25-Lab-OSC-data"
_ARM = "ptibbets/LabProb2"
_WEIGHT = "adam-zhang-lcps/papers"
_ALL = (
    MoreSet(
        "wheel-no-brake",
        _WHEEL,
        "dry friction",
        frozenset(LOSSES),
        lambda: campaign("wheel", run("pohl-kit/free_000mA")),
        frozenset(SPRING),
    ),
    MoreSet(
        "wheel-brake-400",
        _WHEEL,
        "viscous brake, little dry friction",
        frozenset(LOSSES),
        lambda: campaign("wheel", run("pohl-kit/free_400mA")),
        frozenset(SPRING),
    ),
    MoreSet(
        "wheel-brake-700",
        _WHEEL,
        "viscous brake: linear",
        frozenset(),
        lambda: campaign("wheel", run("pohl-kit/free_700mA")),
    ),
    MoreSet(
        "disc",
        _DISC,
        "dry friction",
        frozenset(DRY),
        lambda: campaign("disc", *(run(f"disc-oscillator-nl/free_nomagnet_run{i:02}") for i in range(1, 11))),
    ),
    MoreSet(
        "disc-magnet",
        _DISC,
        "dry friction and a magnet",
        frozenset(LOSSES),
        lambda: campaign("disc", *(run(f"disc-oscillator-nl/free_magnet_run{i:02}") for i in range(1, 11))),
    ),
    MoreSet(
        "torsion-wheel-80s",
        "GuenterQuast/PhyPraKit",
        "dry friction",
        frozenset(LOSSES),
        lambda: campaign("torsion", run("drehpendel-phyprakit/free", until=80.0)),
        frozenset(SPRING),
    ),
    MoreSet(
        "arm-1min",
        _ARM,
        "sine of the angle, air drag, dry friction",
        frozenset(LOSSES | {"sine_stiffness"}),
        lambda: campaign("arm", run("pendulum-labprob2/free", after=8.05, until=60.0)),
    ),
    MoreSet(
        "arm-whole",
        _ARM,
        "the same",
        frozenset(LOSSES | {"sine_stiffness"}),
        lambda: campaign("arm", run("pendulum-labprob2/free", after=8.05)),
    ),
    *(_string(number) for number in (8048, 8050, 8053, 8055)),
    MoreSet(
        "spring-with-disc",
        "filo0509/smorzamento",
        "air drag of a disc",
        frozenset(DAMPING),
        lambda: campaign("disc", run("springdisc-filo/free_hard_0.2016kg_1", scale=1e-3)),
    ),
    _hanging("soft", "cd", "m1", "m3", 0.0603),
    _hanging("soft", "net", "m1", "m3", 0.0558),
    _hanging("stiff", "cd", "m5", "m7", 0.1443),
    _hanging("stiff", "net", "m5", "m7", 0.1398),
    MoreSet(
        "hanging-shaken",
        "Mattia04/Smorzamento",
        "a drive at 1.011 Hz that was not recorded",
        frozenset({"periodic_disturbance"}),
        lambda: campaign("shaken", run("springmass-milano/unrecorded_drive_1.011Hz", scale=1e-3)),
    ),
    MoreSet(
        "carriage",
        "stecuproductions/Embeded_Systems_Project",
        "dry friction, read in steps of 2 mm",
        frozenset(DRY),
        lambda: campaign("carriage", *(run(f"springmass-pl/free_{i}", scale=1e-3) for i in (1, 2, 3))),
    ),
    *(
        MoreSet(
            f"weight-{kind}",
            _WEIGHT,
            "hardly any loss: linear",
            frozenset(),
            lambda kind=kind: campaign("weight", *(run(f"vernier-spring-lcps/free_{kind}_{i}") for i in (1, 2, 3))),
        )  # type: ignore[misc]
        for kind in ("control", "more_amplitude", "heavier", "stiffer")
    ),
    MoreSet(
        "sphere-in-water",
        "Revael20/damped-oscillator-modeling",
        "quadratic drag",
        frozenset(DAMPING),
        lambda: campaign("sphere", run("sphere-in-water/free", after=1.24, scale=1e-3)),
    ),
)

SETS: Mapping[str, MoreSet] = {s.name: s for s in _ALL}
