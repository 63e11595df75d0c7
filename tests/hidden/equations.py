"""The equations of one run, compiled: what pushes the cart, what holds it, and when a mode ends.

`y` is the motion: x, v, a second mass, the dashpot's joint, two states of a law. `now` is what else changes: drive,
modes, what is held over a sample, and the drive's target as a cubic in the time since it began.
"""

from __future__ import annotations

import math
from typing import NamedTuple, cast, get_type_hints

import numpy as np

from .compiled import compiled
from .laws import PARAMETERS, law_force, law_rates
from .plant import SLOWEST, Run

X, V, X2, V2, W, OWN = range(6)  # W: the joint between spring and dashpot of the viscoelastic branch
Motion = tuple[float, float, float, float, float, float, float]
T, DRIVE, SIGN, SIDE, TOUCH, XB, ZB = range(7)  # SIGN of the motion (0: stuck), SIDE of the play (0: inside)
HELD, SCALE_K, SCALE_M, SCALE_C = range(7, 11)  # held over a sample
CURVE, SINCE, WIDTH = 11, 15, 16  # the bristle's branch began at XB, ZB; the drive's target at SINCE
MARGIN = 1e-12  # N beyond the band of friction


class Cart(NamedTuple):
    """What does not change during a run; what it lacks is zero (or one, where that is divided by)."""

    m: float
    k: float
    c: float
    slope: float
    c2: float
    cp: float
    exponent: float
    k3: float
    k2: float
    bend: float
    gap: float
    stop: float
    kstop: float
    kv: float
    cv: float
    m2: float
    kc: float
    cc: float
    tau: float
    amp: float
    omega: float
    phase: float
    cog: float
    wave: float
    angle: float
    bristles: float
    distance: float
    forward: float
    backward: float
    extra: float
    vs: float
    patch: float
    center: float
    width: float
    signed: bool
    coupled: bool
    law: int
    values: np.ndarray


_FORMATS = {float: "f8", int: "i8", bool: "?", np.ndarray: f"{PARAMETERS}f8"}
RECORD = np.dtype([(name, _FORMATS[kind]) for name, kind in get_type_hints(Cart).items()], align=True)


def cart_of(run: Run) -> Cart:
    """A record that is read like a `Cart`: machine code passes it on by its address."""
    g = run.get
    forward, backward, extra, vs = run.levels
    patch, center, width = run.sticky or (0.0, 0.0, 1.0)
    bristles = g("presliding_hysteresis", "level")
    cart = Cart(
        m=float(run.mass),
        k=float(run.stiffness),
        c=float(run.damping),
        slope=g("position_dependent_damping", "slope"),
        c2=g("quadratic_damping", "coefficient"),
        cp=g("power_damping", "coefficient"),
        exponent=g("power_damping", "exponent", 1.0),
        k3=g("cubic_stiffness", "coefficient"),
        k2=g("quadratic_stiffness", "coefficient"),
        bend=g("sine_stiffness", "curvature"),
        gap=g("free_play", "gap"),
        stop=g("end_stop", "position"),
        kstop=g("end_stop", "stiffness"),
        kv=g("viscoelastic_spring", "stiffness"),
        cv=g("viscoelastic_spring", "damping", 1.0),
        m2=g("flexible_coupling", "mass", 1.0),
        kc=g("flexible_coupling", "stiffness"),
        cc=g("flexible_coupling", "damping"),
        tau=run.lag,
        amp=g("periodic_disturbance", "amplitude"),
        omega=2 * math.pi * g("periodic_disturbance", "frequency"),
        phase=float(run.phase),
        cog=g("cogging", "amplitude"),
        wave=2 * math.pi / g("cogging", "pitch", 1.0),
        angle=g("cogging", "phase"),
        bristles=bristles,
        distance=g("presliding_hysteresis", "distance", 1.0),
        forward=forward,
        backward=backward,
        extra=extra,
        vs=vs,
        patch=float(patch),
        center=float(center),
        width=float(width),
        signed=max(forward, backward, extra, bristles, patch) > 0,
        coupled="flexible_coupling" in run.effects,
        law=-1 if run.law is None else run.law.kind,
        values=np.zeros(PARAMETERS) if run.law is None else run.law.values,
    )
    return cast("Cart", np.rec.fromrecords([tuple(cart)], dtype=RECORD)[0])


def begin(run: Run, cart: Cart) -> tuple[Motion, np.ndarray]:
    """Motion and modes at sample 0."""
    x, v = run.start, float(run.velocity)
    now = np.zeros(WIDTH)
    now[DRIVE] = now[CURVE] = run.drive[-1]
    now[SIGN] = np.sign(v) if cart.signed else 1.0
    now[SIDE] = np.sign(x) if 0 < cart.gap < abs(x) else 0.0
    now[TOUCH] = float(cart.stop != 0 and (x - cart.stop) * cart.stop > 0)
    now[XB] = x
    now[SCALE_K : SCALE_C + 1] = 1.0
    return (x, v, x, v, x, 0.0, 0.0), now


