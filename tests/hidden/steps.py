"""One run in micro-steps, compiled: classical Runge-Kutta, and a bracketed secant where a mode ends inside a step."""

from __future__ import annotations

import numpy as np

from .compiled import compiled
from .equations import (
    CURVE,
    DRIVE,
    HELD,
    SIDE,
    SIGN,
    SINCE,
    SIZE,
    TOUCH,
    XB,
    ZB,
    Cart,
    T,
    V,
    X,
    bristle,
    choose_sign,
    guards,
    lagged,
    push,
    rates,
)

EDGE = 1e-13  # m past the edge of the play or the stop, where a mode begins
CLOSE = 1e-13  # of a guard, and of a step: near enough to an event
SHARP = 32  # parts of a micro-step in which a cart under a power law may stop
FADED, UNRESOLVED = 40.0, 6.0  # lags after which a change of the drive is over; lags to a micro-step that is too long
EVENTS = 12  # in a micro-step; more is chatter
TRIAL, END, FIRST = 0, 1, 2  # rows of the scratch: a state to try, the state after the step, the four slopes


@compiled
def _stepped(cart: Cart, now: np.ndarray, y: np.ndarray, h: float, scratch: np.ndarray) -> float:
    """Drive after h; the motion is left in the scratch. Modes are frozen."""
    t, half, full = now[T], lagged(cart, now, h / 2), lagged(cart, now, h)
    trial, end = scratch[TRIAL], scratch[END]
    one, two, three, four = scratch[FIRST], scratch[FIRST + 1], scratch[FIRST + 2], scratch[FIRST + 3]
    rates(cart, now, y, t, lagged(cart, now, 0.0), one)
    for i in range(SIZE):
        trial[i] = y[i] + h / 2 * one[i]
    rates(cart, now, trial, t + h / 2, half, two)
    for i in range(SIZE):
        trial[i] = y[i] + h / 2 * two[i]
    rates(cart, now, trial, t + h / 2, half, three)
    for i in range(SIZE):
        trial[i] = y[i] + h * three[i]
    rates(cart, now, trial, t + h, full, four)
    for i in range(SIZE):
        end[i] = y[i] + h / 6 * (one[i] + 2 * two[i] + 2 * three[i] + four[i])
    return full


@compiled
def _accept(now: np.ndarray, y: np.ndarray, h: float, drive: float, scratch: np.ndarray) -> None:
    y[:] = scratch[END]
    now[T] += h
    now[DRIVE] = drive


@compiled
def _switch(cart: Cart, now: np.ndarray, y: np.ndarray, which: int) -> None:
    """Begin the mode that follows one of the four guards."""
    x = y[X]
    if which == 0:
        z = bristle(cart, now, x)
        now[XB], now[ZB] = x, z
        y[V] = 0.0
        choose_sign(cart, now, y)
    elif which == 1:
        now[SIGN] = 1.0 if push(cart, now, y, now[T], now[DRIVE]) > 0 else -1.0
    elif which == 2:
        now[SIDE] = np.sign(x) if now[SIDE] == 0 else 0.0
        # just past the edge: on it, or before it by rounding, the new mode would end where it begins
        y[X] = np.sign(x) * (cart.gap + (EDGE if now[SIDE] != 0 else -EDGE))
    else:
        now[TOUCH] = 1.0 - now[TOUCH]
        y[X] = cart.stop + np.sign(cart.stop) * (EDGE if now[TOUCH] != 0 else -EDGE)


