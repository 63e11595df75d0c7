"""One run of the hidden plant: what it is made of and where it starts.

Nothing in this package imports the product's simulator or its catalogue: effects are spelled out here a second time,
from the physics, so that data made here and fitted there do not commit the inverse crime.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from scipy.optimize import brentq

from .laws import Law

GRAVITY = 9.81
Effects = Mapping[str, Mapping[str, float]]
NAMES = (
    "coulomb_friction",
    "load_proportional_friction",
    "stribeck_friction",
    "asymmetric_friction",
    "presliding_hysteresis",
    "quadratic_damping",
    "position_dependent_damping",
    "cubic_stiffness",
    "quadratic_stiffness",
    "free_play",
    "end_stop",
    "viscoelastic_spring",
    "flexible_coupling",
    "actuator_lag",
    "input_delay",
    "actuator_dead_zone",
    "actuator_saturation",
    "periodic_disturbance",
    "cogging",
    "sensor_drift",
)
NEW = ("sine_stiffness", "power_damping", "actuator_rate_limit")  # of the second round, with a set of their own
DRAWN = (*NAMES, *NEW)  # frozen: the sets draw from these by their number, another name would make other campaigns
EVERY = DRAWN
DRY = NAMES[:4]
SLOWEST = 1e-6  # m/s, below which a power law of damping is viscous
SHORTEST = 1e-9  # s, below which a lag of the drive is none: it would move the cart by less than a nanometer


@dataclass(frozen=True)
class Run:
    """One record to be simulated; SI units throughout.

    `inputs[i]` is held from sample i to i+1, or joined to the next one by a line ("straight") or by the cubic spline
    through all of them ("smooth"). `position` is counted from where the plant rests under `input_before` (with
    `settled`, motor ripple included; without, the spring's own rest). Six fields are outside the catalogue: a force
    held over each sample, factors on stiffness, mass and damping by sample, a law, a patch of sticky guide.
    """

    mass: float
    stiffness: float
    damping: float
    gain: float
    sample_time: float
    inputs: np.ndarray
    effects: Effects = field(default_factory=dict)
    input_before: float = 0.0
    position: float = 0.0
    velocity: float = 0.0
    phase: float = 0.0
    settled: bool = False
    held_force: np.ndarray | None = None
    stiffness_scale: np.ndarray | None = None
    mass_scale: np.ndarray | None = None
    damping_scale: np.ndarray | None = None
    law: Law | None = None
    sticky: tuple[float, float, float] | None = None  # extra level N, center m, half width m
    input_between: str = "held"

    def get(self, effect: str, parameter: str, default: float = 0.0) -> float:
        return float(self.effects.get(effect, {}).get(parameter, default))

    @property
    def size(self) -> int:
        return len(self.inputs)

    @property
    def drive(self) -> np.ndarray:
        """Force per sample after dead zone and saturation, not yet delayed or lagged, N; last: before the record."""
        u = np.append(np.asarray(self.inputs, float), self.input_before)
        dead = self.get("actuator_dead_zone", "level")
        u = np.sign(u) * np.maximum(np.abs(u) - dead, 0.0)
        limit = self.get("actuator_saturation", "level", math.inf)
        return np.asarray(self.gain * np.clip(u, -limit, limit))

    @property
    def lag(self) -> float:
        tau = self.get("actuator_lag", "time_constant")
        return tau if tau > SHORTEST else 0.0

    @property
    def levels(self) -> tuple[float, float, float, float]:
        """Sliding friction for v > 0 and v < 0, extra breakaway, Stribeck velocity."""
        both = self.get("coulomb_friction", "level") + self.get("stribeck_friction", "level")
        both += self.get("load_proportional_friction", "coefficient") * self.mass * GRAVITY
        extra = self.get("stribeck_friction", "breakaway") - self.get("stribeck_friction", "level")
        forward = both + self.get("asymmetric_friction", "level_forward")
        backward = both + self.get("asymmetric_friction", "level_backward")
        return forward, backward, extra, self.get("stribeck_friction", "velocity", 1.0)

    @property
    def start(self) -> float:
        """Position at sample 0, measured from the spring's rest position, m."""
        push = float(self.drive[-1])
        if push == 0 and not (self.settled and "cogging" in self.effects):
            return self.position
        plain = (
            self if self.settled else replace(self, effects={n: p for n, p in self.effects.items() if n != "cogging"})
        )
        reach = 4 * abs(push) / self.stiffness + 4 * self.get("cogging", "amplitude") / self.stiffness + 1e-4
        reach += self.get("free_play", "gap")
        grid = np.linspace(-reach, reach, 4001)
        net = push + plain.static(grid)
        # the equilibrium nearest to zero that is stable: net force falls through zero
        roots = [
            brentq(lambda x: push + float(plain.static(x)), grid[i], grid[i + 1], xtol=1e-15)
            for i in np.flatnonzero((net[:-1] > 0) & (net[1:] <= 0))
        ]
        return min(roots, key=abs) + self.position

    def sine(self, x: float) -> float:
        """What a pendulum's spring force lacks to a straight one, N."""
        a = self.get("sine_stiffness", "curvature")
        return self.stiffness * (x - math.sin(a * x) / a) if a else 0.0

    def static(self, x: float | np.ndarray) -> np.ndarray:
        """Force of springs, stop and motor ripple at rest, N."""
        x = np.asarray(x, float)
        force = -self.stiffness * np.copysign(np.maximum(np.abs(x) - self.get("free_play", "gap"), 0.0), x)
        force -= self.get("cubic_stiffness", "coefficient") * x**3
        force -= self.get("quadratic_stiffness", "coefficient") * x**2
        if a := self.get("sine_stiffness", "curvature"):
            force += self.stiffness * (x - np.sin(a * x) / a)
        if stop := self.get("end_stop", "position"):
            force -= np.where((x - stop) * stop > 0, self.get("end_stop", "stiffness") * (x - stop), 0.0)
        if "cogging" in self.effects:
            pitch, phase = self.get("cogging", "pitch"), self.get("cogging", "phase")
            force += self.get("cogging", "amplitude") * np.sin(2 * np.pi * x / pitch + phase)
        return np.asarray(force)


def runs_like(
    campaign: Any,
    *,
    base_mass: float | Mapping[str, float],
    stiffness: Mapping[str, float],
    damping: Mapping[str, float],
    force_gain: float,
    effects: Effects,
    phases: Sequence[float] | None = None,
    positions: Sequence[float] | None = None,
) -> list[Run]:
    """Runs with the inputs, labels and added masses of a `stepid.Campaign`."""
    runs = []
    for i, e in enumerate(campaign.experiments):
        base = base_mass[e.base] if isinstance(base_mass, Mapping) else base_mass
        runs.append(
            Run(
                mass=base + e.added_mass,
                stiffness=stiffness[e.spring],
                damping=damping[e.damper],
                gain=force_gain,
                sample_time=e.sample_time,
                inputs=np.array(e.input),
                input_before=e.input_before,
                effects=effects,
                phase=0.0 if phases is None else phases[i],
                position=0.0 if positions is None else positions[i],
            )
        )
    return runs
