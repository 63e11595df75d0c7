"""Many runs at once: classical Runge-Kutta in micro-steps, each change of mode located by a bracketed secant.

Another formulation than `reference`: the bristle force is the closed form along each branch between reversals, the
lagged drive is the exact exponential, and a delayed input splits each sample in two; a drive that changes within a
sample splits it at each of its corners.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from .drive import course, is_curved
from .plant import SLOWEST, Run
from .rows import Rows, V, X

FINENESS = 0.05  # micro-step times the fastest rate of the run
EDGE = 1e-13  # m past the edge of the play or the stop, where a mode begins
SHARP = 32  # parts of a micro-step in which a cart under a power law may stop
Stretch = tuple[np.ndarray, np.ndarray | float, np.ndarray]  # target, when its curve began, length


def micro_steps(run: Run, fineness: float = FINENESS) -> int:
    """Micro-steps a sample, a power of two, from the fastest rate that the run's effects can show."""
    m, k = run.mass, run.stiffness
    stiff = k + run.get("viscoelastic_spring", "stiffness") + run.get("flexible_coupling", "stiffness")
    stiff += run.get("end_stop", "stiffness")
    swing = 2.2 * float(np.max(np.abs(run.drive))) / k + abs(run.start)
    stiff += 3 * abs(run.get("cubic_stiffness", "coefficient")) * swing**2
    stiff += 2 * abs(run.get("quadratic_stiffness", "coefficient")) * swing
    if run.stiffness_scale is not None:
        stiff *= float(np.max(run.stiffness_scale))
    pull = k * swing / m
    speed = swing * np.sqrt(k / m)
    drag = run.damping + 2 * run.get("quadratic_damping", "coefficient") * speed
    rates = [drag / m, 2 * np.pi * run.get("periodic_disturbance", "frequency")]
    if "flexible_coupling" in run.effects:
        m2 = run.get("flexible_coupling", "mass")
        rates.append(np.sqrt(run.get("flexible_coupling", "stiffness") / m2 * (1 + m2 / m)))
        rates.append(run.get("flexible_coupling", "damping") / m2)
    if "viscoelastic_spring" in run.effects:
        rates.append(run.get("viscoelastic_spring", "stiffness") / run.get("viscoelastic_spring", "damping"))
    if "presliding_hysteresis" in run.effects:
        distance = run.get("presliding_hysteresis", "distance")
        stiff += run.get("presliding_hysteresis", "level") / distance
        rates.append(0.4 * np.sqrt(pull / distance))
    if "stribeck_friction" in run.effects:
        rates.append(0.1 * pull / run.get("stribeck_friction", "velocity"))
    if "cogging" in run.effects:
        turn = 2 * np.pi / run.get("cogging", "pitch")
        stiff += run.get("cogging", "amplitude") * turn
        rates.append(0.12 * speed * turn)
    if "sine_stiffness" in run.effects:
        rates.append(speed * run.get("sine_stiffness", "curvature"))
    if "power_damping" in run.effects:
        p, drag = run.get("power_damping", "exponent"), run.get("power_damping", "coefficient") / m
        slowest = 0.03 * drag * SLOWEST ** (p - 1) if p < 1 else p * drag * speed ** (p - 1)
        rates.append(max(slowest, 0.05 * 32 / run.sample_time if p < 2 else 0.0))
    if run.sticky is not None:
        rates.append(speed / run.sticky[2])
    if run.law is not None:
        rates.append(0.2 * run.law.rate)
    if "actuator_lag" in run.effects:
        rates.append(0.3 / run.get("actuator_lag", "time_constant"))
    rates.append(np.sqrt(stiff / m))
    wanted = run.sample_time * max(rates) / fineness
    return int(2 ** np.ceil(np.log2(np.clip(wanted, 4, 1024))))


def _advance(rows: Rows, h: np.ndarray) -> None:
    """One micro-step of all rows, in parts for those that a power law may stop."""
    sharp = rows.sharp(h)
    if not sharp.any():
        _step(rows, h)
        return
    for where, parts in ((np.flatnonzero(sharp), SHARP), (np.flatnonzero(~sharp), 1)):
        if where.size:
            some = rows.pick(where)
            for _ in range(parts):
                _step(some, h[where] / parts)
            rows.put(where, some)


