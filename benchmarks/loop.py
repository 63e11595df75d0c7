"""The plain compiled loop that an engineer who knows numba writes in an afternoon: what stepid's own is measured by.

Classical Runge-Kutta in equal substeps; where a substep passes a turn of the motion, an edge of the play or the stop, a
bracketed secant finds the moment. Dry friction holds the cart exactly; bristles and the lagged drive have closed forms.
One effect at a time, or one beside a lag: the rows of the table in kernel_speed.py.
"""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Mapping

import numpy as np
from numba import njit

FIELDS = (
    "mass stiffness damping gain forward backward extra velocity cubic gap stop_stiffness stop ripple wave phase "
    "mass2 stiffness2 damping2 lag level distance"
)
Plant = namedtuple("Plant", FIELDS)
PLACES = {name: i for i, name in enumerate(Plant._fields)}


@njit(cache=True, inline="always")
def plant_of(r):
    return Plant(
        r[0], r[1], r[2], r[3], r[4], r[5], r[6], r[7], r[8], r[9], r[10], r[11], r[12], r[13], r[14], r[15], r[16],
        r[17], r[18], r[19], r[20],
    )  # fmt: skip


@njit(cache=True, inline="always")
def bristle(z, moved, way, distance):
    """Bend after a move one way: back to zero without slip, then into slip exponentially."""
    bent, path = way * z, abs(moved)
    straight = -bent if bent < 0.0 else 0.0
    if path <= straight:
        return z + way * path
    bent = bent if bent > 0.0 else 0.0
    return way * (distance - (distance - bent) * np.exp((straight - path) / distance))


@njit(cache=True, inline="always")
def rates(p, x, v, x2, v2, z, drive, way, side, touched):
    """Accelerations of the cart and of the second mass."""
    stretch = x
    if p.gap > 0.0:
        stretch = x - side * p.gap if side != 0.0 else 0.0
    force = drive - p.stiffness * stretch - p.damping * v
    second = 0.0
    if p.cubic != 0.0:
        force -= p.cubic * x * x * x
    if touched:
        force -= p.stop_stiffness * (x - p.stop)
    if p.ripple != 0.0:
        force += p.ripple * np.sin(p.wave * x + p.phase)
    if p.level > 0.0:
        force -= p.level / p.distance * z
    if p.mass2 > 0.0:
        pull = p.stiffness2 * (x - x2) + p.damping2 * (v - v2)
        force -= pull
        second = pull / p.mass2
    if way != 0.0:
        friction = p.forward if way > 0.0 else p.backward
        if p.extra > 0.0:
            friction += p.extra * np.exp(-((v / p.velocity) ** 2))
        force -= way * friction
    return force / p.mass, second


@njit(cache=True)
def moved(p, x, v, x2, v2, z, start, goal, h, way, side, touched):
    """State and drive after h in one mode; the drive goes from `start` to `goal`."""
    middle = end = goal
    if p.lag > 0.0:
        fade = np.exp(-0.5 * h / p.lag)
        middle = goal + (start - goal) * fade
        end = goal + (start - goal) * fade * fade
    half, bristles = 0.5 * h, p.level > 0.0
    a1, b1 = rates(p, x, v, x2, v2, z, start, way, side, touched)
    v_one, w_one = v + half * a1, v2 + half * b1
    x_one = x + half * v
    bend = bristle(z, half * v, way, p.distance) if bristles else 0.0
    a2, b2 = rates(p, x_one, v_one, x2 + half * v2, w_one, bend, middle, way, side, touched)
    v_two, w_two = v + half * a2, v2 + half * b2
    x_two = x + half * v_one
    bend = bristle(z, half * v_one, way, p.distance) if bristles else 0.0
    a3, b3 = rates(p, x_two, v_two, x2 + half * w_one, w_two, bend, middle, way, side, touched)
    v_end, w_end = v + h * a3, v2 + h * b3
    bend = bristle(z, h * v_two, way, p.distance) if bristles else 0.0
    a4, b4 = rates(p, x + h * v_two, v_end, x2 + h * w_two, w_end, bend, end, way, side, touched)
    sixth = h / 6.0
    dx = sixth * (v + 2.0 * (v_one + v_two) + v_end)
    return (
        x + dx,
        v + sixth * (a1 + 2.0 * (a2 + a3) + a4),
        x2 + sixth * (v2 + 2.0 * (w_one + w_two) + w_end),
        v2 + sixth * (b1 + 2.0 * (b2 + b3) + b4),
        bristle(z, dx, way, p.distance) if bristles else 0.0,
        end,
    )


@njit(cache=True, inline="always")
def margin(p, kind, x, v, way, side, touched):
    """What is left before a mode ends: the turn of the motion (0), the edge of the play (1), the stop (2)."""
    if kind == 0:
        return way * v
    if kind == 1:
        return p.gap - abs(x) if side == 0.0 else side * x - p.gap
    beyond = x - p.stop if p.stop > 0.0 else p.stop - x
    return beyond if touched else -beyond


