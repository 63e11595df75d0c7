"""The catalogue of effects that a linear mass-spring-damper may be missing."""

from __future__ import annotations

from collections.abc import Iterable
from copy import copy

from stepid.effects.base import Effect, Moment, Motion, Parameter, Scales
from stepid.effects.damping import PositionDependentDamping, PowerDamping, QuadraticDamping
from stepid.effects.drive import (
    ActuatorDeadZone,
    ActuatorLag,
    ActuatorRateLimit,
    ActuatorSaturation,
    Cogging,
    InputDelay,
    PeriodicDisturbance,
)
from stepid.effects.friction import (
    AsymmetricFriction,
    CoulombFriction,
    LoadProportionalFriction,
    PreslidingHysteresis,
    StribeckFriction,
)
from stepid.effects.sensing import SensorDrift
from stepid.effects.stiffness import CubicStiffness, EndStop, FreePlay, QuadraticStiffness, SineStiffness
from stepid.effects.structure import FlexibleCoupling, ViscoelasticSpring
from stepid.errors import InputError

CATALOGUE: tuple[Effect, ...] = (
    CoulombFriction(),
    LoadProportionalFriction(),
    StribeckFriction(),
    AsymmetricFriction(),
    PreslidingHysteresis(),
    QuadraticDamping(),
    PositionDependentDamping(),
    CubicStiffness(),
    QuadraticStiffness(),
    FreePlay(),
    EndStop(),
    ViscoelasticSpring(),
    FlexibleCoupling(),
    ActuatorLag(),
    InputDelay(),
    ActuatorDeadZone(),
    ActuatorSaturation(),
    PeriodicDisturbance(),
    Cogging(),
    SensorDrift(),
    SineStiffness(),
    PowerDamping(),
    ActuatorRateLimit(),
)
"""Every effect that stepid knows, in the order of the documentation's table."""


def among_themselves(catalogue: tuple[Effect, ...]) -> tuple[Effect, ...]:
    """Effects of which none contains another that is not among them: such a one has nothing to begin from."""
    names = {e.name for e in catalogue}
    out = []
    for effect in catalogue:
        inside = tuple(name for name in effect.contains if name in names)
        if inside != effect.contains:
            effect = copy(effect)
            vars(effect)["contains"] = inside
        out.append(effect)
    return tuple(out)


def resolve(effects: Iterable[str | Effect], *, catalogue: tuple[Effect, ...] = CATALOGUE) -> tuple[Effect, ...]:
    """Turn canonical names (or effects) into effects.

    Parameters
    ----------
    effects : iterable of str or Effect
    catalogue : tuple of Effect
        Where names are looked up.

    Returns
    -------
    tuple of Effect
        In the order asked for.

    Raises
    ------
    stepid.errors.InputError
        If a name is not in the catalogue or occurs twice.
    """
    known = {effect.name: effect for effect in catalogue}
    found: list[Effect] = []
    for item in effects:
        effect = known.get(item) if isinstance(item, str) else item
        if effect is None:
            raise InputError(f"there is no effect called {item!r}", f"The catalogue has: {', '.join(known)}.")
        if any(effect.name == other.name for other in found):
            raise InputError(f"the effect {effect.name!r} is named twice", "Name each effect once.")
        found.append(effect)
    return tuple(found)


__all__ = ["CATALOGUE", "Effect", "Moment", "Motion", "Parameter", "Scales", "resolve"]
