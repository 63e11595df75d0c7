"""The kernel: one plant follows one record, step by step, event by event.

Read it from the bottom: `simulate` takes replicas (one plant, one record) in turn, `_follow_record` goes from sample to
sample, `_advance` from event to event, `_step` is one Runge-Kutta step, `_evaluate` the equation of motion. All of it
is plain Python on floats and small arrays, compiled by numba where numba is there.

A state `y` is position [m] from the spring's rest, velocity [m/s], then each effect's own states: first those with a
rate in time, then its memories, which follow the displacement. Between events the law is smooth: the direction of
motion, `m[SIGN]`, whether friction holds the cart, `m[HELD]`, and the sides of the switches, `w.sides`, stay as they
are.

The step is Dormand and Prince's of order five (Hairer, Nørsett, Wanner, Solving Ordinary Differential Equations I,
table II.5.2); its embedded error chooses the step length, so that no law has to say how fast it is. Where the law is
affine between events and the input held, a step without event is exact, by the matrix exponential.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from stepid.simulation.compiled import JIT, call, compiled, inlined

Array = Any  # numba knows the types

# what a law is asked for (`stepid.simulation.laws` writes the answers)
EVALUATE, SWITCHES, BREAKAWAY, REMEMBER, RELAX, AT_REST, DELAY, READING, KINK = range(9)
# the moment, as laws see it beside the state
SIGN, TIME, MASS, STIFFNESS, DAMPING, VOLTS, SLOPE, SPAN, HELD, BEND, JERK, MOMENT = range(12)
# a plant's values: these, then the effects' parameters
Q_MASS, Q_STIFFNESS, Q_DAMPING, Q_GAIN, Q_FIRST = range(5)
# an effect's place: where its values, states and sides begin, how many there are, what it does
VALUES, OWN, SIDES, N_EXTRA, N_MEMORY, N_SWITCHES, DRIVES, DRY, RELAXES, DELAYS, READS, KINKS, PLACE = range(13)
# what a law writes when it is evaluated
FORCE, FRICTION, DRIVEN, RATES = range(4)

_A = np.array(
    [
        [0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [1 / 5, 0.0, 0.0, 0.0, 0.0, 0.0],
        [3 / 40, 9 / 40, 0.0, 0.0, 0.0, 0.0],
        [44 / 45, -56 / 15, 32 / 9, 0.0, 0.0, 0.0],
        [19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729, 0.0, 0.0],
        [9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656, 0.0],
        [35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84],
    ]
)
_C = np.array([0.0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0, 1.0])
_E = np.array([71 / 57600, 0.0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40])
_STAGES = 7
_ORDER = 5.0

_STILL = 5e-7  # of a typical velocity, slower than this is at rest where dry friction acts
_CROSSED = 1e-13  # m or m/s, by which a margin must be past zero
_EVENTS = 64  # between two changes of the input, at most; the rest of such a sample is followed without
_SHORTEST = 1e-7  # of a sample, to which a step may shrink
_LOOKS = 4  # a stretch of input, at least, whether a held cart breaks loose
_RESOLVED = 8.0  # changes of the force on a held cart that make up what holds it, one a look
_LOCATE = 60  # tries to locate an event
_FAR = 1e3  # positions this many times larger than the scale are a runaway
_UNSEEN = 100.0  # radians of a plant's swing between two samples, of which no more are worth a step
_CREDIT = 1000.0  # steps that a plant may take beside its patience, where something is narrow
_SWING = 1.0  # (ω h)², up to which an affine plant may leap: it cannot turn back twice on the way
_SAME = 1e-9  # relative, lengths of steps that differ by the rounding of times only
_OFF = 0.01  # of the change of a slope within a step, that a cubic through its ends may be off
_AT_END = 0.999  # of a step, beyond which what happens is its end
_TERMS = 16  # of the exponential's series, for a matrix of norm 1/2


MOST_EFFECTS, MOST_STATES, MOST_SWITCHES, MOST_VALUES = 8, 16, 8, 64

WORK = np.dtype(
    [
        ("effects", np.int64),  # how many
        ("states", np.int64),
        ("switches", np.int64),
        ("laws", np.int64 if JIT else object, MOST_EFFECTS),  # one an effect
        ("places", np.int64, (MOST_EFFECTS, PLACE)),
        ("q", np.float64, MOST_VALUES),  # values of the plant
        ("ease", np.float64),  # 1/kg, what a force of 1 N adds to the acceleration
        ("reverses", np.int64),  # whether the law changes where the velocity changes sign
        ("dry", np.int64),  # whether friction can hold the cart
        ("leaps", np.int64),  # 1 where the law is affine between events and the input held, 2 where it has no events
        ("stale", np.int64),  # 1 where the constant of the affine law has changed, 2 where its matrix has
        ("known", np.int64),  # whether own states are known in closed form
        ("relaxing", np.int64),  # how many effects until the last one whose states follow the drive in closed form
        ("kinked", np.int64),  # whether some of these turn a corner
        ("rated", np.int64),  # whether own states have a rate
        ("m", np.float64, MOMENT),
        ("u", np.float64, 5),  # the input: since when, and its polynomial in the time since then
        ("sides", np.float64, MOST_SWITCHES),  # of the switches, -1 or 1
        ("out", np.float64, 4 + MOST_STATES),  # what a law writes
        ("k", np.float64, (_STAGES + 1, MOST_STATES)),  # rates at the stages of a step, and room for others
        ("y", np.float64, MOST_STATES),  # the state
        ("stage", np.float64, MOST_STATES),  # the state at a stage; after a step, where it leads
        ("margin", np.float64, 1 + MOST_SWITCHES),  # how far each event is
        ("patience", np.int64),  # steps a sample that a plant is worth, and as many a radian of its swing
        ("credit", np.float64),  # what is left of them
        ("taken", np.int64),  # steps of all replicas so far
        ("far", np.float64),  # m, from where on it is a runaway
        ("still", np.float64),  # m/s, below which it is at rest where dry friction acts
        ("net", np.float64),  # force on a held cart, N, when it was last looked at
        ("rate", np.float64),  # its fastest change so far, N/s
        ("chain", np.float64, (MOST_EFFECTS, 4)),  # volts that reach each effect of the drive in a step, a cubic
        ("begins", np.float64, 1 + MOST_SWITCHES),  # the same where a step begins
        ("ends", np.float64, 1 + MOST_SWITCHES),  # and where it ends
        ("turn", np.float64, MOST_STATES),  # the state where the cart turns back within a step
        ("allowed", np.float64, MOST_STATES),  # error of each state that a step may make; below 0 relative to its size
        ("matrix", np.float64, (MOST_STATES, MOST_STATES)),  # of a linear law, and its constant
        ("constant", np.float64, MOST_STATES),
        ("leap", np.float64),  # s, for which there are the exponential and its integral
        ("phi", np.float64, (MOST_STATES, MOST_STATES)),
        ("psi", np.float64, (MOST_STATES, MOST_STATES)),
        ("term", np.float64, (MOST_STATES, MOST_STATES)),  # room
        ("new", np.float64, (MOST_STATES, MOST_STATES)),
    ]
)
"""A plant and the room to follow it in."""
Work = Any


@compiled
def _copy(there: Array, here: Array, size: int) -> None:
    for j in range(size):
        here[j] = there[j]


@compiled
def _clear(here: Array, size: int) -> None:
    for j in range(size):
        here[j] = 0.0


@compiled
def _input(w: Work, t: float) -> float:
    s = t - w.u[0]
    return w.u[1] + s * (w.u[2] + s * (w.u[3] + s * w.u[4]))


@compiled
def _slope(w: Work, t: float) -> float:
    s = t - w.u[0]
    return w.u[2] + s * (2.0 * w.u[3] + s * 3.0 * w.u[4])


@compiled
def _ask(w: Work, kind: int, e: int, y: Array) -> float:
    return call(w.laws[e], kind, w.q, w.places[e, VALUES], w.m, y, w.places[e, OWN], w.sides, w.places[e, SIDES], w.out)


@inlined
def _evaluate(w: Work, t: float, y: Array, dy: Array) -> float:
    """Write the rates of the state; return the force on the cart without dry friction, N."""
    m, out, q = w.m, w.out, w.q
    m[TIME] = t
    raw = _input(w, t)
    driven = raw
    force = 0.0
    friction = 0.0
    for e in range(w.effects):
        m[VOLTS] = driven if w.places[e, DRIVES] else raw
        _ask(w, EVALUATE, e, y)
        force += out[FORCE]
        friction += out[FRICTION]
        if w.places[e, DRIVES]:
            driven = out[DRIVEN]
        for j in range(w.places[e, N_EXTRA]):
            dy[w.places[e, OWN] + j] = out[RATES + j]
        for j in range(w.places[e, N_EXTRA], w.places[e, N_EXTRA] + w.places[e, N_MEMORY]):
            dy[w.places[e, OWN] + j] = 0.0
    force += q[Q_GAIN] * driven - q[Q_STIFFNESS] * y[0] - q[Q_DAMPING] * y[1]
    if m[HELD] > 0.0:
        dy[0] = 0.0
        dy[1] = 0.0
    else:
        dy[0] = y[1]
        dy[1] = (force - m[SIGN] * friction) * w.ease
    return force


@compiled
def _see(w: Work, e: int, s: float) -> None:
    """Put the volts that reach an effect of the drive `s` [s] after the start of a step, and their derivatives."""
    m, c = w.m, w.chain
    m[VOLTS] = c[e, 0] + s * (c[e, 1] + s * (c[e, 2] + s * c[e, 3]))
    m[SLOPE] = c[e, 1] + s * (2.0 * c[e, 2] + s * 3.0 * c[e, 3])
    m[BEND] = 2.0 * c[e, 2] + s * 6.0 * c[e, 3]
    m[JERK] = 6.0 * c[e, 3]


@compiled
def _relax(w: Work, e: int, t: float, s: float, span: float, y: Array, after: Array) -> None:
    """Write the own states of an effect of the drive `span` [s] after `y`, `s` [s] after the start of a step."""
    _see(w, e, s)
    w.m[TIME], w.m[SPAN] = t + s, span
    _ask(w, RELAX, e, y)
    for j in range(w.places[e, OWN], w.places[e, OWN] + w.places[e, N_EXTRA]):
        after[j] = w.out[j - w.places[e, OWN]]


@compiled
def _handed_on(w: Work, e: int, t: float, s: float) -> float:
    """Volts that an effect of the drive hands on `s` [s] after the start of a step."""
    if w.places[e, RELAXES]:
        _relax(w, e, t, 0.0, s, w.y, w.stage)
    _see(w, e, s)
    w.m[TIME] = t + s
    _ask(w, EVALUATE, e, w.stage)
    return w.out[DRIVEN]


@compiled
def _follow_drive(w: Work, t: float, h: float) -> float:
    """Write `w.chain` for a step, through four moments; return its error over what is allowed.

    A cubic that misses what is handed on gives the cart a wrong push for the length of the step; a law that leads
    elsewhere in one step than in two leaves a wrong force behind.
    """
    c, q = w.chain, w.q
    s = t - w.u[0]
    c0, c1, c2, c3 = _input(w, t), _slope(w, t), w.u[3] + 3.0 * s * w.u[4], w.u[4]
    missed, apart = 0.0, 0.0
    if w.relaxing > 1:
        _copy(w.y, w.stage, w.states)
    for e in range(w.relaxing):
        if not w.places[e, DRIVES]:
            continue
        c[e, 0], c[e, 1], c[e, 2], c[e, 3] = c0, c1, c2, c3
        own, changing = w.places[e, OWN], c1 != 0.0 or c2 != 0.0 or c3 != 0.0
        if w.places[e, RELAXES] and changing:
            spare = w.k[_STAGES]
            _relax(w, e, t, 0.0, 0.5 * h, w.y, w.stage)
            _relax(w, e, t, 0.5 * h, 0.5 * h, w.stage, spare)
            _relax(w, e, t, 0.0, h, w.y, w.stage)
            for j in range(own, own + w.places[e, N_EXTRA]):
                apart = max(apart, abs(spare[j] - w.stage[j]) - 1e-14 * abs(spare[j]))
        if e + 1 == w.relaxing:
            break
        c0 = _handed_on(w, e, t, 0.0)
        if w.places[e, RELAXES] or changing:
            one, two, end = _handed_on(w, e, t, h / 3.0), _handed_on(w, e, t, h / 1.5), _handed_on(w, e, t, h)
            middle = _handed_on(w, e, t, 0.5 * h)
            missed = max(missed, abs(middle - (9.0 * (one + two) - c0 - end) / 16.0))
            one, two, end = one - c0, two - c0, end - c0
            c1, c2, c3 = end / h, 0.0, 0.0
            if abs(3.0 * one - end) + abs(1.5 * two - end) > 1e-12 * abs(c0):  # or rounding would look like a curve
                c1 = (9.0 * one - 4.5 * two + end) / h
                c2 = (-22.5 * one + 18.0 * two - 4.5 * end) / (h * h)
                c3 = (13.5 * (one - two) + 4.5 * end) / (h * h * h)
        else:
            c1, c2, c3 = 0.0, 0.0, 0.0
    push, force = missed * h / (q[Q_MASS] * w.allowed[1]), apart / (abs(q[Q_STIFFNESS]) * w.allowed[0])
    return abs(q[Q_GAIN]) * max(push, force)


@compiled
def _kink(w: Work, t: float, h: float) -> float:
    """Time until an own state that follows the drive turns a corner next, s, by the drive of a step as long as `h`.

    A step ends there: across a corner it would be as wrong as is allowed, and derivatives far more so.
    """
    if not w.kinked:
        return np.inf
    _follow_drive(w, t, h)
    w.m[TIME] = t
    least = np.inf
    for e in range(w.relaxing):
        if w.places[e, KINKS]:
            _see(w, e, 0.0)
            least = min(least, _ask(w, KINK, e, w.y))
    return least


@compiled
def _own_states(w: Work, t: float, span: float, y: Array, after: Array, again: bool) -> None:
    """Write into `after` the states that are known in closed form `span` [s] after `y`: lags and memories.

    The last two stages of a step are at its end: there the lags are in `w.k[_STAGES]` when they are asked for `again`.
    """
    for e in range(w.effects):
        if w.places[e, RELAXES]:
            if again:
                for j in range(w.places[e, OWN], w.places[e, OWN] + w.places[e, N_EXTRA]):
                    after[j] = w.k[_STAGES, j]
            else:
                _relax(w, e, t, 0.0, span, y, after)
        if w.places[e, N_MEMORY]:
            w.m[SPAN] = after[0] - y[0]
            _ask(w, REMEMBER, e, y)
            own = w.places[e, OWN] + w.places[e, N_EXTRA]
            for j in range(w.places[e, N_MEMORY]):
                after[own + j] = w.out[j]


@compiled
def _own_at_stage(w: Work, t: float, h: float, s: int) -> None:
    """Write the effects' own states at a stage of a step."""
    y, z, k = w.y, w.stage, w.k
    for j in range(2, w.states):
        if w.allowed[j] == 0.0:
            continue  # known in closed form
        total = 0.0
        for i in range(s):
            total += _A[s, i] * k[i, j]
        z[j] = y[j] + h * total
    if w.known:
        _own_states(w, t, _C[s] * h, y, z, s == _STAGES - 1)
        if s == _STAGES - 2:
            _copy(z, k[_STAGES], w.states)


