"""Several steps of one run pooled into one set of characteristics."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from stepid.core.base import Array
from stepid.identification.characteristics_model import Characteristics, CharacteristicsUncertainty
from stepid.identification.second_order import damped_frequency, damping_ratio

_POOLED = ("peak_time", "overshoot", "static_gain", "settling_time")
_SCATTER = 3.0  # times more than the uncertainties allow: worth a note


def pool_steps(steps: Sequence[Characteristics], *, name: str) -> Characteristics:
    """Pool the characteristics of several steps of one run.

    Parameters
    ----------
    steps : sequence of Characteristics
        At least one; of one run, so of one mass, spring and damper.
    name : str
        Of the run.

    Returns
    -------
    Characteristics
        Peak time, overshoot, static gain and settling time are means weighted by inverse variances; their standard
        uncertainties come from the steps' own, or from the scatter between steps where that is larger (with dry
        friction or a dead zone, steps up and back differ). Steady state and step are those of the first.
    """
    first = steps[0]
    if len(steps) == 1:
        return first if first.name == name else _renamed(first, name)
    means: dict[str, float] = {}
    spreads: dict[str, float] = {}
    widest = 0.0
    for quantity in _POOLED:
        pairs = [
            (value, getattr(step.uncertainty, quantity) or 0.0)
            for step in steps
            if (value := getattr(step, quantity)) is not None
        ]
        if pairs:
            values, known = np.array(pairs).T
            means[quantity], spreads[quantity], scatter = _weighted_mean(values, known)
            widest = max(widest, scatter) if quantity in {"peak_time", "overshoot"} else widest
    notes = tuple(dict.fromkeys(note for step in steps for note in step.notes))
    if widest > _SCATTER:
        notes += (f"its {len(steps)} steps scatter {widest:.1f} times more than their uncertainties allow",)
    frequency = damped_frequency(means["peak_time"])
    ratio = damping_ratio(means["overshoot"])
    return Characteristics(
        name=name,
        damped_frequency=frequency,
        damping_ratio=ratio,
        natural_frequency=frequency / math.sqrt(1 - ratio**2),
        steady_state=first.steady_state,
        uncertainty=CharacteristicsUncertainty(**spreads, steady_state=first.uncertainty.steady_state),
        correlation=float(np.mean([step.correlation for step in steps])),
        peak_time_bias=float(np.mean([step.peak_time_bias for step in steps])),
        overshoot_bias=float(np.mean([step.overshoot_bias for step in steps])),
        spring=first.spring,
        damper=first.damper,
        base=first.base,
        added_mass=first.added_mass,
        start=first.start,
        step=first.step,
        motion=first.motion,
        input_unit=first.input_unit,
        notes=notes,
        **means,
    )


def _weighted_mean(values: Array, known: Array) -> tuple[float, float, float]:
    """Mean, its standard uncertainty, and how much more the values scatter than their uncertainties allow."""
    if not np.all(known > 0):
        if not (spread := float(np.std(values))):
            return float(values[0]), 0.0, 0.0
        known = np.full_like(values, spread)
    weight = known**-2 / np.sum(known**-2)
    mean = float(weight @ values)
    inner = float(np.sum(known**-2)) ** -0.5
    scatter = math.sqrt(float(np.sum(((values - mean) / known) ** 2)) / max(values.size - 1, 1))
    if scatter > 2:  # the stated uncertainties do not tell the steps apart: count them alike
        mean = float(np.mean(values))
        return mean, float(np.std(values, ddof=1)) / math.sqrt(values.size), scatter
    return mean, inner * max(scatter, 1.0), scatter


def _renamed(step: Characteristics, name: str) -> Characteristics:
    return Characteristics(**step.model_dump() | {"uncertainty": step.uncertainty, "name": name})