def _step(rows: Rows, h: np.ndarray) -> None:
    """One micro-step, with every change of mode inside it."""
    y, drive = rows.stepped(h)
    watch = rows.signed.any() or "free_play" in rows.has or "end_stop" in rows.has
    late = (rows.guard(y, rows.t + h, drive) < 0).any(axis=0) if watch else np.zeros(0, bool)
    if late.any():
        where = np.flatnonzero(late)
        some = rows.pick(where)
        left = h[where].copy()
        rows.y, rows.drive, rows.t = y, drive, rows.t + h
        for _ in range(12):
            left = _to_event(some, left)
            if not (left > 0).any():
                break
        else:  # chatter: finish the micro-step in the present mode
            some.y, some.drive = some.stepped(left)
            some.t = some.t + left
        rows.put(where, some)
        return
    rows.y, rows.drive, rows.t = y, drive, rows.t + h


def _to_event(some: Rows, left: np.ndarray) -> np.ndarray:
    """Move each row to its next event or to the end of its step; return the time still left."""
    y, drive = some.stepped(left)
    end = some.guard(y, some.t + left, drive).min(axis=0)
    hit = (end < 0) & (left > 0)
    low, high = np.zeros_like(left), left.copy()
    g_low, g_high = np.maximum(some.guard(some.y, some.t, some.drive).min(axis=0), 0.0), end.copy()
    with np.errstate(invalid="ignore", divide="ignore"):
        for _ in range(40):
            guess = np.where(hit, low + (high - low) * g_low / (g_low - g_high), left)
            guess = np.where(hit & ~np.isfinite(guess), low, guess)
            y, drive = some.stepped(guess)
            g = some.guard(y, some.t + guess, drive).min(axis=0)
            under = g < 0
            g_low = np.where(under, g_low / 2, g)
            g_high = np.where(under, g, g_high / 2)
            low, high = np.where(under, low, guess), np.where(under, guess, high)
            if not (hit & (np.abs(g) > 1e-13) & (high - low > 1e-13 * left)).any():
                break
    y, drive = some.stepped(guess)
    guards = some.guard(y, some.t + guess, drive)
    first = np.argmin(np.where(np.isfinite(guards), np.abs(guards), np.inf), axis=0)
    some.y, some.drive, some.t = y, drive, some.t + guess
    x = some.y[X]
    turn = hit & (first == 0)
    if "presliding_hysteresis" in some.has:
        z = np.where(some.sign == 0, some.zb, some.bristle(x))
        some.xb, some.zb = np.where(turn, x, some.xb), np.where(turn, z, some.zb)
    some.y[V] = np.where(turn, 0.0, some.y[V])
    slip = hit & (first == 1)
    if turn.any():
        some.choose_sign(turn)
    if slip.any():
        net = some.push(some.y, some.t, some.drive)
        some.sign = np.where(slip, np.where(net > 0, 1.0, -1.0), some.sign)
    play = hit & (first == 2)
    some.side = np.where(play, np.where(some.side == 0, np.sign(x), 0.0), some.side)
    stop = hit & (first == 3)
    some.touch = some.touch ^ stop
    # just past the edge: on it, or before it by rounding, the new mode would end where it begins
    edge = np.sign(x) * (some.gap + np.where(some.side == 0, -EDGE, EDGE))
    some.y[X] = np.where(play, edge, x)
    past = some.stop + np.sign(some.stop) * np.where(some.touch, EDGE, -EDGE)
    some.y[X] = np.where(stop, past, some.y[X])
    return np.where(hit, left - guess, 0.0)


def _table(values: Sequence[np.ndarray], longest: int) -> np.ndarray:
    return np.array([np.concatenate([v, np.full(longest - v.size, v[-1])]) for v in values])