@compiled
def _to_event(cart: Cart, now: np.ndarray, y: np.ndarray, left: float, scratch: np.ndarray, guard: np.ndarray) -> float:
    """Move to the next event or to the end of the step; return the time still left."""
    drive = _stepped(cart, now, y, left, scratch)
    g_high = guards(cart, now, scratch[END], now[T] + left, drive, guard)
    if not g_high < 0:
        _accept(now, y, left, drive, scratch)
        return 0.0
    low, high, guess = 0.0, left, left
    g_low = max(guards(cart, now, y, now[T], now[DRIVE], guard), 0.0)
    for _ in range(40):
        guess = low + (high - low) * g_low / (g_low - g_high)
        if not np.isfinite(guess):
            guess = low
        drive = _stepped(cart, now, y, guess, scratch)
        g = guards(cart, now, scratch[END], now[T] + guess, drive, guard)
        if g < 0:
            high, g_high, g_low = guess, g, g_low / 2
        else:
            low, g_low, g_high = guess, g, g_high / 2
        if abs(g) <= CLOSE or high - low <= CLOSE * left:
            break
    which = 0
    for i in range(1, guard.size):
        if abs(guard[i]) < abs(guard[which]):
            which = i
    _accept(now, y, guess, drive, scratch)
    _switch(cart, now, y, which)
    return left - guess


@compiled
def _micro_step(cart: Cart, now: np.ndarray, y: np.ndarray, h: float, scratch: np.ndarray, guard: np.ndarray) -> None:
    """One micro-step, with every change of mode inside it."""
    drive = _stepped(cart, now, y, h, scratch)
    watched = cart.signed or cart.gap > 0 or cart.stop != 0
    if not (watched and guards(cart, now, scratch[END], now[T] + h, drive, guard) < 0):
        _accept(now, y, h, drive, scratch)
        return
    left = h
    for _ in range(EVENTS):
        left = _to_event(cart, now, y, left, scratch, guard)
        if left <= 0:
            return
    drive = _stepped(cart, now, y, left, scratch)  # chatter: finish the micro-step in the present mode
    _accept(now, y, left, drive, scratch)


@compiled
def _parts(cart: Cart, now: np.ndarray, y: np.ndarray, h: float, scratch: np.ndarray) -> int:
    """More than one where a power law bends within h of here: so slow that the cart may stop."""
    if cart.cp <= 0 or cart.exponent >= 2:
        return 1
    rates(cart, now, y, now[T], lagged(cart, now, 0.0), scratch[FIRST])
    return SHARP if abs(y[V]) < 4 * h * abs(scratch[FIRST, V]) else 1


@compiled
def follow(
    cart: Cart,
    now: np.ndarray,
    y: np.ndarray,
    begins: np.ndarray,
    curves: np.ndarray,
    held: np.ndarray,
    period: float,
    steps: int,
) -> np.ndarray:
    """Position at each sample. `held` has four rows: a force, and factors on stiffness, mass and damping.

    The drive before its lag is `curves[j]` from `begins[j]` on; a sample is split where one begins inside it.
    """
    scratch, guard = np.zeros((FIRST + 4, SIZE)), np.zeros(4)
    n, at = held.shape[1], 0
    out = np.full(n, np.nan)
    out[0] = y[X]
    for i in range(n - 1):
        now[HELD : HELD + 4] = held[:, i]
        now[T], end = i * period, (i + 1) * period
        begin = now[T]
        while begin < end:
            while at + 1 < begins.size and begins[at + 1] <= begin + 1e-12:
                at += 1
            upto = min(end, begins[at + 1]) if at + 1 < begins.size else end
            # a lag that the micro-steps do not resolve fades in steps of its own
            if begins[at] > begin - 1e-12 and 0 < cart.tau < (upto - begin) / max(FADED, steps / UNRESOLVED):
                upto = begin + FADED * cart.tau
            now[CURVE : CURVE + 4] = curves[at]
            now[SINCE] = max(begins[at], -1.0)
            now[T] = begin
            now[DRIVE] = lagged(cart, now, 0.0)
            if cart.signed and now[SIGN] == 0:
                choose_sign(cart, now, y)
            h = (upto - begin) / steps
            for _ in range(steps):
                parts = _parts(cart, now, y, h, scratch)
                for _ in range(parts):
                    _micro_step(cart, now, y, h / parts, scratch, guard)
            begin = upto
        if not np.isfinite(y[X]):  # ran away
            break
        out[i + 1] = y[X]
    return out
