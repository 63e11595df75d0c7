"""The same ten plants with `scipy.integrate.solve_ivp`, as someone who knows it writes them.

Events where the law changes, the cart locked while dry friction holds it, a restart at every change of the input.
Bristles are left to the step control: events at each of their many small turns cost more.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

METHODS = ("DOP853", "RK45", "LSODA")
PAST = 1e-13  # where a mode begins beyond its edge, that it does not end there
State = np.ndarray
Rates = Callable[[float, State], list[float]]


@dataclass
class Plant:
    """Numbers of `effects`, zero where absent."""

    mass: float
    stiffness: float
    damping: float
    gain: float
    effects: Mapping[str, Mapping[str, float]]

    def __post_init__(self) -> None:
        def get(effect: str, name: str) -> float:
            return self.effects.get(effect, {}).get(name, 0.0)

        self.level = get("coulomb_friction", "level") + get("stribeck_friction", "level")
        self.extra = get("stribeck_friction", "breakaway") - get("stribeck_friction", "level")
        self.velocity = get("stribeck_friction", "velocity")
        self.cubic, self.gap = get("cubic_stiffness", "coefficient"), get("free_play", "gap")
        self.stop_stiffness, self.stop = get("end_stop", "stiffness"), get("end_stop", "position")
        self.lag = get("actuator_lag", "time_constant")
        self.dry, self.bristles = self.level > 0, "presliding_hysteresis" in self.effects

    def rates(self, drive: float, sign: float, side: float, touched: bool) -> Rates:
        """The right-hand side of one mode; states x, v and what the effect adds."""
        m, k, c = self.mass, self.stiffness, self.damping
        level, extra, velocity = sign * self.level, sign * self.extra, self.velocity
        if "presliding_hysteresis" in self.effects:
            q = self.effects["presliding_hysteresis"]
            ratio, distance = q["level"] / q["distance"], q["distance"]

            def bristles(t: float, y: State) -> list[float]:
                x, v, z = y
                bent = z / distance if v > 0.0 else -z / distance
                return [v, (drive - k * x - c * v - ratio * z) / m, v * (1.0 - bent) if bent > 0 else v]

            return bristles
        if "flexible_coupling" in self.effects:
            q = self.effects["flexible_coupling"]
            m2, k2, c2 = q["mass"], q["stiffness"], q["damping"]

            def coupled(t: float, y: State) -> list[float]:
                x, v, x2, v2 = y
                pull = k2 * (x - x2) + c2 * (v - v2)
                return [v, (drive - k * x - c * v - pull) / m, v2, pull / m2]

            return coupled
        if self.lag:
            lag, k3 = self.lag, self.cubic

            def lagged(t: float, y: State) -> list[float]:
                x, v, force = y
                return [v, (force - k * x - c * v - k3 * x * x * x) / m, (drive - force) / lag]

            return lagged
        if self.dry and extra:

            def stribeck(t: float, y: State) -> list[float]:
                x, v = y
                return [v, (drive - k * x - c * v - level - extra * math.exp(-((v / velocity) ** 2))) / m]

            return stribeck
        if "cogging" in self.effects:
            q = self.effects["cogging"]
            size, wave, phase = q["amplitude"], 2 * math.pi / q["pitch"], q["phase"]

            def cogging(t: float, y: State) -> list[float]:
                x, v = y
                return [v, (drive - k * x - c * v + size * math.sin(wave * x + phase)) / m]

            return cogging
        if self.cubic:
            k3 = self.cubic

            def cubic(t: float, y: State) -> list[float]:
                x, v = y
                return [v, (drive - k * x - c * v - k3 * x * x * x) / m]

            return cubic
        constant = drive - level
        if self.gap:
            constant, k = (drive + k * side * self.gap, k) if side else (drive, 0.0)
        if touched:
            constant, k = constant + self.stop_stiffness * self.stop, k + self.stop_stiffness

        def plain(t: float, y: State) -> list[float]:
            x, v = y
            return [v, (constant - c * v - k * x) / m]

        return plain

    def ends(self, sign: float, side: float, touched: bool) -> list[tuple[str, Callable[[float, State], float]]]:
        """What falls through zero where the mode ends."""
        found: list[tuple[str, Callable[[float, State], float]]] = []
        if self.dry and sign:
            found.append(("turn", lambda t, y: sign * y[1]))
        if self.gap:
            found.append(("play", (lambda t, y: side * y[0] - self.gap) if side else lambda t, y: self.gap - abs(y[0])))
        if self.stop_stiffness:
            way = math.copysign(1.0, self.stop) * (1 if touched else -1)
            found.append(("stop", lambda t, y: way * (y[0] - self.stop)))
        for _, event in found:
            event.terminal, event.direction = True, -1  # type: ignore[attr-defined]
        return found


def simulate(plant: Plant, time: np.ndarray, inputs: np.ndarray, method: str, rtol: float) -> np.ndarray:
    """Position at each sample from rest."""
    size = 4 if "flexible_coupling" in plant.effects else 3 if plant.lag or plant.bristles else 2
    y, now, sign, side, touched = np.zeros(size), float(time[0]), 0.0, 0.0, False
    out = np.empty(time.size)
    switches = np.flatnonzero(np.diff(inputs)) + 1
    drives = plant.gain * inputs[[0, *switches]]
    if plant.lag:
        y[2] = drives[0]
    atol = 1e-2 * rtol
    for drive, end in zip(drives, [*time[switches], time[-1]], strict=True):
        while now < end:
            low, high = np.searchsorted(time, [now, end])
            high += time[min(high, time.size - 1)] == end
            if plant.dry and y[1] == 0.0:
                net = drive - plant.stiffness * y[0]
                if abs(net) <= plant.level + plant.extra:
                    out[low:high] = y[0]
                    now = float(end)
                    continue
                sign = math.copysign(1.0, net)
            events = plant.ends(sign, side, touched)
            got = solve_ivp(
                plant.rates(drive, sign, side, touched),
                (now, end),
                y,
                method=method,
                t_eval=np.append(time[low:high], end) if not high or time[high - 1] < end else time[low:high],
                events=[event for _, event in events] or None,
                rtol=rtol,
                atol=atol,
            )
            if got.status < 0:
                raise RuntimeError(f"{method} at {rtol:g}: {got.message}")
            known = min(len(got.t), high - low)
            if known:
                out[low : low + known] = got.y[0, :known]
            if got.status != 1:
                now, y = float(end), got.y[:, -1].copy()
                continue
            which = next(i for i, hits in enumerate(got.t_events) if hits.size)
            now, y = float(got.t_events[which][-1]), got.y_events[which][-1].copy()
            if events[which][0] == "turn":
                y[1] = 0.0
            elif events[which][0] == "play":
                side = 0.0 if side else math.copysign(1.0, y[0])
                y[0] = math.copysign(plant.gap + (PAST if side else -PAST), y[0])
            else:
                touched = not touched
                y[0] = plant.stop + math.copysign(PAST if touched else -PAST, plant.stop)
    return out