@njit(cache=True)
def moment(p, kind, x, v, x2, v2, z, start, goal, h, way, side, touched, low, high):
    """Share of the step at which a margin of `low` at its begin and `high` < 0 at its end is used up."""
    a, b, share = 0.0, 1.0, 1.0
    low = max(low, 0.0)
    for _ in range(30):
        share = a + (b - a) * low / (low - high) if low > 0.0 else 0.5 * (a + b)
        at = moved(p, x, v, x2, v2, z, start, goal, share * h, way, side, touched)
        left = margin(p, kind, at[0], at[1], way, side, touched)
        if abs(left) < 1e-10 or b - a < 1e-9:
            break
        if left < 0.0:
            b, high, low = share, left, 0.5 * low
        else:
            a, low, high = share, left, 0.5 * high
    return share


@njit(cache=True)
def run(p, inputs, period, parts, position, velocity, out):
    """Position at each sample, from a state at rest in all but `position` and `velocity`."""
    step = period / parts
    dry, bristles, play = p.forward > 0.0 or p.backward > 0.0, p.level > 0.0, p.gap > 0.0
    stops, signed = p.stop_stiffness > 0.0, dry or bristles
    watched = signed or play or stops
    x, v, x2, v2, z = position, velocity, position, velocity, 0.0
    drive = p.gain * inputs[0]
    way = np.sign(v) if signed else 0.0
    side = np.sign(x) if play and abs(x) > p.gap else 0.0
    touched = stops and margin(p, 2, x, v, way, side, True) > 0.0
    for i in range(inputs.size - 1):
        out[i] = x
        goal = p.gain * inputs[i]
        if p.lag == 0.0:
            drive = goal
        for _ in range(parts):
            left = step
            for _ in range(8):
                if signed and v == 0.0:  # holds, or sets off
                    net = rates(p, x, 0.0, x2, v2, z, drive, 0.0, side, touched)[0] * p.mass
                    if net > p.forward + p.extra:
                        way = 1.0
                    elif net < -p.backward - p.extra:
                        way = -1.0
                    elif dry:
                        if p.lag > 0.0:
                            drive = goal + (drive - goal) * np.exp(-left / p.lag)
                        break
                xn, vn, x2n, v2n, zn, ahead = moved(p, x, v, x2, v2, z, drive, goal, left, way, side, touched)
                first, which = 2.0, -1
                if watched:
                    for kind in range(3):
                        if (kind == 0 and not signed) or (kind == 1 and not play) or (kind == 2 and not stops):
                            continue
                        end = margin(p, kind, xn, vn, way, side, touched)
                        if end < -1e-13:
                            begin = margin(p, kind, x, v, way, side, touched)
                            share = moment(p, kind, x, v, x2, v2, z, drive, goal, left, way, side, touched, begin, end)
                            if share < first:
                                first, which = share, kind
                if which >= 0:
                    xn, vn, x2n, v2n, zn, ahead = moved(
                        p, x, v, x2, v2, z, drive, goal, first * left, way, side, touched
                    )
                x, v, x2, v2, z, drive = xn, vn, x2n, v2n, zn, ahead
                if which < 0:
                    break
                left -= first * left
                if which == 0:
                    v = 0.0
                elif which == 1:
                    side = np.sign(x) if side == 0.0 else 0.0
                else:
                    touched = not touched
    out[inputs.size - 1] = x


@njit(cache=True)
def run_rows(rows, inputs, period, parts, position, velocity, out):
    """Many plants, one a row."""
    for j in range(rows.shape[0]):
        run(plant_of(rows[j]), inputs, period, parts, position, velocity, out[j])


def row(
    mass: float, stiffness: float, damping: float, gain: float, effects: Mapping[str, Mapping[str, float]]
) -> np.ndarray:
    """A plant as one row of numbers."""
    found = np.zeros(len(PLACES))
    found[:4] = mass, stiffness, damping, gain
    for name, q in effects.items():
        for field, number in _numbers(name, q).items():
            found[PLACES[field]] = number
    return found


def _numbers(name: str, q: Mapping[str, float]) -> dict[str, float]:
    if name == "coulomb_friction":
        return {"forward": q["level"], "backward": q["level"]}
    if name == "stribeck_friction":
        sliding = {"forward": q["level"], "backward": q["level"]}
        return {**sliding, "extra": q["breakaway"] - q["level"], "velocity": q["velocity"]}
    if name == "cubic_stiffness":
        return {"cubic": q["coefficient"]}
    if name == "free_play":
        return {"gap": q["gap"]}
    if name == "end_stop":
        return {"stop_stiffness": q["stiffness"], "stop": q["position"]}
    if name == "cogging":
        return {"ripple": q["amplitude"], "wave": 2 * np.pi / q["pitch"], "phase": q["phase"]}
    if name == "flexible_coupling":
        return {"mass2": q["mass"], "stiffness2": q["stiffness"], "damping2": q["damping"]}
    if name == "actuator_lag":
        return {"lag": q["time_constant"]}
    if name == "presliding_hysteresis":
        return {"level": q["level"], "distance": q["distance"]}
    raise KeyError(name)