@inlined
def _at_stage(w: Work, t: float, h: float, s: int, x: float, v: float) -> float:
    """Write the state and its rates at a stage of a step, the cart being at x and v; return its acceleration, m/s²."""
    w.stage[0], w.stage[1] = x, v
    if w.states > 2:
        _own_at_stage(w, t, h, s)
    _evaluate(w, t + _C[s] * h, w.stage, w.k[s])
    return w.k[s, 1]


@compiled
def _excess(w: Work, h: float, worst: float) -> float:
    """Error of the effects' own states over what is allowed, the largest of all, and of `worst`."""
    y, z, k = w.y, w.stage, w.k
    for j in range(2, w.states):
        total = 0.0
        for i in range(_STAGES):
            total += _E[i] * k[i, j]
        allowed = w.allowed[j]
        if allowed < 0.0:  # what has only just left zero is judged by where it goes
            allowed *= -max(abs(y[j]), abs(z[j]), abs(k[_STAGES - 1, j]) * w.allowed[0] / w.allowed[1])
        if allowed > 0.0:
            worst = max(worst, abs(h * total) / allowed)
        if z[j] != z[j]:
            worst = np.inf
    return worst


@compiled
def _step(w: Work, t: float, h: float) -> float:
    """Step from `w.y` to `w.stage`, the rates at its start being `w.k[0]`; return its error over what is allowed.

    The cart's two states are written out: as numbers, not in arrays, they take two thirds of the time. `p` is the rate
    of the position, none while the cart is held. In each sum the newest rate comes last: a step takes as long as the
    chain in which each waits for the one before.
    """
    y, k = w.y, w.k
    if w.m[HELD] > 0.0 and not w.rated:  # nothing moves
        _copy(y, w.stage, w.states)
        _clear(k[_STAGES - 1], w.states)
        return 0.0
    worst = _follow_drive(w, t, h) if w.relaxing else 0.0
    moves = 0.0 if w.m[HELD] > 0.0 else 1.0
    x, v, p0, a0 = y[0], y[1], k[0, 0], k[0, 1]
    v1 = v + h * (_A[1, 0] * a0)
    a1, p1 = _at_stage(w, t, h, 1, x + h * (_A[1, 0] * p0), v1), moves * v1
    v2 = v + h * (_A[2, 0] * a0) + h * _A[2, 1] * a1
    a2, p2 = _at_stage(w, t, h, 2, x + h * (_A[2, 0] * p0 + _A[2, 1] * p1), v2), moves * v2
    v3 = v + h * (_A[3, 0] * a0 + _A[3, 1] * a1) + h * _A[3, 2] * a2
    x3 = x + h * (_A[3, 0] * p0 + _A[3, 1] * p1 + _A[3, 2] * p2)
    a3, p3 = _at_stage(w, t, h, 3, x3, v3), moves * v3
    v4 = v + h * (_A[4, 0] * a0 + _A[4, 1] * a1 + _A[4, 2] * a2) + h * _A[4, 3] * a3
    x4 = x + h * (_A[4, 0] * p0 + _A[4, 1] * p1 + _A[4, 2] * p2 + _A[4, 3] * p3)
    a4, p4 = _at_stage(w, t, h, 4, x4, v4), moves * v4
    v5 = v + h * (_A[5, 0] * a0 + _A[5, 1] * a1 + _A[5, 2] * a2 + _A[5, 3] * a3) + h * _A[5, 4] * a4
    x5 = x + h * (_A[5, 0] * p0 + _A[5, 1] * p1 + _A[5, 2] * p2 + _A[5, 3] * p3 + _A[5, 4] * p4)
    a5, p5 = _at_stage(w, t, h, 5, x5, v5), moves * v5
    v6 = v + h * (_A[6, 0] * a0 + _A[6, 2] * a2 + _A[6, 3] * a3 + _A[6, 4] * a4) + h * _A[6, 5] * a5
    x6 = x + h * (_A[6, 0] * p0 + _A[6, 2] * p2 + _A[6, 3] * p3 + _A[6, 4] * p4 + _A[6, 5] * p5)
    a6, p6 = _at_stage(w, t, h, 6, x6, v6), moves * v6
    missed_x = _E[0] * p0 + _E[2] * p2 + _E[3] * p3 + _E[4] * p4 + _E[5] * p5 + _E[6] * p6
    missed_v = _E[0] * a0 + _E[2] * a2 + _E[3] * a3 + _E[4] * a4 + _E[5] * a5 + _E[6] * a6
    if x6 != x6 or v6 != v6:
        return np.inf
    worst = max(worst, abs(h * missed_x) / w.allowed[0], abs(h * missed_v) / w.allowed[1])
    return _excess(w, h, worst) if w.states > 2 else worst


