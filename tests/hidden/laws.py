"""Laws that the catalogue has no word for: a force from position, velocity, time, drive and two states of its own.

Each is zero where the plant rests before its record, but for those in time. `SEEN_NEW` may be looked at while the
diagnosis is developed; the others are held back until the end.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .compiled import compiled

PARAMETERS, STATES = 5, 2
IN_FORCE = (
    "eddy_brake",
    "detent",
    "preload",
    "log_spring",
    "exponential_spring",
    "two_way_damper",
    "bowl_damping",
    "saturating_damping",
    "two_relaxations",
    "negative_damping",
    "pumped_spring",
    "memory_friction",
    "chirp",
    "viscous_pad",
    "speed_droop",
    "fringe_field",
    "hot_motor",
    "escapement",
)
BY_SAMPLE = ("mass_leak", "thermal_spring", "damper_warming", "wind")  # held over each sample, or nearly
NEW_LAWS = (*IN_FORCE, *BY_SAMPLE)
SEEN_NEW = ("eddy_brake", "detent")
NEED_DRIVE = ("speed_droop", "fringe_field", "hot_motor")
TWO_RELAXATIONS, MEMORY_FRICTION, HOT_MOTOR = 8, 11, 16  # in IN_FORCE: those with states of their own


@dataclass(frozen=True)
class Law:
    """One law in one run: its name, its parameters (SI, at most five) and its fastest rate, 1/s."""

    name: str
    parameters: tuple[float, ...]
    rate: float = 0.0

    @cached_property
    def kind(self) -> int:
        return IN_FORCE.index(self.name)

    @cached_property
    def values(self) -> np.ndarray:
        return np.array([*self.parameters, *[0.0] * (PARAMETERS - len(self.parameters))])

    def force(self, x: float, v: float, t: float, own: Sequence[float] | np.ndarray, drive: float) -> float:
        return law_force(self.kind, self.values, x, v, t, float(own[0]), float(own[1]), drive)

    def rates(self, x: float, v: float, own: Sequence[float] | np.ndarray, drive: float) -> tuple[float, float]:
        return law_rates(self.kind, self.values, x, v, float(own[0]), float(own[1]), drive)


@compiled
def _well(z: float) -> float:
    return float(z * np.exp((1 - z * z) / 2))


@compiled
def law_force(kind: int, p: np.ndarray, x: float, v: float, t: float, s: float, s2: float, u: float) -> float:
    """Force of the law with that place in `IN_FORCE`, N; s and s2 are its own states, u the drive."""
    if kind == 0:  # eddy_brake: strongest at the speed p1
        f = -2 * p[0] * (v / p[1]) / (1 + (v / p[1]) ** 2)
    elif kind == 1:  # detent: a magnet under the cart at p1, p2 wide
        f = -p[0] * (_well((x - p[1]) / p[2]) - _well(-p[1] / p[2]))
    elif kind == 2:  # preload: springs clamped against a center plate
        f = -p[0] * np.tanh(x / p[1])
    elif kind == 3:  # log_spring
        f = -p[0] * np.sign(x) * np.log1p(np.abs(x) / p[1])
    elif kind == 4:  # exponential_spring: a coil that binds on one side
        f = -p[0] * np.expm1(min(max(x / p[1], -30.0), 30.0))
    elif kind == 5:  # two_way_damper: a valve that opens one way
        f = -p[0] * np.abs(v)
    elif kind == 6:  # bowl_damping
        f = -p[0] * (x / p[1]) ** 2 * v
    elif kind == 7:  # saturating_damping
        f = -p[0] * np.tanh(v / p[1])
    elif kind == TWO_RELAXATIONS:
        f = -p[0] * (x - s) - p[1] * (x - s2)
    elif kind == 9:  # negative_damping: pushes on where it is slow
        f = p[0] * (v / p[1]) * np.exp(-((v / p[1]) ** 2))
    elif kind == 10:  # pumped_spring: stiffness swings in time
        f = -p[0] * np.sin(p[1] * t + p[2]) * x
    elif kind == MEMORY_FRICTION:  # friction of the speed a while ago
        f = -p[0] * np.tanh(s / p[1])
    elif kind == 12:  # chirp
        f = p[0] * np.sin((p[1] + 0.5 * p[2] * t) * t + p[3])
    elif kind == 13:  # viscous_pad: foam that drags beyond p1, no spring
        f = -p[0] * 0.5 * (1 + np.tanh((x - p[1]) / p[2])) * v
    elif kind == 14:  # speed_droop: the drive is weaker at speed, either way
        f = -p[0] * u * np.abs(v)
    elif kind == 15:  # fringe_field: the coil leaves its magnet
        f = -p[0] * u * x * x
    elif kind == HOT_MOTOR:
        f = -p[0] * u * s
    else:  # escapement: a tap at each pass in one direction
        f = p[0] * np.exp(-(((x - p[1]) / p[2]) ** 2)) * min(max(v / p[3], 0.0), 1.0)
    return float(f)


@compiled
def law_rates(kind: int, p: np.ndarray, x: float, v: float, s: float, s2: float, u: float) -> tuple[float, float]:
    """How fast its own states change."""
    if kind == TWO_RELAXATIONS:
        return (x - s) / p[2], (x - s2) / p[3]
    if kind == MEMORY_FRICTION:  # follows the speed
        return (v - s) / p[2], 0.0
    if kind == HOT_MOTOR:  # heats up
        return ((u / p[2]) ** 2 - s) / p[1], 0.0
    return 0.0, 0.0
