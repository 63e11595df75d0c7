"""The catalogue of effects that a linear mass-spring-damper may be missing.

It lists itself: every class with a name in a file of this folder is in it.
"""

from __future__ import annotations

from collections.abc import Iterable
from copy import copy
from importlib import import_module
from pkgutil import iter_modules

from stepid.core.takes import a, each, takes
from stepid.effects.base import Effect, Moment, Motion, Parameter, Scales
from stepid.errors import InputError

_FILES = ("friction", "damping", "stiffness", "structure", "drive", "sensing")  # their order; then others by name


def _every_effect() -> tuple[Effect, ...]:
    """One of each class in this folder that has a name, as they stand in their files."""
    there = {module.name for module in iter_modules(__path__)} - {"base"}
    found: list[Effect] = []
    for name in (*_FILES, *sorted(there.difference(_FILES))):
        module = import_module(f"{__name__}.{name}")
        kinds = [kind for kind in vars(module).values() if isinstance(kind, type) and issubclass(kind, Effect)]
        found += [kind() for kind in kinds if kind.__module__ == module.__name__ and hasattr(kind, "name")]
    return tuple(found)


CATALOGUE: tuple[Effect, ...] = _every_effect()
"""Every effect that stepid knows, in the order of the documentation's table."""


def among_themselves(catalogue: tuple[Effect, ...]) -> tuple[Effect, ...]:
    """Effects of which none contains another that is not among them: such a one has nothing to begin from.

    Of two with one name the last counts, as in `resolve`: a law of your own takes the place of one built in.
    """
    known = {effect.name: effect for effect in catalogue}
    out = []
    for effect in known.values():
        inside = tuple(name for name in effect.contains if name in known)
        if inside != effect.contains:
            effect = copy(effect)
            vars(effect)["contains"] = inside
        out.append(effect)
    return tuple(out)


a_catalogue = each(a(Effect, ""), "a tuple of effects, as stepid.effects.CATALOGUE")
"""Check of an argument `catalogue`."""
_some_effects = each(a((str, Effect), ""), 'names of effects, as ("coulomb_friction",), or effects')


def _effects(value: object) -> object:
    return _some_effects((value,) if isinstance(value, str | Effect) else value)


@takes(effects=_effects, catalogue=a_catalogue)
def resolve(
    effects: str | Effect | Iterable[str | Effect], *, catalogue: tuple[Effect, ...] = CATALOGUE
) -> tuple[Effect, ...]:
    """Turn canonical names (or effects) into effects.

    Parameters
    ----------
    effects : iterable of str or Effect
        One alone need not be put in brackets.
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
    for item in (effects,) if isinstance(effects, str | Effect) else effects:
        effect = known.get(item) if isinstance(item, str) else item
        if effect is None:
            raise InputError(f"there is no effect called {item!r}", f"The catalogue has: {', '.join(known)}.")
        if any(effect.name == other.name for other in found):
            raise InputError(f"the effect {effect.name!r} is named twice", "Name each effect once.")
        found.append(effect)
    return tuple(found)


__all__ = ["CATALOGUE", "Effect", "Moment", "Motion", "Parameter", "Scales", "resolve"]
