"""The equation of motion of the final model, with the numbers that were found."""

from __future__ import annotations

from collections.abc import Mapping

from stepid.core.estimate import Estimate
from stepid.core.latex import parameter_name
from stepid.core.quantities import quantities_of
from stepid.diagnosis.result import Diagnosis
from stepid.diagnosis.wording import effect_names
from stepid.effects import CATALOGUE

_SYMBOLS = {"base_mass": "m₀", "stiffness": "k", "damping": "c", "force_gain": "K_f"}
_LAWS = {effect.name: effect.law for effect in CATALOGUE}


def equation(d: Diagnosis) -> tuple[str, ...]:
    """Write the equation of motion; laws that are no further force follow, each with the name of its effect.

    Parameters
    ----------
    d : Diagnosis

    Returns
    -------
    tuple of str
        For example ``("(m₀ + added mass) a = K_f u − c v − k x − F_c sign(v)",)``.
    """
    said = quantities_of(d)
    first, others = "(m₀ + added mass) a = K_f u − c v − k x", []
    for name in d.effects:
        law = _LAWS.get(name, "")
        if law[:1] in ("−", "+") and "," not in law and " beyond " not in law:
            first += f" {law[0]} {law[1:]}"
        else:
            others.append(f"with {effect_names((name,))}" + (f": {said.law(law)}" if law else ""))
    return said.law(first), *others


def numbers(d: Diagnosis) -> tuple[tuple[str, str], ...]:
    """Name each number of the equation, with its value, standard uncertainty and unit."""
    found: Mapping[str, Estimate] = d.parameters
    said = quantities_of(d)
    return tuple((said.law(_symbol(name)), str(value)) for name, value in found.items())


def _symbol(name: str) -> str:
    stem, bracket, label = name.partition("[")
    if stem not in _SYMBOLS:
        return parameter_name(name)
    return _SYMBOLS[stem] + (f" ({label.removesuffix(']')})" if bracket else "")