@compiled
def _hold(w: Work, y: Array) -> float:
    """Largest force that dry friction holds against a push in direction `m[SIGN]`, N."""
    total = 0.0
    for e in range(w.effects):
        if w.places[e, DRY]:
            total += _ask(w, BREAKAWAY, e, y)
    return total


@compiled
def _margins(w: Work, t: float, y: Array) -> None:
    """Write how far each event is: reversal or release first, then the switches; below zero it has passed."""
    m, g, out = w.m, w.margin, w.out
    g[0] = 1.0
    if m[HELD] > 0.0:
        net = _evaluate(w, t, y, w.k[_STAGES])
        sign = m[SIGN]
        m[SIGN] = -1.0 if net < 0.0 else 1.0
        g[0] = _hold(w, y) - abs(net)
        m[SIGN] = sign
    elif w.reverses:
        g[0] = m[SIGN] * y[1]
    m[TIME] = t
    for e in range(w.effects):
        if w.places[e, N_SWITCHES]:
            _ask(w, SWITCHES, e, y)
            for j in range(w.places[e, N_SWITCHES]):
                side = w.places[e, SIDES] + j
                g[1 + side] = w.sides[side] * out[j]


@compiled
def _choose_sides(w: Work, t: float, y: Array) -> None:
    w.m[TIME] = t
    for e in range(w.effects):
        if w.places[e, N_SWITCHES]:
            _ask(w, SWITCHES, e, y)
            for j in range(w.places[e, N_SWITCHES]):
                w.sides[w.places[e, SIDES] + j] = -1.0 if w.out[j] < 0.0 else 1.0


