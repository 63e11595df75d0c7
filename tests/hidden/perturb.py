"""What real labs have on top of any effect, or of none: scatter from run to run, other noise, bad samples, faint modes.

`SEEN` may be looked at while the diagnosis is developed; the other kinds are held back until the end.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from . import changes
from .draw import DRIVE, Setup
from .outside import DRIVEN_OUTSIDE
from .plant import DRY, Run

KINDS = (
    "start_time",
    "gain",
    "damping",
    "friction",
    "rest",
    "ar1",
    "hum",
    "pink",
    "outliers",
    "dropped",
    "eccentricity",
    "second_mode",
    "creep",
    "hold_short",
    "hold_long",
)
SEEN = ("start_time", "gain", "ar1", "outliers", "second_mode")
HOLDS = ("hold_short", "hold_long")
DRIVEN = ("start_time", "gain")
RUBBING = (*DRY, "presliding_hysteresis")
LEVELS = ("level", "breakaway", "level_forward", "level_backward", "coefficient")
# the effect of the catalogue that a kind is, or comes close to: its name is right
TWINS = {"second_mode": "flexible_coupling", "hum": "periodic_disturbance", "creep": "viscoelastic_spring"}
Sizes = dict[str, float]


def possible(kind: str, effects: tuple[str, ...], outside: str | None) -> bool:
    """Whether a kind can go with what else is hidden."""
    if kind in HOLDS:
        return not set(effects) & set(DRIVE) and outside not in (*DRIVEN_OUTSIDE, "fading_drive")
    if kind == "friction":  # there must be friction for it to differ
        return bool(set(effects) & set(RUBBING))
    return TWINS.get(kind) not in effects and not (kind == "eccentricity" and outside == "sensor_ripple")


def choose(
    rng: np.random.Generator, turn: int, effects: tuple[str, ...], outside: str | None, *, seen: bool
) -> tuple[str, ...]:
    """One kind or two; the first goes through all kinds with `turn`, where it can."""
    pool = [k for k in (SEEN if seen else KINDS) if possible(k, effects, outside)]
    wanted = (SEEN if seen else KINDS)[turn % len(SEEN if seen else KINDS)]
    first = wanted if wanted in pool else str(rng.choice(pool))
    if not seen and "friction" in pool and rng.random() < 0.25:  # the few effects that it goes with
        first = "friction"
    others = [k for k in pool if k != first and not (k in HOLDS and first in (*HOLDS, *DRIVEN))]
    others = [k for k in others if not (k in DRIVEN and first in HOLDS)]
    if rng.random() < 0.5:
        return (first,)
    return (first, str(rng.choice(others)))


def _log(rng: np.random.Generator, low: float, high: float) -> float:
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def draw(kind: str, rng: np.random.Generator, setup: Setup) -> Sizes:
    """What the runs of a campaign share of one kind; lengths over the reach, noise over the floor, times in s."""
    period = setup.sample_time
    if kind == "start_time":
        return {"samples": _log(rng, 0.1, 2.0)}
    if kind in ("gain", "damping", "friction"):
        return {"scatter": _log(rng, 0.01, 0.06)}
    if kind == "rest":  # apart: another rest in each run; else the rest moves with the first or the last move
        return {"scatter": _log(rng, 0.005, 0.03), "when": float(rng.integers(0, 3))}
    if kind == "ar1":
        return {"time_constant": _log(rng, 0.001, 0.02), "floors": _log(rng, 0.7, 5.0)}
    if kind == "hum":
        line = float(rng.choice([50.0, 60.0])) * float(rng.uniform(0.998, 1.002))
        return {"frequency": line, "floors": _log(rng, 1.0, 10.0)}
    if kind == "pink":
        return {"floors": _log(rng, 0.7, 5.0)}
    if kind == "outliers":
        return {"share": _log(rng, 0.001, 0.015), "floors": _log(rng, 8.0, 80.0)}
    if kind == "dropped":
        return {
            "share": _log(rng, 0.003, 0.04),
            "longest": float(rng.integers(1, 6)),
            "held": float(rng.random() < 0.5),
        }
    if kind == "eccentricity":
        return {"size": _log(rng, 0.001, 0.01), "pitch": float(rng.uniform(0.3, 1.5)), "phase": rng.uniform(0, 6.283)}
    if kind == "second_mode":
        top = min(6.0, 0.35 / period / setup.rate)
        return {"share": _log(rng, 0.003, 0.03), "ratio": _log(rng, 2.5, max(top, 2.6)), "zeta": _log(rng, 0.01, 0.05)}
    if kind == "creep":
        return {"share": _log(rng, 0.005, 0.03), "lasts": _log(rng, 0.3, 2.0)}
    if kind == "hold_short":
        return {"low": 1.0, "high": 8.0, "push": _log(rng, 0.002, 0.03), "tremble": 0.0}
    if kind == "hold_long":
        turn = 2 * np.pi / setup.rate / period
        return {
            "low": 0.3 * turn,
            "high": 2.0 * turn,
            "push": _log(rng, 0.002, 0.03),
            "tremble": _log(rng, 0.0002, 0.003),
        }
    raise KeyError(kind)


def _spread(own: np.random.Generator) -> float:
    return float(np.clip(own.standard_normal(), -2.0, 2.0))


def own_size(kind: str, size: Sizes, own: np.random.Generator, inputs: np.ndarray) -> float:
    """By how much one run differs: samples, or a share."""
    if kind == "start_time":
        changes_at = np.flatnonzero(np.diff(inputs, prepend=0.0))
        first = float(changes_at[0]) if changes_at.size else 0.0
        return max(-first, size["samples"] * _spread(own)) if first else abs(size["samples"] * _spread(own))
    if kind in HOLDS:
        return min(own.uniform(size["low"], size["high"]), 0.4 * inputs.size)
    return size["scatter"] * _spread(own) if "scatter" in size else 0.0


def on_run(kind: str, size: Sizes, off: float, run: Run, setup: Setup, own: np.random.Generator) -> Run:
    """The plant of one run as the perturbation changes it; `off` is from `own_size`."""
    if kind == "start_time":
        return _shifted(run, off)
    if kind == "gain":
        return replace(run, gain=run.gain * (1 + off))
    if kind == "damping":
        return replace(run, damping=run.damping * (1 + off))
    if kind == "friction":
        rubbing = {
            name: {p: v * (1 + off) if p in LEVELS else v for p, v in values.items()} if name in RUBBING else values
            for name, values in run.effects.items()
        }
        return replace(run, effects=rubbing)
    if kind == "rest":
        return _rest_moved(run, off * setup.reach, int(size["when"]))
    if kind == "second_mode":
        mass = size["share"] * setup.base_mass
        spring = mass * (setup.rate * size["ratio"]) ** 2
        mode = {"mass": mass, "stiffness": spring, "damping": 2 * size["zeta"] * float(np.sqrt(spring * mass))}
        return replace(run, effects={**run.effects, "flexible_coupling": mode})
    if kind == "creep":
        spring = size["share"] * setup.stiffness["medium"]
        lasts = size["lasts"] * setup.sample_time * float(np.mean([s.inputs.size for s in setup.slots]))
        return replace(
            run, effects={**run.effects, "viscoelastic_spring": {"stiffness": spring, "damping": spring * lasts}}
        )
    if kind in HOLDS:  # the hand pushes a little as it lets go
        return replace(run, velocity=size["push"] * setup.rate * abs(run.position) * _spread(own))
    return run


def _shifted(run: Run, samples: float) -> Run:
    """The drive comes later than the record says (or sooner), the whole samples by the input, the rest by a delay."""
    whole = int(np.floor(samples + 1e-12))
    u = np.asarray(run.inputs, float)
    u = np.concatenate([np.full(max(whole, 0), run.input_before), u, np.full(max(-whole, 0), u[-1])])
    u = u[-whole:] if whole < 0 else u[: run.size]
    delay = run.get("input_delay", "delay") + max(samples - whole, 0.0) * run.sample_time
    return replace(run, inputs=u, effects={**run.effects, "input_delay": {"delay": delay}})


def _rest_moved(run: Run, shift: float, when: int) -> Run:
    push = np.full(run.size, run.stiffness * shift)
    if when == 0:
        moved = replace(run, position=run.position + shift) if np.any(run.inputs) else run
    else:
        at = np.flatnonzero(np.diff(np.asarray(run.inputs), prepend=run.input_before))
        push[: (at[0] if when == 1 else at[-1]) if at.size else run.size // (2 * when + 1)] = 0.0
        moved = run
    return replace(moved, held_force=push if run.held_force is None else run.held_force + push)


def on_reading(
    kind: str, size: Sizes, off: float, x: np.ndarray, setup: Setup, floor: float, own: np.random.Generator
) -> np.ndarray:
    """The reading of one run as the perturbation changes it, before white noise and rounding; `floor` in m."""
    n, period = x.size, setup.sample_time
    if kind == "ar1":
        return x + size["floors"] * floor * changes.colored(n, period, size["time_constant"], own)
    if kind == "pink":
        return x + size["floors"] * floor * changes.pink(n, own)
    if kind == "hum":
        return x + size["floors"] * floor * changes.hum(n, period, size["frequency"], own.uniform(0, 2 * np.pi))
    if kind == "outliers":
        return x + floor * changes.wrong(n, size["share"], 0.5 * size["floors"], 1.5 * size["floors"], own)
    if kind == "eccentricity":
        return changes.eccentric(x, size["size"] * setup.reach, size["pitch"] * setup.reach, size["phase"])
    if kind in HOLDS:
        still = np.clip(np.arange(n) / off, 0.0, 1.0)
        shake = size["tremble"] * x[0] * np.sin(4 * np.pi * still) * (1 - still)
        return np.asarray(changes.late(x, off) + shake)
    return x


def gone(kind: str, size: Sizes, inputs: np.ndarray, own: np.random.Generator) -> np.ndarray:
    """Samples of one run that are missing."""
    if kind != "dropped":
        return np.zeros(inputs.size, bool)
    return changes.lost(inputs, size["share"], int(size["longest"]), own)
