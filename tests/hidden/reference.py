"""Tight-tolerance, event-located integration of one run with `scipy.integrate.solve_ivp` (DOP853).

Between events the right-hand side is smooth: dry friction has a fixed sign or holds the cart, the spring is on one side
of its play, the stop is touched or not. Every change of these is an event; every corner of the drive is a restart.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.integrate import solve_ivp

from .drive import Curve, course, is_curved, value
from .laws import STATES
from .plant import SLOWEST, Run

State = np.ndarray  # x, v, x2, v2, dashpot joint, bristle z, drive force, then a law's own
MOST = 3_000_000  # evaluations of the rates in one run: a minute or two, a hundred times what a run needs
TOLERANCES = np.array([1e-13, 1e-12, 1e-13, 1e-12, 1e-13, 1e-15, 1e-11, 1e-12, 1e-12])


@dataclass
class _Mode:
    sign: int  # of the motion that friction opposes; 0 is stuck
    side: int  # of the play that the spring is on; 0 is inside
    stopped: bool  # beyond the stop
    bristle: int  # sign of z


class _Scalar:
    def __init__(self, run: Run, fineness: float) -> None:
        self.run, self.fineness = run, fineness
        self.forward, self.backward, self.extra, self.vs = run.levels
        self.gap = run.get("free_play", "gap")
        self.stop = run.get("end_stop", "position")
        self.tau = run.lag
        self.distance = run.get("presliding_hysteresis", "distance", 1.0)
        self.bristles = "presliding_hysteresis" in run.effects
        self.dry = self.forward > 0 or self.backward > 0 or self.extra > 0 or run.sticky is not None
        self.signed = self.dry or self.bristles
        self.target = self.held = 0.0
        self.curve: Curve | None = None  # of the force from `since` on, where it is not constant
        self.since = 0.0
        self.longest = 0.001 if is_curved(run) else 0.005  # step while events are watched, s
        self.exponent = run.get("power_damping", "exponent")
        self.scale_k = self.scale_m = self.scale_c = 1.0
        start = run.start
        self.evaluations = 0
        self.state = np.array([start, run.velocity, start, run.velocity, start, 0.0, run.drive[-1]])
        if run.law is not None:
            self.state = np.append(self.state, np.zeros(STATES))
        self.mode = _Mode(0, 0, False, 0)
        self.now = 0.0
        self._enter_regions()

    def _enter_regions(self) -> None:
        x, v = float(self.state[0]), float(self.state[1])
        self.mode.side = 0 if abs(x) <= self.gap else (1 if x > 0 else -1)
        self.mode.stopped = bool(self.stop and (x - self.stop) * self.stop > 0)
        self.mode.sign = 1 if v > 0 else -1 if v < 0 else 0
        self.mode.bristle = self.mode.sign  # fresh bristles bend the way the cart moves

    def follow(self, begin: float, curve: Curve) -> None:
        self.target, self.since = float(curve[0]), begin
        self.curve = curve if curve[1:].any() else None

    def wanted(self, t: float) -> float:
        """Drive force before its lag, N."""
        return self.target if self.curve is None else value(self.curve, t - self.since)

    def push(self, t: float, y: State) -> float:
        """Every force on the carriage but dry friction."""
        run, x, v = self.run, float(y[0]), float(y[1])
        k = run.stiffness * self.scale_k
        drive = float(y[6]) if self.tau else self.wanted(t)
        drag = run.damping * self.scale_c * (1 + run.get("position_dependent_damping", "slope") * x)
        force = drive + self.held - drag * v
        force -= run.get("quadratic_damping", "coefficient") * v * abs(v)
        force -= k * (x - self.mode.side * self.gap) if self.mode.side or not self.gap else 0.0
        force -= (
            run.get("cubic_stiffness", "coefficient") * x * x * x
            + run.get("quadratic_stiffness", "coefficient") * x * x
        )
        if self.exponent:
            slope = run.get("power_damping", "coefficient") * (v * v + SLOWEST**2) ** ((self.exponent - 1) / 2)
            force -= slope * v
        if "sine_stiffness" in run.effects:
            force += run.sine(x) * self.scale_k
        if self.mode.stopped:
            force -= run.get("end_stop", "stiffness") * (x - self.stop)
        if "viscoelastic_spring" in run.effects:
            force -= run.get("viscoelastic_spring", "stiffness") * (x - float(y[4]))
        if "flexible_coupling" in run.effects:
            force -= self.coupling(y)
        if self.bristles:
            force -= run.get("presliding_hysteresis", "level") * float(y[5]) / self.distance
        if "periodic_disturbance" in run.effects:
            omega = 2 * math.pi * run.get("periodic_disturbance", "frequency")
            force += run.get("periodic_disturbance", "amplitude") * math.sin(omega * t + run.phase)
        if "cogging" in run.effects:
            angle = 2 * math.pi * x / run.get("cogging", "pitch") + run.get("cogging", "phase")
            force += run.get("cogging", "amplitude") * math.sin(angle)
        if run.law is not None:
            force += float(run.law.force(x, v, t, y[7:], drive))
        return force

    def coupling(self, y: State) -> float:
        k, c = self.run.get("flexible_coupling", "stiffness"), self.run.get("flexible_coupling", "damping")
        return k * float(y[0] - y[2]) + c * float(y[1] - y[3])

    def friction(self, x: float, v: float, sign: int) -> float:
        """Level that opposes motion of the given sign, N."""
        level = self.forward if sign > 0 else self.backward
        if self.extra:
            level += self.extra * math.exp(-((v / self.vs) ** 2))
        if self.run.sticky is not None:
            extra, center, width = self.run.sticky
            level += extra * math.exp(-(((x - center) / width) ** 2))
        return level

    def rates(self, t: float, y: State) -> list[float]:
        self.evaluations += 1
        if self.evaluations > MOST:
            raise RuntimeError(f"no end in sight at {t:.6f} s: this run is too stiff, or chatters, for the reference")
        x, v = float(y[0]), float(y[1])
        stuck = self.signed and self.mode.sign == 0
        force = 0.0 if stuck else self.push(t, y) - self.mode.sign * self.friction(x, v, self.mode.sign)
        v = 0.0 if stuck else v
        out = [v, force / (self.run.mass * self.scale_m), 0.0, 0.0, 0.0, 0.0, 0.0]
        if "flexible_coupling" in self.run.effects:
            out[2], out[3] = float(y[3]), self.coupling(y) / self.run.get("flexible_coupling", "mass")
        if "viscoelastic_spring" in self.run.effects:
            k, c = self.run.get("viscoelastic_spring", "stiffness"), self.run.get("viscoelastic_spring", "damping")
            out[4] = k / c * float(y[0] - y[4])
        if self.bristles:
            loaded = self.mode.sign * self.mode.bristle > 0
            out[5] = v * (1 - (self.mode.sign * float(y[5]) / self.distance if loaded else 0.0))
        if self.tau:
            out[6] = (self.wanted(t) - float(y[6])) / self.tau
        if self.run.law is not None:
            drive = float(y[6]) if self.tau else self.wanted(t)
            out += self.run.law.rates(x, v, y[7:], drive)
        return out

    def guards(self) -> list[tuple[str, Callable[[float, State], float]]]:
        """Functions that are positive while the present mode lasts."""
        mode, found = self.mode, []
        if self.signed and mode.sign:
            found.append(("turn", lambda t, y: mode.sign * y[1]))
        if self.signed and not mode.sign:
            # the margin keeps rounding from starting a hold on the wrong side of its own event
            found.append(("slip+", lambda t, y: self.friction(y[0], 0.0, 1) + 1e-12 - self.push(t, y)))
            found.append(("slip-", lambda t, y: self.friction(y[0], 0.0, -1) + 1e-12 + self.push(t, y)))
        if self.gap:
            if mode.side:
                found.append(("play", lambda t, y: mode.side * y[0] - self.gap))
            else:
                found.append(("play+", lambda t, y: self.gap - y[0]))
                found.append(("play-", lambda t, y: self.gap + y[0]))
        if self.stop:
            way = (1 if self.stop > 0 else -1) * (1 if mode.stopped else -1)
            found.append(("stop", lambda t, y: way * (y[0] - self.stop)))
        if self.bristles and mode.bristle:
            found.append(("bristle", lambda t, y: mode.bristle * y[5]))
        return found

    def settle_sign(self) -> None:
        """At v = 0, stick or choose the way the cart breaks away."""
        if not self.signed or self.state[1] != 0.0:
            return
        net, x = self.push(self.now, self.state), float(self.state[0])
        up, down = net - self.friction(x, 0.0, 1), -net - self.friction(x, 0.0, -1)
        tiny = 1e-13  # rounding of a cart that broke away just here
        self.mode.sign = 1 if up > tiny else -1 if down > tiny else 0
        self.mode.bristle = int(np.sign(self.state[5])) or self.mode.sign

    def switch(self, name: str) -> None:
        if name == "turn":
            self.state[1] = 0.0
            self.mode.sign = 0
            self.settle_sign()
        elif name in ("slip+", "slip-"):
            self.mode.sign = 1 if name == "slip+" else -1
            self.mode.bristle = int(np.sign(self.state[5])) or self.mode.sign
        elif name == "play":
            self.mode.side = 0
        elif name in ("play+", "play-"):
            self.mode.side = 1 if name == "play+" else -1
        elif name == "stop":
            self.mode.stopped = not self.mode.stopped
        elif name == "bristle":
            self.mode.bristle = -self.mode.bristle

    def run_until(self, end: float, wanted: np.ndarray) -> np.ndarray:
        """Advance to `end` and return the position at the wanted times."""
        got = np.empty(wanted.size)
        filled = 0
        self.settle_sign()
        while self.now < end - 1e-15:
            names, events = [], []
            for name, guard in self.guards():

                def event(
                    t: float, y: State, guard: Callable[[float, State], float] = guard, begin: float = self.now
                ) -> float:
                    # a guard is zero where its mode began: solve_ivp would take that for the next change
                    return guard(t, y) if t > begin + 1e-11 else 1.0

                event.terminal, event.direction = True, -1.0  # type: ignore[attr-defined]
                names.append(name)
                events.append(event)
            out = solve_ivp(
                self.rates,
                (self.now, end),
                self.state,
                method="DOP853",
                rtol=1e-11 * self.fineness,
                atol=self.fineness * TOLERANCES[: self.state.size],
                events=events or None,
                dense_output=True,
                max_step=self.fineness**0.125
                * (self.longest if events or self.exponent else 0.02),  # no mode, nor a rest, is within a step
            )
            if out.status < 0:
                raise RuntimeError(f"the reference stops at {out.t[-1]:.6f} s: {out.message}")
            stop = float(out.t[-1])
            upto = int(np.searchsorted(wanted, stop, side="right"))
            if upto > filled and out.sol is not None:
                got[filled:upto] = out.sol(wanted[filled:upto])[0]
                filled = upto
            self.now, self.state = stop, np.array(out.y[:, -1])
            if out.status == 1:
                for name, hits in zip(names, out.t_events or (), strict=True):
                    if len(hits):
                        self.switch(name)
        self.now = end
        got[filled:] = self.state[0]
        return got


def reference(run: Run, *, fineness: float = 1.0) -> np.ndarray:
    """Reading at each sample, m, from the spring's rest position; shape (n,). Tolerances go with `fineness`."""
    cart = _Scalar(run, fineness)
    n, period = run.size, run.sample_time
    times = np.arange(n) * period
    before, pieces = course(run)
    # change times of everything that is held from sample to sample
    breaks = {0.0, float(times[-1])}
    breaks.update(t for t, _ in pieces)
    for held in (run.held_force, run.stiffness_scale, run.mass_scale, run.damping_scale):
        if held is not None:
            breaks.update(float(times[i]) for i in range(1, n) if held[i] != held[i - 1])
    marks = sorted(t for t in breaks if t <= times[-1])
    cart.target = before
    position = np.empty(n)
    upcoming = 0
    for begin, end in pairwise(marks):
        while upcoming < len(pieces) and pieces[upcoming][0] <= begin + 1e-12:
            cart.follow(*pieces[upcoming])
            upcoming += 1
        i = round(begin / period) if abs(begin / period - round(begin / period)) < 1e-9 else int(begin / period)
        cart.held = 0.0 if run.held_force is None else float(run.held_force[i])
        cart.scale_k = 1.0 if run.stiffness_scale is None else float(run.stiffness_scale[i])
        cart.scale_m = 1.0 if run.mass_scale is None else float(run.mass_scale[i])
        cart.scale_c = 1.0 if run.damping_scale is None else float(run.damping_scale[i])
        inside = (times >= begin - 1e-12) & (times <= end + 1e-12)
        position[inside] = cart.run_until(end, np.clip(times[inside], begin, end))
    return position + run.get("sensor_drift", "rate") * times