@compiled
def _choose_direction(w: Work, t: float) -> None:
    """Direction of motion, or held, of a cart that moves, or whose velocity has just become zero."""
    m, y = w.m, w.y
    w.stale = max(w.stale, 1)
    m[HELD] = 0.0
    m[SIGN] = -1.0 if y[1] < 0.0 else 1.0
    if not w.reverses or abs(y[1]) > (w.still if w.dry else 0.0):
        return
    y[1] = 0.0
    net = _evaluate(w, t, y, w.k[_STAGES])
    m[SIGN] = -1.0 if net < 0.0 else 1.0
    if w.dry and abs(net) <= _hold(w, y):
        m[HELD] = 1.0
        w.net = net


@compiled
def _locate(w: Work, t: float, h: float, which: int, before: float, after: float) -> tuple[float, float]:
    """Share of a step at which an event happens, by bracketing secants, and the error of the step to it.

    `w.stage` is the state there.

    Where the same end stays twice, its margin is made smaller as Anderson and Bjorck do (BIT 13, 1973), or it would
    stay for long.
    """
    low, high, there, moved, error = 0.0, 1.0, 1.0, 0, 0.0
    for _ in range(_LOCATE):
        there = 0.5 * (low + high) if before <= 0.0 else low + (high - low) * before / (before - after)
        error = _step(w, t, there * h)
        _margins(w, t + there * h, w.stage)
        g = w.margin[which]
        if abs(g) <= _CROSSED or high - low < _SHORTEST * _SHORTEST:
            break
        if g < 0.0:
            if moved < 0:
                before *= 1.0 - g / after if g > after else 0.5
            high, after, moved = there, g, -1
        else:
            if moved > 0:
                after *= 1.0 - g / before if g < before else 0.5
            low, before, moved = there, g, 1
    return there, error


