"""Typical magnitudes of an effect's parameters, from their units and the plant: differences at zero need them."""

from __future__ import annotations

import re
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from stepid.core.base import Array
from stepid.effects.base import Parameter

_SYMBOLS = ("N", "m", "s", "kg", "V")
_POWERS = {"²": 2, "³": 3}
_ALIASES = {"Hz": ("s", -1)}


@lru_cache(maxsize=1024)
def exponents(parameters: tuple[Parameter, ...]) -> Array:
    """Powers of N, m, s, kg and V in each parameter's unit, shape (n, 5); what is not understood counts as 1."""
    out = np.zeros((len(parameters), len(_SYMBOLS)))
    for row, parameter in zip(out, parameters, strict=True):
        for part, side in zip(parameter.unit.split("/"), (1, -1, -1, -1), strict=False):
            for symbol, power in re.findall(r"([A-Za-z]+)([²³]?)", part):
                name, way = _ALIASES.get(symbol, (symbol, 1))
                if name in _SYMBOLS:
                    row[_SYMBOLS.index(name)] += side * way * _POWERS.get(power, 1)
    return out


def magnitudes(powers: Array, *, mass: float, stiffness: float, gain: float, travel: float) -> Array:
    """Typical values, shape (n,): the travel [m], the spring force over it, the plant's own time, its voltage."""
    force = stiffness * travel
    volts = force / abs(gain) if gain else 1.0
    base = np.array([force, travel, np.sqrt(mass / stiffness), mass, volts])
    out: Array = np.exp(powers @ np.log(np.maximum(base, 1e-12)))
    return out


def lengths(parameters: tuple[Parameter, ...], values: Array) -> Array:
    """By how much each parameter changes where all lengths are measured longer, shape (n,): its change over theirs.

    A plant's laws know no length but those of its parameters: with positions λ times as long a force, N = kg·m/s², is
    fitted λ times as large, a stiffness the same, a cubic coefficient λ⁻² times.

    Parameters
    ----------
    parameters : tuple of Parameter
    values : array, shape (n,)
        Of the parameters, each in its unit; an exponent p stands beside what has it in its unit.
    """
    powers = exponents(parameters)
    power = powers[:, 0] + powers[:, 1]
    for i, parameter in enumerate(parameters):
        if parameter.length is not None:
            power[i] = parameter.length
        elif "^p" in parameter.unit:  # N·(s/m)^p
            power[i] = 1.0 - values[i + 1]
    out: Array = power * values
    return out


def masses(parameters: tuple[Parameter, ...], values: Array) -> Array:
    """By how much each parameter changes where all masses, and so all forces, are measured larger, shape (n,)."""
    powers = exponents(parameters)
    out: Array = (powers[:, 0] + powers[:, 3]) * values
    return out


def times(parameters: tuple[Parameter, ...], values: Array) -> Array:
    """By how much each parameter changes where all times are measured longer, shape (n,).

    A share of the weight's force stands beside gravity, m/s², which is a number of the law.
    """
    powers = exponents(parameters)
    power = powers[:, 2] - 2.0 * powers[:, 0]
    for i, parameter in enumerate(parameters):
        if parameter.length is not None:
            power[i] = -2.0 * parameter.length
    out: Array = power * values
    return out


def with_mass(parameters: tuple[Parameter, ...]) -> npt.NDArray[np.bool_]:
    """Tell which parameters go with the mass, shape (n,): of a plant ten times as heavy they are ten times as large."""
    powers = exponents(parameters)
    out: npt.NDArray[np.bool_] = powers[:, 0] + powers[:, 3] != 0
    return out