@compiled
def lagged(cart: Cart, now: np.ndarray, h: float) -> float:
    """Drive after h: a lag follows a polynomial by another one, and what it is off from that fades."""
    tau, s = cart.tau, now[T] - now[SINCE]
    a, b, c, d = now[CURVE], now[CURVE + 1], now[CURVE + 2], now[CURVE + 3]
    if tau <= 0:
        s += h
        return float(((d * s + c) * s + b) * s + a)
    b, c = b - 2 * tau * (c - 3 * tau * d), c - 3 * tau * d
    a -= tau * b
    off = now[DRIVE] - (((d * s + c) * s + b) * s + a)
    s += h
    return float(((d * s + c) * s + b) * s + a + off * math.exp(-h / tau))


@compiled
def bristle(cart: Cart, now: np.ndarray, x: float) -> float:
    """z along the branch that began at (XB, ZB): straight while it unloads, then saturating."""
    sign = now[SIGN]
    if sign == 0:
        return float(now[ZB])
    path, z = sign * (x - now[XB]), sign * now[ZB]
    straight = max(0.0, -z)  # travel until z passes zero
    if path < straight:
        return float(sign * (z + path))
    left = cart.distance - max(z, 0.0)
    return float(sign * (cart.distance - left * math.exp(-(path - straight) / cart.distance)))


@compiled
def push(cart: Cart, now: np.ndarray, y: Motion, t: float, drive: float) -> float:
    """Every force on the cart but dry friction, N."""
    x, v = y[X], y[V]
    k = cart.k * now[SCALE_K]
    force = drive + now[HELD] - cart.c * now[SCALE_C] * (1 + cart.slope * x) * v
    if cart.gap <= 0 or now[SIDE] != 0:
        force -= k * (x - now[SIDE] * cart.gap)
    force -= cart.c2 * v * abs(v) + (cart.k3 * x + cart.k2) * x * x
    if cart.cp != 0:
        force -= cart.cp * v * (v * v + SLOWEST**2) ** (cart.exponent / 2 - 0.5)
    if cart.bend > 0:
        force += k * (x - math.sin(cart.bend * x) / cart.bend)
    if now[TOUCH] != 0:
        force -= cart.kstop * (x - cart.stop)
    force -= cart.kv * (x - y[W])
    force -= cart.kc * (x - y[X2]) + cart.cc * (v - y[V2])
    if cart.bristles > 0:
        force -= cart.bristles * bristle(cart, now, x) / cart.distance
    if cart.amp != 0:
        force += cart.amp * math.sin(cart.omega * t + cart.phase)
    if cart.cog != 0:
        force += cart.cog * math.sin(cart.wave * x + cart.angle)
    if cart.law >= 0:
        force += law_force(cart.law, cart.values, x, v, t, y[OWN], y[OWN + 1], drive)
    return float(force)


@compiled
def band(cart: Cart, x: float, v: float, up: bool) -> float:
    """Friction that opposes motion one way, N."""
    level = cart.forward if up else cart.backward
    if cart.extra != 0:
        level += cart.extra * math.exp(-((v / cart.vs) ** 2))
    if cart.patch > 0:
        level += cart.patch * math.exp(-(((x - cart.center) / cart.width) ** 2))
    return level


@compiled
def rates(cart: Cart, now: np.ndarray, y: Motion, t: float, drive: float) -> Motion:
    x, v = y[X], y[V]
    speed = pull = speed2 = pull2 = own = own2 = 0.0
    if not cart.signed:
        speed, pull = v, push(cart, now, y, t, drive) / (cart.m * now[SCALE_M])
    elif now[SIGN] != 0:
        force = push(cart, now, y, t, drive) - now[SIGN] * band(cart, x, v, now[SIGN] > 0)
        speed, pull = v, force / (cart.m * now[SCALE_M])
    if cart.coupled:
        speed2, pull2 = y[V2], (cart.kc * (x - y[X2]) + cart.cc * (v - y[V2])) / cart.m2
    joint = cart.kv / cart.cv * (x - y[W]) if cart.kv != 0 else 0.0
    if cart.law >= 0:
        own, own2 = law_rates(cart.law, cart.values, x, v, y[OWN], y[OWN + 1], drive)
    return speed, pull, speed2, pull2, joint, own, own2


@compiled
def guards(cart: Cart, now: np.ndarray, y: Motion, t: float, drive: float) -> tuple[float, float, float, float]:
    """Positive while no mode changes: turning back, slipping, an edge of the play, the stop."""
    turn = slip = play = stop = np.inf
    x = y[X]
    if cart.signed and now[SIGN] != 0:
        turn = now[SIGN] * y[V]
    elif cart.signed:
        net = push(cart, now, y, t, drive)
        slip = min(band(cart, x, 0.0, True) - net, band(cart, x, 0.0, False) + net) + MARGIN
    if cart.gap > 0:
        play = now[SIDE] * x - cart.gap if now[SIDE] != 0 else cart.gap - abs(x)
    if cart.stop != 0:
        way = 1.0 if now[TOUCH] != 0 else -1.0
        stop = np.sign(cart.stop) * way * (x - cart.stop)
    return turn, slip, play, stop


@compiled
def choose_sign(cart: Cart, now: np.ndarray, y: Motion) -> None:
    """At v = 0: stick, or break away in the direction of the net force."""
    net = push(cart, now, y, now[T], lagged(cart, now, 0.0))
    up, down = net - band(cart, y[X], 0.0, True), -net - band(cart, y[X], 0.0, False)
    now[SIGN] = 1.0 if up > MARGIN else -1.0 if down > MARGIN else 0.0
