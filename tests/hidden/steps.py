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
    TOUCH,
    XB,
    ZB,
    Cart,
    Motion,
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
MOST = 100  # tries to find an event
EVENTS = 12  # in a micro-step; more is chatter


@compiled
def _along(y: Motion, h: float, k: Motion) -> Motion:
    return (
        y[0] + h * k[0],
        y[1] + h * k[1],
        y[2] + h * k[2],
        y[3] + h * k[3],
        y[4] + h * k[4],
        y[5] + h * k[5],
        y[6] + h * k[6],
    )


@compiled
def _stepped(cart: Cart, now: np.ndarray, y: Motion, h: float) -> tuple[Motion, float]:
    """Motion and drive after h, modes frozen."""
    t, half, full = now[T], lagged(cart, now, h / 2), lagged(cart, now, h)
    slope = rates(cart, now, y, t, lagged(cart, now, 0.0))
    end, trial = _along(y, h / 6, slope), _along(y, h / 2, slope)
    slope = rates(cart, now, trial, t + h / 2, half)
    end, trial = _along(end, h / 3, slope), _along(y, h / 2, slope)
    slope = rates(cart, now, trial, t + h / 2, half)
    end, trial = _along(end, h / 3, slope), _along(y, h, slope)
    return _along(end, h / 6, rates(cart, now, trial, t + h, full)), full


@compiled
def _accept(now: np.ndarray, h: float, drive: float) -> None:
    now[T] += h
    now[DRIVE] = drive


@compiled
def _switch(cart: Cart, now: np.ndarray, y: Motion, which: int) -> Motion:
    """Begin the mode that follows one of the four guards."""
    x, v = y[X], y[V]
    if which == 0:
        z = bristle(cart, now, x)
        now[XB], now[ZB] = x, z
        v = 0.0
    elif which == 1:
        now[SIGN] = 1.0 if push(cart, now, y, now[T], now[DRIVE]) > 0 else -1.0
    elif which == 2:
        now[SIDE] = np.sign(x) if now[SIDE] == 0 else 0.0
        # just past the edge: on it, or before it by rounding, the new mode would end where it begins
        x = np.sign(x) * (cart.gap + (EDGE if now[SIDE] != 0 else -EDGE))
    else:
        now[TOUCH] = 1.0 - now[TOUCH]
        x = cart.stop + np.sign(cart.stop) * (EDGE if now[TOUCH] != 0 else -EDGE)
    y = (x, v, y[2], y[3], y[4], y[5], y[6])
    if which == 0:
        choose_sign(cart, now, y)
    return y


@compiled
def _to_event(cart: Cart, now: np.ndarray, y: Motion, left: float) -> tuple[Motion, float]:
    """The motion at the next event or at the end of the step, and the time still left."""
    end, drive = _stepped(cart, now, y, left)
    g_high = min(guards(cart, now, end, now[T] + left, drive))
    if not g_high < 0:
        _accept(now, left, drive)
        return end, 0.0
    low, high = 0.0, left
    g_low = max(min(guards(cart, now, y, now[T], now[DRIVE])), 0.0)
    for i in range(MOST):  # every other one in the middle: the nearest mode at one end need not be the one that ends
        guess = low + (high - low) * (g_low / (g_low - g_high) if g_low > 0 and i % 2 == 0 else 0.5)
        end, drive = _stepped(cart, now, y, guess)
        g = min(guards(cart, now, end, now[T] + guess, drive))
        if g < 0:
            high, g_high, g_low = guess, g, g_low / 2
        else:  # however small: a mode that has just begun is no event
            low, g_low, g_high = guess, g, g_high / 2
        if -CLOSE <= g < 0 or high - low <= CLOSE * left:
            break
    end, drive = _stepped(cart, now, y, high)
    turn, slip, play, stop = guards(cart, now, end, now[T] + high, drive)
    least = min(turn, slip, play, stop)
    which = 0 if turn == least else 1 if slip == least else 2 if play == least else 3
    _accept(now, high, drive)
    return _switch(cart, now, end, which), left - high


@compiled
def _micro_step(cart: Cart, now: np.ndarray, y: Motion, h: float) -> Motion:
    """One micro-step, with every change of mode inside it."""
    end, drive = _stepped(cart, now, y, h)
    watched = cart.signed or cart.gap > 0 or cart.stop != 0
    if not (watched and min(guards(cart, now, end, now[T] + h, drive)) < 0):
        _accept(now, h, drive)
        return end
    left = h
    for _ in range(EVENTS):
        y, left = _to_event(cart, now, y, left)
        if left <= 0:
            return y
    y, drive = _stepped(cart, now, y, left)  # chatter: finish the micro-step in the present mode
    _accept(now, left, drive)
    return y


@compiled
def _parts(cart: Cart, now: np.ndarray, y: Motion, h: float) -> int:
    """More than one where a power law bends within h of here: so slow that the cart may stop."""
    if cart.cp <= 0 or cart.exponent >= 2:
        return 1
    pull = rates(cart, now, y, now[T], lagged(cart, now, 0.0))[V]
    return SHARP if abs(y[V]) < 4 * h * abs(pull) else 1


@compiled
def follow(
    cart: Cart,
    now: np.ndarray,
    y: Motion,
    begins: np.ndarray,
    curves: np.ndarray,
    held: np.ndarray,
    period: float,
    steps: int,
) -> np.ndarray:
    """Position at each sample. `held` has four rows: a force, and factors on stiffness, mass and damping.

    The drive before its lag is `curves[j]` from `begins[j]` on; a sample is split where one begins inside it.
    """
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
                parts = _parts(cart, now, y, h)
                for _ in range(parts):
                    y = _micro_step(cart, now, y, h / parts)
            begin = upto
        if not np.isfinite(y[X]):  # ran away
            break
        out[i + 1] = y[X]
    return out