@compiled
def _first_event(w: Work, t: float, h: float) -> tuple[int, float, float]:
    """Event that happens first within a step, -1 for none, the share of the step, and the error of the step to it.

    `w.stage` is the state there.
    """
    g = w.margin
    _margins(w, t + h, w.stage)
    passed = False
    for j in range(1 + w.switches):
        passed = passed or g[j] < -_CROSSED
    if not passed:
        return -1, 1.0, 0.0
    ends, begins = w.ends, w.begins
    _copy(g, ends, 1 + w.switches)
    _margins(w, t, w.y)
    _copy(g, begins, 1 + w.switches)
    first, share, error, last = -1, 2.0, 0.0, -1
    for j in range(1 + w.switches):
        if ends[j] < -_CROSSED:
            there, missed = _locate(w, t, h, j, max(begins[j], 0.0), ends[j])
            last = j
            if there < share:
                first, share, error = j, there, missed
    if first >= 0 and last != first:  # the state is where another one happens
        error = _step(w, t, share * h)
    return first, share, error


@inlined
def _turning(rise: float, begin: float, end: float) -> tuple[float, float]:
    """Share of a step at which a cubic turns back, 1 where only at its end, and by how much it has changed there.

    It rises by `rise` in the step; `begin` and `end` are its slopes there times the step's length, of opposite signs.
    """
    bend, twist = 3.0 * rise - 2.0 * begin - end, begin + end - 2.0 * rise
    root = np.sqrt(max(bend * bend - 3.0 * twist * begin, 0.0))
    share = begin / (-bend + (root if begin > 0.0 else -root))
    return (share if 0.0 < share < _AT_END else 1.0), share * (begin + share * (bend + share * twist))


@compiled
def _turned_beyond(w: Work, t: float, h: float) -> float:
    """Share of a step at which the cart turns back beyond a switch that both ends lie before; 1 where it does not.

    Between two turns the position is monotonic: no other switch of it can be passed twice within a step. The turn is
    that of the cubic through both ends; where it comes as near as that may be off, it is looked at, too.
    """
    y, z, turn = w.y, w.stage, w.turn
    if w.switches == 0 or not y[1] * z[1] < 0.0:
        return 1.0
    share, moved = _turning(z[0] - y[0], h * y[1], h * z[1])
    if share == 1.0:
        return 1.0
    for j in range(w.states):
        turn[j] = y[j] + share * (z[j] - y[j])
    turn[0], turn[1] = y[0] + moved, 0.0
    _margins(w, t + h, z)
    _copy(w.margin, w.ends, 1 + w.switches)
    _margins(w, t + share * h, turn)
    near = _OFF * abs(h * (z[1] - y[1]))
    for j in range(1, 1 + w.switches):
        if w.margin[j] < near and w.ends[j] >= -_CROSSED:
            return share
    return 1.0


