"""Choose the strength of a hidden effect so that a linear model visibly misses it."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from stepid.core.base import Array
from stepid.core.experiment import Campaign
from stepid.core.words import length
from stepid.effects import Effect
from stepid.effects.base import Moment
from stepid.errors import ConvergenceError, InputError
from stepid.fitting.problem import fit_linear
from stepid.lab.rig import Plant, Rig, scale_of
from stepid.lab.sizes import SIZES
from stepid.simulation.model import EffectModel, PlantModel, RunState
from stepid.simulation.records import lay_out
from stepid.simulation.simulate import simulate

_LEAD = 5.0  # s that a cart takes to find its rest position before the record
_ROUNDS, _DRAWS = 14, 6
_CLOSE = math.log(1.1)  # of the wanted strength


class Start(NamedTuple):
    """Where each run begins within its band of rest, −1 … 1, and the phases of what turns on its own, rad."""

    share: Array
    phase: Array


def model_of(
    rig: Rig, plant: Plant, hidden: tuple[EffectModel, ...], start: Start, *, catalogue: tuple[Effect, ...]
) -> PlantModel:
    """Put a plant, its effects and where each run begins together; carts begin at rest."""
    known = {effect.name: effect for effect in catalogue}
    effects = [known[h.name] for h in hidden]
    keys = [f"{e.name}.{q.name}" for e in effects for q in e.run_parameters]
    states = {
        plan.name: RunState(
            displacement=0.9 * float(start.share[i]) * _band(plant, plan.added_mass, hidden, effects),
            phases=dict.fromkeys(keys, float(start.phase[i])),
        )
        for i, plan in enumerate(rig.runs)
    }
    model = PlantModel(
        base_mass={rig.base: plant.mass},
        stiffness={rig.spring: plant.stiffness},
        damping={rig.damper: plant.damping},
        force_gain=plant.gain,
        effects=hidden,
        runs=states,
    )
    pushing = tuple(h for h, e in zip(hidden, effects, strict=True) if e.rests_anywhere)
    if all(e.dry for e in effects if e.rests_anywhere):
        return model
    # an effect that pushes a cart about at rest has done so long before the record
    still = (np.zeros(round(_LEAD / rig.sample_time)),) * len(rig.runs)
    settled = respond(rig, model.model_copy(update={"effects": pushing}), catalogue=catalogue, inputs=still)
    states = {
        plan.name: RunState(displacement=float(x[-1]), phases=states[plan.name].phases)
        for plan, x in zip(rig.runs, settled, strict=True)
    }
    return model.model_copy(update={"runs": states})


def respond(
    rig: Rig, model: PlantModel, *, catalogue: tuple[Effect, ...], inputs: tuple[Array, ...] = ()
) -> tuple[Array, ...]:
    """Simulate a group's runs: positions from the rest position, m, without the reading's noise and rounding.

    Raises
    ------
    stepid.errors.ConvergenceError
        If the response runs away.
    """
    moved = simulate(model, campaign_of(rig, inputs=inputs), catalogue=catalogue)
    return tuple(moved[plan.name] for plan in rig.runs)


def campaign_of(
    rig: Rig, *, positions: tuple[Array, ...] = (), inputs: tuple[Array, ...] = (), name: str = "hidden"
) -> Campaign:
    """Make the rig's runs, with these positions [m] and inputs [V]: zeros and the planned steps if not given."""
    inputs = inputs or tuple(rig.inputs(plan.level) for plan in rig.runs)
    positions = positions or tuple(np.zeros(volts.size) for volts in inputs)
    each = zip(rig.runs, positions, inputs, strict=True)
    return Campaign(name=name, experiments=tuple(rig.experiment(plan, position=x, input=u) for plan, x, u in each))


def _band(plant: Plant, added: float, hidden: tuple[EffectModel, ...], effects: list[Effect]) -> float:
    """Displacement at which dry friction just holds the cart at rest, m."""
    mass, stiffness, damping = plant.mass + added, plant.stiffness, plant.damping
    total = 0.0
    for effect, own in zip(effects, hidden, strict=True):
        if effect.dry:
            values = tuple(own.values[q.name] for q in effect.parameters)
            ways = (Moment(0.0, 0.0, way, 0.0, mass, stiffness, damping, 0.0) for way in (1.0, -1.0))
            total += min(effect.holds(values, m) for m in ways)
    return total / plant.stiffness


def linear_misfit(rig: Rig, positions: tuple[Array, ...]) -> float:
    """RMS that the best joint linear fit leaves, m; infinite where there is none."""
    found = fit_linear(lay_out(campaign_of(rig, positions=positions)))
    return math.inf if found is None else found.rms


def sized(
    rig: Rig,
    plant: Plant,
    effect: Effect,
    start: Start,
    *,
    misfit: float,
    least: float,
    stream: Callable[[str], np.random.Generator],
    catalogue: tuple[Effect, ...],
) -> EffectModel:
    """Draw an effect and find the strength at which the best linear fit leaves `misfit` [m], at any rate `least`.

    Raises
    ------
    stepid.errors.InputError
        If no strength leaves so much, or there is no natural size for the effect.
    """
    if effect.name not in SIZES:
        raise InputError(
            f"there is no natural size for the effect {effect.name!r}",
            f"Give its values: stepid.EffectModel(name={effect.name!r}, values={{…}}).",
        )
    at = scale_of(rig, plant)

    def values(number: int, strength: float) -> EffectModel:
        drawn = SIZES[effect.name](stream(f"{effect.name} {number}"), at, strength)
        return EffectModel(name=effect.name, values={k: float(f"{v:.6g}") for k, v in drawn.items()})

    def excess(number: int, strength: float) -> float:
        """Logarithm of what is left over what is wanted."""
        try:
            model = model_of(rig, plant, (values(number, strength),), start, catalogue=catalogue)
            left = linear_misfit(rig, respond(rig, model, catalogue=catalogue))
        except ConvergenceError:
            left = math.inf
        return math.log(min(max(left / misfit, 1e-3), 1e3))

    for number in range(_DRAWS):
        strength, off = _solve(partial(excess, number))
        if abs(off) < _CLOSE or math.log(least / misfit) <= off < 0:
            return values(number, strength)
    raise InputError(
        f"{effect.name} cannot be made strong enough on this rig: a linear model must miss it by {length(least)}",
        "Ask for less visibility, take longer steps, or reduce the rig's noise.",
    )


def _solve(excess: Callable[[float], float]) -> tuple[float, float]:
    """Strength at which the excess vanishes, by a secant in logarithms, and the excess that is left there."""
    at, off, slope = 0.0, excess(1.0), 1.0
    best = (at, off)
    for _ in range(_ROUNDS):
        if abs(off) < 0.5 * _CLOSE:
            break
        step = float(np.clip(-off / slope, -2.0, 2.0))
        new = excess(math.exp(at + step))
        if new == off:  # the strength has met its bound
            break
        slope = float(np.clip((new - off) / step, 0.5, 4.0))
        at, off = at + step, new
        if abs(off) < abs(best[1]):
            best = (at, off)
    return math.exp(best[0]), best[1]
