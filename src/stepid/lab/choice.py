"""What is hidden in whose campaign: chosen by the instructor or drawn."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from typing import Annotated

import numpy as np
from pydantic import Field

from stepid.core.base import Model
from stepid.core.takes import described
from stepid.effects import Effect, resolve
from stepid.errors import InputError
from stepid.simulation.model import EffectModel

Hidden = Sequence[str | EffectModel]
SEPARABLE = (
    "coulomb_friction",
    "load_proportional_friction",
    "quadratic_damping",
    "position_dependent_damping",
    "cubic_stiffness",
    "quadratic_stiffness",
    "free_play",
    "end_stop",
    "viscoelastic_spring",
    "actuator_saturation",
    "cogging",
    "sensor_drift",
)


class Draw(Model):
    """Draw what is hidden in each group's campaign: one effect, or none.

    Parameters
    ----------
    among : tuple of str
        Canonical names, each as likely as the other. The default are effects that the default runs tell apart, Coulomb
        friction from an asymmetric one excepted.
    none : float
        Probability that nothing is hidden, 0 to 1.
    """

    among: Annotated[tuple[str, ...], Field(min_length=1)] = SEPARABLE
    none: Annotated[float, Field(ge=0, le=1)] = 0.1

    def pick(self, stream: np.random.Generator) -> tuple[str, ...]:
        """Return the names for one group."""
        nothing = stream.uniform() < self.none
        name = self.among[int(stream.integers(len(self.among)))]
        return () if nothing else (name,)


Choice = Draw | Hidden | Mapping[str, Hidden]


def stream(seed: int | str, *words: str) -> np.random.Generator:
    """Random numbers that belong to a seed and a purpose: what one group gets does not depend on the others."""
    text = json.dumps(["stepid.lab", seed, *words])
    return np.random.default_rng(int.from_bytes(hashlib.sha256(text.encode()).digest(), "big"))


def chosen_for(
    group: str, choice: Choice, seed: int | str, *, catalogue: tuple[Effect, ...]
) -> tuple[tuple[Effect, EffectModel | None], ...]:
    """Effects of one group, each with its values where the instructor gave them.

    Raises
    ------
    stepid.errors.InputError
        If the choice has nothing for the group, or names an effect or a parameter that is not in the catalogue.
    """
    hidden = _of_group(group, choice, seed)
    several = isinstance(hidden, Sequence) and not isinstance(hidden, str)
    if not several or not all(isinstance(h, str | EffectModel) for h in hidden):
        raise InputError(
            f"effects of group {group!r} is {described(hidden)}", "Give a sequence of effects, as in (effect,)."
        )
    effects = resolve([h.name if isinstance(h, EffectModel) else h for h in hidden], catalogue=catalogue)
    given = [h if isinstance(h, EffectModel) else None for h in hidden]
    for effect, values in zip(effects, given, strict=True):
        if values is not None:
            check_values(f"{effect.name} of group {group!r}", effect, values)
    return tuple(zip(effects, given, strict=True))


def _of_group(group: str, choice: Choice, seed: int | str) -> Hidden:
    """What a choice says of one group: drawn, its own, or what all have."""
    if isinstance(choice, Draw):
        return choice.pick(stream(seed, group, "effect"))
    if not isinstance(choice, Mapping):
        return choice
    if group not in choice:
        raise InputError(f"effects says nothing for group {group!r}", "Give each group its effects; () hides nothing.")
    return choice[group]


def check_values(who: str, effect: Effect, model: EffectModel) -> None:
    """Refuse values that are not those of the effect's parameters.

    Raises
    ------
    stepid.errors.InputError
        Of `who`, with the names to give.
    """
    wanted = [q.name for q in effect.parameters]
    if model.values.keys() != set(wanted):
        raise InputError(f"{who} has the values {', '.join(model.values) or 'none'}", f"Give {', '.join(wanted)}.")