@compiled
def _turned_twice(w: Work, h: float) -> float:
    """Share of a step at which a cart moves back that moves forward at both ends; 1 where it does not.

    Friction would change its sign there. The velocity is that of the cubic through both ends, as near as that may be.
    """
    sign = w.m[SIGN]
    before, after = sign * w.y[1], sign * w.stage[1]
    down, up = sign * h * w.k[0, 1], sign * h * w.k[_STAGES - 1, 1]
    if not (down < 0.0 < up) or before < 0.0 or after < 0.0:
        return 1.0
    share, gained = _turning(after - before, down, up)
    return share if before + gained < _OFF * (up - down) else 1.0


@compiled
def _passed_twice(w: Work, t: float, h: float) -> float:
    """Share of a step at which an event has happened that is over at its end; 1 where none has."""
    share = _turned_twice(w, h) if w.reverses and w.m[HELD] == 0.0 else 1.0
    return share if share < 1.0 else _turned_beyond(w, t, h)


@compiled
def _happen(w: Work, which: int, t: float) -> None:
    """Change the law as an event says."""
    if which > 0:
        w.sides[which - 1] = -w.sides[which - 1]
        w.stale = 2
    elif w.m[HELD] > 0.0:
        net = _evaluate(w, t, w.y, w.k[_STAGES])
        w.m[SIGN] = -1.0 if net < 0.0 else 1.0
        w.m[HELD] = 0.0
        w.stale = max(w.stale, 1)
    else:
        w.y[1] = 0.0
        _choose_direction(w, t)


@compiled
def _unwatched(w: Work, t: float, until: float, longest: float) -> float:
    """Time for which a held cart need not be looked at, s; infinite where nothing changes.

    What friction holds is resolved by the fastest change of the force that was met so far.
    """
    if w.rated:
        return longest
    before, near = w.net, longest / _LOOKS
    w.net = _evaluate(w, until, w.y, w.k[_STAGES])
    soon = _evaluate(w, t + near, w.y, w.k[_STAGES])
    if w.net == before and soon == before:
        return np.inf
    w.rate = max(w.rate, abs(soon - _evaluate(w, t, w.y, w.k[_STAGES])) / near)
    return max(near / _LOOKS, min(longest, _hold(w, w.y) / (_RESOLVED * w.rate)))


@compiled
def _times(left: Array, right: Array, out: Array, factor: float, size: int) -> None:
    """Write a product of two square matrices, times a factor."""
    for i in range(size):
        for j in range(size):
            total = 0.0
            for r in range(size):
                total += left[i, r] * right[r, j]
            out[i, j] = factor * total


@compiled
def _exponential(w: Work, h: float) -> None:
    """Write exp(A h) and the integral of exp(A s) over s from 0 to h, by a scaled and squared series."""
    d, a, phi, psi, term, new = w.states, w.matrix, w.phi, w.psi, w.term, w.new
    norm = 0.0
    for i in range(d):
        row = 0.0
        for j in range(d):
            row += abs(a[i, j]) * h
        norm = max(norm, row)
    halvings = 0
    while norm > 0.5 and halvings < 60:
        norm *= 0.5
        halvings += 1
    s = h / 2.0**halvings
    for i in range(d):
        for j in range(d):
            term[i, j] = 1.0 if i == j else 0.0
            phi[i, j], psi[i, j] = term[i, j], s * term[i, j]
    for n in range(1, _TERMS):
        _times(term, a, new, s / n, d)
        for i in range(d):
            for j in range(d):
                term[i, j] = new[i, j]
                phi[i, j] += term[i, j]
                psi[i, j] += term[i, j] * s / (n + 1)
    for _ in range(halvings):
        _times(phi, psi, new, 1.0, d)
        _times(phi, phi, term, 1.0, d)
        for i in range(d):
            for j in range(d):
                psi[i, j] += new[i, j]
                phi[i, j] = term[i, j]
    w.leap = h


@compiled
def _affine_law(w: Work, t: float) -> None:
    """Write the constant of an affine law, and its matrix, column by column, where it has changed."""
    _clear(w.stage, w.states)
    _evaluate(w, t, w.stage, w.constant)
    if w.stale == 2:
        for j in range(w.states):
            w.stage[j] = 1.0
            _evaluate(w, t, w.stage, w.k[_STAGES])
            for i in range(w.states):
                w.matrix[i, j] = w.k[_STAGES, i] - w.constant[i]
            w.stage[j] = 0.0
        w.leap = 0.0
    w.stale = 0


@compiled
def _leaps(w: Work, t: float, until: float) -> bool:
    """Go to `until` in one exact step, where the law is affine and nothing happens on the way."""
    length = until - t
    if w.stale:
        _affine_law(w, t)
    if w.leaps == 1 and -w.matrix[1, 0] * length * length > _SWING:
        return False
    if abs(w.leap - length) > _SAME * length:
        _exponential(w, length)
    for i in range(w.states):
        total = 0.0
        for j in range(w.states):
            total += w.phi[i, j] * w.y[j] + w.psi[i, j] * w.constant[j]
        w.stage[i] = total
    if w.leaps == 1:
        _margins(w, until, w.stage)
        for j in range(1 + w.switches):
            if w.margin[j] < -_CROSSED:
                return False
        if _turned_beyond(w, t, length) < 1.0:
            return False
    _copy(w.stage, w.y, w.states)
    return True


