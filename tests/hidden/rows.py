"""The equations of many runs as arrays, one entry a run, and the modes that switch them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .laws import FORCES, PARAMETERS, STATE_RATES, STATES
from .plant import SLOWEST, Run

X, V, X2, V2, W = range(5)  # W: the joint between spring and dashpot of the viscoelastic branch


class Rows:
    """Plain arrays, one entry a run; `pick` takes some rows out for the treatment of events."""

    def __init__(self, runs: Sequence[Run]) -> None:
        def each(effect: str, name: str, default: float = 0.0) -> np.ndarray:
            return np.array([r.get(effect, name, default) for r in runs])

        self.has = {name for r in runs for name in r.effects} | {"sticky" for r in runs if r.sticky is not None}
        self.m, self.k = np.array([r.mass for r in runs]), np.array([r.stiffness for r in runs])
        self.c = np.array([r.damping for r in runs])
        self.slope = each("position_dependent_damping", "slope")
        self.c2, self.k3 = each("quadratic_damping", "coefficient"), each("cubic_stiffness", "coefficient")
        self.k2, self.gap = each("quadratic_stiffness", "coefficient"), each("free_play", "gap")
        self.kstop, self.stop = each("end_stop", "stiffness"), each("end_stop", "position")
        self.kv, self.cv = each("viscoelastic_spring", "stiffness"), each("viscoelastic_spring", "damping", 1.0)
        self.m2, self.kc = each("flexible_coupling", "mass", 1.0), each("flexible_coupling", "stiffness")
        self.cc, self.tau = each("flexible_coupling", "damping"), each("actuator_lag", "time_constant")
        self.amp, self.omega = (
            each("periodic_disturbance", "amplitude"),
            each("periodic_disturbance", "frequency") * 2 * np.pi,
        )
        self.bend = each("sine_stiffness", "curvature")
        self.cp, self.exponent = each("power_damping", "coefficient"), each("power_damping", "exponent", 1.0)
        self.phase = np.array([r.phase for r in runs])
        self.cog, self.angle = each("cogging", "amplitude"), each("cogging", "phase")
        self.wave = 2 * np.pi / each("cogging", "pitch", 1.0)
        self.level, self.distance = (
            each("presliding_hysteresis", "level"),
            each("presliding_hysteresis", "distance", 1.0),
        )
        levels = np.array([r.levels for r in runs])
        self.forward, self.backward, self.extra, self.vs = levels.T
        patch = np.array([r.sticky or (0.0, 0.0, 1.0) for r in runs])
        self.patch, self.center, self.width = patch.T
        self.signed = (levels[:, :3] > 0).any(axis=1) | (self.level > 0) | (self.patch > 0)
        n = len(runs)
        self.laws = sorted({r.law.name for r in runs if r.law is not None})
        self.law = np.array([-1 if r.law is None else self.laws.index(r.law.name) for r in runs])
        self.law_values = np.zeros((PARAMETERS, n))
        for j, r in enumerate(runs):
            own = () if r.law is None else r.law.parameters
            self.law_values[: len(own), j] = own
        self.y = np.zeros((5 + STATES if self.laws else 5, n))
        self.y[X] = self.y[X2] = self.y[W] = [r.start for r in runs]
        self.y[V] = self.y[V2] = [r.velocity for r in runs]
        self.t, self.drive, self.target, self.held = (
            np.zeros(n),
            np.array([r.drive[-1] for r in runs]),
            np.zeros(n),
            np.zeros(n),
        )
        self.since = np.zeros(n)  # when the target's curve began, where it has one
        self.scale_k, self.scale_m, self.scale_c = np.ones(n), np.ones(n), np.ones(n)
        # modes: sign of the motion (0 stuck), side of the play, stop touched; bristle branch since the last reversal
        x, v = self.y[X], self.y[V]
        self.sign = np.where(self.signed, np.sign(v), 1.0)
        self.side = np.where(np.abs(x) > self.gap, np.sign(x), 0.0) * (self.gap > 0)
        self.touch = (self.stop != 0) & ((x - self.stop) * self.stop > 0)
        self.xb, self.zb = x.copy(), np.zeros(n)

    def pick(self, rows: np.ndarray) -> Rows:
        some = object.__new__(Rows)
        for name, value in vars(self).items():
            some.__dict__[name] = value[..., rows] if isinstance(value, np.ndarray) else value
        return some

    def put(self, rows: np.ndarray, some: Rows) -> None:
        for name in ("y", "t", "drive", "sign", "side", "touch", "xb", "zb"):
            getattr(self, name)[..., rows] = getattr(some, name)

    def bristle(self, x: np.ndarray) -> np.ndarray:
        """z along the branch that began at (xb, zb): straight while it unloads, then saturating."""
        path = self.sign * (x - self.xb)
        z = self.sign * self.zb
        straight = np.maximum(0.0, -z)  # travel until z passes zero
        beyond = np.maximum(path - straight, 0.0)
        begin = np.maximum(z, 0.0)
        loaded = self.distance - (self.distance - begin) * np.exp(-beyond / self.distance)
        return self.sign * np.where(path < straight, z + path, loaded)

    def push(self, y: np.ndarray, t: np.ndarray, drive: np.ndarray) -> np.ndarray:
        x, v, has = y[X], y[V], self.has
        k = self.k * self.scale_k
        force = drive + self.held - self.c * self.scale_c * v - k * (x - self.side * self.gap)
        if "free_play" in has:
            force += np.where((self.gap > 0) & (self.side == 0), k * x, 0.0)
        if "position_dependent_damping" in has:
            force -= self.c * self.slope * x * v
        if "quadratic_damping" in has:
            force -= self.c2 * v * np.abs(v)
        if "cubic_stiffness" in has or "quadratic_stiffness" in has:
            force -= (self.k3 * x + self.k2) * x * x
        if "power_damping" in has:
            force -= self.cp * v * (v * v + SLOWEST**2) ** (self.exponent / 2 - 0.5)
        if "sine_stiffness" in has:
            a = np.where(self.bend > 0, self.bend, 1.0)
            force += np.where(self.bend > 0, k * (x - np.sin(a * x) / a), 0.0)
        if "end_stop" in has:
            force -= self.touch * self.kstop * (x - self.stop)
        if "viscoelastic_spring" in has:
            force -= self.kv * (x - y[W])
        if "flexible_coupling" in has:
            force -= self.kc * (x - y[X2]) + self.cc * (v - y[V2])
        if "presliding_hysteresis" in has:
            z = np.where(self.sign == 0, self.zb, self.bristle(x))
            force -= self.level * z / self.distance
        if "periodic_disturbance" in has:
            force += self.amp * np.sin(self.omega * t + self.phase)
        if "cogging" in has:
            force += self.cog * np.sin(self.wave * x + self.angle)
        for i, name in enumerate(self.laws):
            j = np.flatnonzero(self.law == i)
            force[j] += FORCES[name](self.law_values[:, j], x[j], v[j], t[j], y[5:, j], drive[j])
        return force

    def band(self, x: np.ndarray, v: np.ndarray | float, up: np.ndarray) -> np.ndarray:
        level = np.where(up, self.forward, self.backward)
        if "stribeck_friction" in self.has:
            level = level + self.extra * np.exp(-((v / self.vs) ** 2))
        if "sticky" in self.has:
            level = level + self.patch * np.exp(-(((x - self.center) / self.width) ** 2))
        return level

    def lagged(self, h: np.ndarray) -> np.ndarray:
        if self.target.ndim == 2:
            return self.along(h)
        if "actuator_lag" not in self.has:
            return self.target
        tau = np.where(self.tau > 0, self.tau, 1.0)
        return np.where(self.tau > 0, self.target + (self.drive - self.target) * np.exp(-h / tau), self.target)

    def along(self, h: np.ndarray) -> np.ndarray:
        """The same for targets that are cubics: a lag follows a polynomial of its own, and what it is off fades."""
        tau, s = self.tau, self.t - self.since
        a, b, c, d = self.target
        b, c = b - 2 * tau * (c - 3 * tau * d), c - 3 * tau * d
        a = a - tau * b
        off = np.where(tau > 0, self.drive - (((d * s + c) * s + b) * s + a), 0.0)
        s = s + h
        return ((d * s + c) * s + b) * s + a + off * np.exp(-h / np.where(tau > 0, tau, 1.0))

    def sharp(self, h: np.ndarray) -> np.ndarray:
        """Rows whose power law bends within h of here: so slow that they may stop."""
        if "power_damping" not in self.has:
            return np.zeros(h.size, bool)
        pull = np.abs(self.rates(self.y, self.t, self.lagged(0 * h))[V])
        return (self.cp > 0) & (self.exponent < 2) & (np.abs(self.y[V]) < 4 * h * pull)

    def rates(self, y: np.ndarray, t: np.ndarray, drive: np.ndarray) -> np.ndarray:
        out = np.zeros_like(y)
        force = self.push(y, t, drive)
        if self.signed.any():
            force -= np.where(self.signed, self.sign * self.band(y[X], y[V], self.sign > 0), 0.0)
            moving = ~(self.signed & (self.sign == 0))
            force *= moving
            out[X] = y[V] * moving
        else:
            out[X] = y[V]
        out[V] = force / (self.m * self.scale_m)
        if "flexible_coupling" in self.has:
            out[X2] = y[V2]
            out[V2] = (self.kc * (y[X] - y[X2]) + self.cc * (y[V] - y[V2])) / self.m2
        if "viscoelastic_spring" in self.has:
            out[W] = self.kv / self.cv * (y[X] - y[W])
        for i, name in enumerate(self.laws):
            if name in STATE_RATES:
                j = np.flatnonzero(self.law == i)
                out[5:, j] = STATE_RATES[name](self.law_values[:, j], y[X, j], y[V, j], t[j], y[5:, j], drive[j])
        return out

    def stepped(self, h: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """State and drive after h, modes frozen."""
        half, full = self.lagged(h / 2), self.lagged(h)
        y, t = self.y, self.t
        one = self.rates(y, t, self.lagged(0 * h))
        two = self.rates(y + h / 2 * one, t + h / 2, half)
        three = self.rates(y + h / 2 * two, t + h / 2, half)
        four = self.rates(y + h * three, t + h, full)
        return y + h / 6 * (one + 2 * two + 2 * three + four), full

    def guard(self, y: np.ndarray, t: np.ndarray, drive: np.ndarray) -> np.ndarray:
        """Positive while no mode changes; the smallest of all conditions, shape (4, runs)."""
        x = y[X]
        least = np.full((4, x.size), np.inf)
        if self.signed.any():
            least[0] = np.where(self.signed & (self.sign != 0), self.sign * y[V], np.inf)
            stuck = self.signed & (self.sign == 0)
            if stuck.any():
                net = self.push(y, t, drive)
                up, down = self.band(x, 0.0, x == x) - net, self.band(x, 0.0, x != x) + net
                least[1] = np.where(stuck, np.minimum(up, down) + 1e-12, np.inf)
        if "free_play" in self.has:
            inside = self.gap - np.abs(x)
            outside = self.side * x - self.gap
            least[2] = np.where(self.gap > 0, np.where(self.side == 0, inside, outside), np.inf)
        if "end_stop" in self.has:
            way = np.sign(self.stop) * np.where(self.touch, 1.0, -1.0)
            least[3] = np.where(self.stop != 0, way * (x - self.stop), np.inf)
        return least

    def choose_sign(self, rows: np.ndarray) -> None:
        """At v = 0: stick, or break away in the direction of the net force."""
        net = self.push(self.y, self.t, self.lagged(0 * self.t))
        x = self.y[X]
        up, down = net - self.band(x, 0.0, x == x), -net - self.band(x, 0.0, x != x)
        sign = np.where(up > 1e-12, 1.0, np.where(down > 1e-12, -1.0, 0.0))
        self.sign = np.where(rows, sign, self.sign)