def _held(runs: Sequence[Run], longest: int) -> Iterator[list[Stretch]]:
    """For each sample, the targets that hold in it."""
    period = np.array([r.sample_time for r in runs])
    delay = np.array([r.get("input_delay", "delay") for r in runs])
    whole = np.floor(delay / period + 1e-12).astype(int)
    part = np.clip(delay - whole * period, 0.0, None)
    before = [float(r.drive[-1]) for r in runs]
    drive = np.column_stack([before, _table([r.drive[:-1] for r in runs], longest)])
    every, split = np.arange(len(runs)), bool((part > 0).any())
    for i in range(longest - 1):
        pieces = [(i - whole - 1, part), (i - whole, period - part)] if split else [(i - whole, period)]
        yield [(drive[every, np.maximum(index + 1, 0)], 0.0, length) for index, length in pieces]


def _curved(runs: Sequence[Run], longest: int) -> Iterator[list[Stretch]]:
    """The same for drives that are curves within a sample; runs with fewer corners wait for the others."""
    courses = []
    for run in runs:
        before, pieces = course(run)
        courses.append([(-np.inf, np.array([before, 0.0, 0.0, 0.0])), *pieces])
    at = [0] * len(runs)
    for i in range(longest - 1):
        plans: list[list[tuple[np.ndarray, float, float]]] = []
        for j, run in enumerate(runs):
            now, end, plan = i * run.sample_time, (i + 1) * run.sample_time, []
            while now < end:
                while at[j] + 1 < len(courses[j]) and courses[j][at[j] + 1][0] <= now + 1e-12:
                    at[j] += 1
                begin, curve = courses[j][at[j]]
                upto = min(end, courses[j][at[j] + 1][0]) if at[j] + 1 < len(courses[j]) else end
                plan.append((curve, max(begin, -1.0), upto - now))
                now = upto
            plans.append(plan)
        most = max(len(plan) for plan in plans)
        plans = [plan + [(plan[-1][0], plan[-1][1], 0.0)] * (most - len(plan)) for plan in plans]
        yield [
            (np.column_stack([curve for curve, _, _ in some]), np.array([s for _, s, _ in some]), np.array(lengths))
            for some in zip(*plans, strict=True)
            for lengths in [[length for _, _, length in some]]
        ]


def _bucket(runs: Sequence[Run], steps: int) -> list[np.ndarray]:
    rows = Rows(runs)
    longest = max(r.size for r in runs)
    extras = {}
    for name, blank, into in (
        ("held_force", 0.0, "held"),
        ("stiffness_scale", 1.0, "scale_k"),
        ("mass_scale", 1.0, "scale_m"),
        ("damping_scale", 1.0, "scale_c"),
    ):
        if any(getattr(r, name) is not None for r in runs):
            extras[into] = _table(
                [np.full(r.size, blank) if (v := getattr(r, name)) is None else v for r in runs], longest
            )
    out = np.empty((longest, len(runs)))
    out[0] = rows.y[X]
    stretches = (_curved if is_curved(runs[0]) else _held)(runs, longest)
    for i, some in enumerate(stretches):
        for into, values in extras.items():
            setattr(rows, into, values[:, i])
        for target, since, length in some:
            rows.target, rows.since = target, rows.since * 0 + since
            if target.ndim == 2:
                rows.drive = rows.lagged(0 * rows.t)
            if rows.signed.any():
                still = rows.signed & (rows.sign == 0)
                if still.any():
                    rows.choose_sign(still)
            for _ in range(steps):
                _advance(rows, length / steps)
        out[i + 1] = rows.y[X]
    return [
        out[: r.size, j] + r.get("sensor_drift", "rate") * np.arange(r.size) * r.sample_time for j, r in enumerate(runs)
    ]


def fast(runs: Sequence[Run], *, fineness: float = FINENESS) -> list[np.ndarray]:
    """Reading at each sample of each run, m, from the spring's rest position.

    A run's result does not depend on the company it is simulated in (but for rounding).
    """
    buckets: dict[tuple[int, bool, bool], list[int]] = {}
    for j, run in enumerate(runs):
        key = (micro_steps(run, fineness), "input_delay" in run.effects, is_curved(run))
        buckets.setdefault(key, []).append(j)
    results: list[np.ndarray] = [np.empty(0)] * len(runs)
    for (steps, _, _), members in buckets.items():
        for j, x in zip(members, _bucket([runs[j] for j in members], steps), strict=True):
            results[j] = x
    return results