@inlined
def _stretch(error: float) -> float:
    """Times its length that the step after one of this error may have."""
    if error < 1e-4:  # the longest: no root is to be taken
        return 5.0
    return max(0.1, min(5.0, 0.9 * error ** (-1.0 / _ORDER)))


@compiled
def _advance(w: Work, t: float, until: float, h: float, fresh: bool) -> tuple[float, bool]:
    """Follow the plant to `until`, its input one polynomial; return the next step's length, if `w.k[0]` is known."""
    shortest, longest = _SHORTEST * (until - t), (until - t) / _LOOKS
    events = 0
    decay = 0.5 * w.q[Q_DAMPING] / w.q[Q_MASS]
    swing = (until - t) * np.sqrt(max(abs(w.q[Q_STIFFNESS]) / w.q[Q_MASS] - decay * decay, 0.0))
    w.credit += w.patience * (1.0 + min(swing, _UNSEEN))
    while t < until:
        w.credit -= 1.0
        w.taken += 1
        if w.credit < 0.0:
            w.y[0] = np.inf
            return h, fresh
        left = until - t
        held = w.m[HELD] > 0.0
        unwatched = _unwatched(w, t, until, longest) + shortest if held else h
        if unwatched == np.inf:
            return h, False
        length = min(h, unwatched)
        length = min(length, max(_kink(w, t, length), shortest))
        last = length >= left
        if last:
            length = left
        elif length > 0.5 * left:
            length = 0.5 * left
        if not fresh:
            _evaluate(w, t, w.y, w.k[0])
            fresh = True
        error = _step(w, t, length)
        again = _stretch(error) if error > 1.0 else _passed_twice(w, t, length)
        if again < 1.0 and length > shortest:
            h = length * again
            continue
        which, share, missed = -1, 1.0, 0.0
        if events < _EVENTS and (w.reverses or w.switches > 0):
            which, share, missed = _first_event(w, t, length)
        if which >= 0:
            if missed > 1.0 and share * length > shortest:  # what the law does next to an event can be narrow
                h = share * length * _stretch(missed)
                continue
            _copy(w.stage, w.y, w.states)
            t += share * length
            _happen(w, which, t)
            events += 1
            fresh = False
            continue
        _copy(w.stage, w.y, w.states)
        t = until if last else t + length
        _copy(w.k[_STAGES - 1], w.k[0], w.states)
        h = max(h if last else 0.0, length * _stretch(error))
        if not abs(w.y[0]) < w.far:
            return h, False
    return h, fresh


@compiled
def _stand(w: Work, x: float) -> None:
    """The state of a plant that has long rested at x."""
    _clear(w.y, w.states)
    w.y[0] = x
    w.m[VOLTS] = w.u[1]
    for e in range(w.effects):
        if w.places[e, N_EXTRA] + w.places[e, N_MEMORY] > 0:
            _ask(w, AT_REST, e, w.y)
            for j in range(w.places[e, N_EXTRA] + w.places[e, N_MEMORY]):
                w.y[w.places[e, OWN] + j] = w.out[j]
        if w.places[e, DRIVES]:
            _ask(w, EVALUATE, e, w.y)
            w.m[VOLTS] = w.out[DRIVEN]


@compiled
def _standing_force(w: Work, t: float, x: float) -> float:
    _stand(w, x)
    _choose_sides(w, t, w.y)
    return _evaluate(w, t, w.y, w.k[0])


@compiled
def _begin(w: Work, t: float, start: Array, moving: bool, scale: float) -> None:
    """Put the plant where its record begins: at rest under the input before it, unless it is moving."""
    w.m[SIGN], w.m[HELD] = 1.0, 0.0
    x = 0.0
    if w.u[1] != 0.0 and not moving:
        step = 1e-6 * scale
        for _ in range(12):
            f = _standing_force(w, t, x)
            slope = (_standing_force(w, t, x + step) - f) / step
            x -= f / min(slope, -0.05 * w.q[Q_STIFFNESS])  # in a gap there is no slope: leap out of it
    _stand(w, x + start[0])
    w.y[1] = start[1]
    if moving:
        for j in range(2, w.states):
            w.y[j] += start[j]
    _choose_sides(w, t, w.y)
    _choose_direction(w, t)


@compiled
def _seen(w: Work, t: float) -> float:
    """The reading: position and what the effects add to it, m."""
    x = w.y[0]
    w.m[TIME] = t
    for e in range(w.effects):
        if w.places[e, READS]:
            x += _ask(w, READING, e, w.y)
    return x


@compiled
def _delay(w: Work) -> float:
    total = 0.0
    for e in range(w.effects):
        if w.places[e, DELAYS]:
            total += max(0.0, _ask(w, DELAY, e, w.y))
    return total


