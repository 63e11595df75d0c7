"""The drive force before its lag, as cubic pieces in time: delay, dead zone, saturation and rate limit are exact.

They depend on the command alone, not on the motion, so their corners are known before the plant is integrated.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from scipy.interpolate import CubicSpline

from .plant import Run

Curve = np.ndarray  # coefficients of 1, s, s², s³, with s the time since the piece began
Piece = tuple[float, Curve]
SAME = 1e-12  # share of the largest force, and s, below which two values are one


def is_curved(run: Run) -> bool:
    """Whether the drive changes within a sample by more than a jump."""
    return run.input_between != "held" or "actuator_rate_limit" in run.effects


def course(run: Run) -> tuple[float, list[Piece]]:
    """Force before the record, and the pieces from then on: each lasts until the next begins."""
    drive, delay, period = run.drive, run.get("input_delay", "delay"), run.sample_time
    before = float(drive[-1])
    if run.input_between == "held":
        changes = (i for i in range(run.size) if drive[i] != drive[i - 1])
        pieces = [(i * period + delay, np.array([float(drive[i]), 0.0, 0.0, 0.0])) for i in changes]
    else:
        pieces = _shaped(_command(run), run)
    if "actuator_rate_limit" in run.effects:
        pieces = _limited(before, pieces, abs(run.gain) * run.get("actuator_rate_limit", "rate"))
    return before, pieces


def value(curve: Curve, s: float) -> float:
    return float(((curve[3] * s + curve[2]) * s + curve[1]) * s + curve[0])


def _shifted(curve: Curve, s: float) -> Curve:
    _, b, c, d = curve
    return np.array([value(curve, s), b + s * (2 * c + 3 * d * s), c + 3 * d * s, d])


def _crossings(curve: Iterable[float], length: float) -> list[float]:
    """Where a polynomial passes zero within (0, length), in order."""
    coefficients = np.array(list(curve), float)
    reach = length if math.isfinite(length) else 1.0
    terms = np.abs(coefficients) * reach ** np.arange(coefficients.size)
    kept = np.flatnonzero(terms > 1e-15 * max(float(terms.max()), 1e-300))
    if kept.size == 0 or kept[-1] == 0:
        return []
    roots = np.polynomial.polynomial.polyroots(coefficients[: kept[-1] + 1])
    real = roots[np.abs(roots.imag) < 1e-9 * np.maximum(np.abs(roots), reach * 1e-6)].real
    return [float(s) for s in np.sort(real) if SAME < s < length - SAME]


def _command(run: Run) -> list[Piece]:
    """Volts joined between the samples, delayed."""
    u, period, delay = np.asarray(run.inputs, float), run.sample_time, run.get("input_delay", "delay")
    if run.input_between == "straight":
        slopes = np.diff(u) / period
        curves = np.column_stack([u[:-1], slopes, 0 * slopes, 0 * slopes])
    elif run.input_between == "smooth":
        curves = CubicSpline(period * np.arange(u.size), u).c[::-1].T
    else:
        raise ValueError(f"no such way between the samples: {run.input_between!r}")
    pieces = [(i * period + delay, curve) for i, curve in enumerate(curves)]
    return [*pieces, ((u.size - 1) * period + delay, np.array([u[-1], 0.0, 0.0, 0.0]))]


def _ends(pieces: list[Piece]) -> list[float]:
    return [*(begin for begin, _ in pieces[1:]), math.inf]


def _shaped(pieces: list[Piece], run: Run) -> list[Piece]:
    """Force after dead zone and saturation; a piece is cut where it passes one of their edges."""
    dead = run.get("actuator_dead_zone", "level")
    limit = run.get("actuator_saturation", "level", math.inf)
    edges = [sign * e for e in (dead, dead + limit) if 0 < e < math.inf for sign in (-1, 1)]
    made: list[Piece] = []
    for (begin, curve), end in zip(pieces, _ends(pieces), strict=True):
        length = end - begin
        cuts = sorted({s for e in edges for s in _crossings(curve - [e, 0, 0, 0], length)})
        for low, high in zip([0.0, *cuts], [*cuts, length], strict=True):
            middle = value(curve, low + 1.0 if math.isinf(high) else (low + high) / 2)
            own = _shifted(curve, low)
            if abs(middle) >= dead + limit:
                own = np.array([math.copysign(limit, middle), 0.0, 0.0, 0.0])
            elif abs(middle) <= dead and dead > 0:
                own = np.zeros(4)
            else:
                own[0] -= math.copysign(dead, middle)
            made.append((begin + low, run.gain * own))
    return made


def _gentle(curve: Curve, rate: float, length: float) -> tuple[float, float]:
    """How far along a curve it is no steeper than `rate`, and which way it is too steep from there (0: nowhere)."""
    slope = np.array([curve[1], 2 * curve[2], 3 * curve[3]])
    cuts = sorted(s for way in (-rate, rate) for s in _crossings(slope - [way, 0, 0], length))
    for low, high in zip([0.0, *cuts], [*cuts, length], strict=True):
        middle = low + 1.0 if math.isinf(high) else (low + high) / 2
        steep = float(slope @ [1.0, middle, middle**2])
        if abs(steep) > rate:
            return low, steep
    return length, 0.0


def _limited(before: float, pieces: list[Piece], rate: float) -> list[Piece]:
    """What follows the pieces no faster than `rate`: along them, or on straight ramps towards them."""
    made: list[Piece] = []
    now = before
    size = SAME * max([abs(before), *(abs(curve[0]) for _, curve in pieces)], default=0.0)
    for (begin, curve), end in zip(pieces, _ends(pieces), strict=True):
        s, length = 0.0, end - begin
        while s < length - SAME:
            rest, steep = _shifted(curve, s), 0.0
            if abs(rest[0] - now) <= size:
                upto, steep = _gentle(rest, rate, length - s)
                if upto > 0:
                    made.append((begin + s, rest))
                if steep == 0.0:
                    break
                s += upto
                rest = _shifted(curve, s)
                now = float(rest[0])
            way = math.copysign(rate, steep or rest[0] - now)
            made.append((begin + s, np.array([now, way, 0.0, 0.0])))
            apart = np.array([rest[0] - now, rest[1] - way, rest[2], rest[3]])
            if steep:  # the ramp leaves the curve here: not this meeting, the next
                apart = apart[1:] if abs(apart[1]) > 1e-9 * rate else apart[2:]
            meetings = _crossings(apart, length - s)
            if not meetings:
                break
            s += meetings[0]
            now = value(curve, s)
        if math.isfinite(end):
            last, own = made[-1]
            now = value(own, end - last)
    return made