@compiled
def _change_input(w: Work, t: float, since: float, coefficients: Array, piece: int) -> None:
    """Let another piece of the input act from now on."""
    w.u[0] = since
    for r in range(coefficients.shape[1]):
        w.u[1 + r] = coefficients[piece, r]
    w.stale = max(w.stale, 1)
    if w.m[HELD] > 0.0 or w.y[1] == 0.0:
        _choose_direction(w, t)


@compiled
def _next_change(coefficients: Array, piece: int, level: float) -> int:
    """First piece of the input, from `piece` on, that does not just hold a level; their number where none does."""
    while piece < len(coefficients) and coefficients.shape[1] == 1 and coefficients[piece, 0] == level:
        piece += 1
    return piece


@compiled
def _begins(time: Array, delay: float, piece: int) -> float:
    """Time at which a piece of the input begins to act, s; infinite for one after the last."""
    return time[piece] + delay if piece < time.size else np.inf


@compiled
def _follow_record(w: Work, time: Array, coefficients: Array, delay: float, reading: Array, states: Array) -> None:
    """Follow one record from where it begins, sample by sample; what comes after a runaway is not a number."""
    t, fresh, coming = time[0], False, _next_change(coefficients, 0, w.u[1])
    begins = _begins(time, delay, coming)
    h = time[1] - t if time.size > 1 else 1.0
    for i in range(time.size):
        while t < time[i]:
            latest = -1
            while not begins > t:
                latest, coming = coming, _next_change(coefficients, coming + 1, coefficients[coming, 0])
                begins = _begins(time, delay, coming)
            if latest >= 0:
                _change_input(w, t, time[latest] + delay, coefficients, latest)
                fresh = False
            until = min(time[i], begins)
            if w.leaps and w.m[HELD] == 0.0 and _leaps(w, t, until):
                fresh = False
            else:
                h, fresh = _advance(w, t, until, h, fresh)
            t = until
        if not abs(w.y[0]) < w.far:
            reading[i:], states[:, i:] = np.nan, np.nan
            return
        reading[i] = _seen(w, t)
        for r in range(states.shape[0]):
            states[r, i] = w.y[r]


@compiled
def simulate(
    work: Work,
    values: Array,
    start: Array,
    run: Array,
    bounds: Array,
    time: Array,
    coefficients: Array,
    before: Array,
    moving: Array,
    tolerance: float,
    scale: float,
    leaps: int,
    patience: int,
    offset: Array,
    reading: Array,
    states: Array,
) -> None:
    """Simulate replicas, one plant on one record each.

    Parameters
    ----------
    work : array of `WORK`, shape (1,)
        The structure of the plant: its effects' laws and places, and what they do. An array: numba takes ten times as
        long to see what a record is.
    values : array, shape (L, Q)
        Values of each replica's plant.
    start : array, shape (L, states)
        Displacement [m], velocity [m/s] and own states at the first sample, see `stepid.model.RunState`.
    run : array of int, shape (L,)
        Record of each replica.
    bounds : array of int, shape (R + 1,)
        Where each record's samples begin and end.
    time : array, shape (S,)
        s, of each sample.
    coefficients : array, shape (S, 1), (S, 2) or (S, 4)
        Polynomial of the input [V] from each sample to the next: held, straight or cubic.
    before : array, shape (R,)
        V, input before each record.
    moving : array of bool, shape (R,)
        Whether each record starts in motion.
    tolerance : float
        m, error of one step in position.
    scale : float
        m, typical displacement.
    leaps : int
        Whether to take exact steps: 2 where the plant is linear and the input held, 1 where the law is affine between
        its events, 0 where neither.
    patience : int
        Steps a sample, on the way so far, and as many for each radian of the plant's swing, beyond which it is given up
        like a runaway: something in it is faster than the samples can show.
    offset : array of int, shape (L,)
        Where each replica's samples begin in `reading` and `states`.
    reading : array, shape (N,)
        m, written.
    states : array, shape (d, N)
        The first d states, written.
    """
    w = work[0]
    q, allowed = w.q, w.allowed
    for replica in range(values.shape[0]):
        _copy(values[replica], q, values.shape[1])
        w.ease = 1.0 / q[Q_MASS]
        w.m[MASS], w.m[STIFFNESS], w.m[DAMPING] = q[Q_MASS], q[Q_STIFFNESS], q[Q_DAMPING]
        for j in range(w.states):
            allowed[j] = -tolerance / scale
        rate = np.sqrt(abs(q[Q_STIFFNESS]) / q[Q_MASS])
        allowed[0], allowed[1], w.still = tolerance, tolerance * rate, _STILL * scale * rate
        for e in range(w.effects):
            if w.places[e, RELAXES]:
                for j in range(w.places[e, N_EXTRA]):
                    allowed[w.places[e, OWN] + j] = 0.0
        r = run[replica]
        first, at, n = bounds[r], offset[replica], bounds[r + 1] - bounds[r]
        _clear(w.u, 5)
        w.u[1], w.far, w.leaps, w.stale, w.patience = before[r], _FAR * scale, leaps, 2, patience
        w.credit, w.rate = _CREDIT, 0.0
        _begin(w, time[first], start[replica], moving[r], scale)
        _follow_record(
            w, time[first : first + n], coefficients[first : first + n], _delay(w), reading[at : at + n],
            states[:, at : at + n],
        )  # fmt: skip
