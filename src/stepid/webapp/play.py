"""Playing with a plant: knobs for the linear parameters and those of one effect, and the response that they make."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

import stepid
from stepid.core.base import Array
from stepid.core.estimate import prefixed
from stepid.core.experiment import Campaign
from stepid.core.quantities import quantities_of
from stepid.core.words import length
from stepid.diagnosis.result import Diagnosis
from stepid.diagnosis.wording import effect_names
from stepid.effects import CATALOGUE, Effect, resolve
from stepid.effects.base import Parameter
from stepid.errors import StepidError
from stepid.fitting.fit import prepare
from stepid.simulation.model import EffectModel, PlantModel

NONE = "none"
_STEPS = 200  # of a knob


@dataclass(frozen=True)
class Knob:
    """One number that can be turned: its key, words with the unit that it is shown in, bounds, step and value.

    Numbers are in SI units; divided by `scale` they are in the unit that is shown, mm where tables have mm.
    """

    key: str
    label: str
    low: float
    high: float
    step: float
    value: float
    scale: float = 1.0


@dataclass(frozen=True)
class Bench:
    """What one can play with.

    `linear` is the linear fit of `campaign`, `fitted` the fits with one effect, by its name. `starts` has values to
    begin with for every effect of the catalogue, in the order of its parameters. `drift` is a speed, m/s, that a slow
    effect could have.
    """

    campaign: Campaign
    linear: PlantModel
    fitted: Mapping[str, PlantModel]
    starts: Mapping[str, tuple[float, ...]]
    drift: float

    def model(self, effect: str) -> PlantModel:
        """The plant to begin with where an effect is chosen."""
        return self.fitted.get(effect, self.linear)


def effect_choices() -> dict[str, str]:
    """Effects that can be chosen: words to name."""
    return {"no effect (linear)": NONE} | {effect_names((effect.name,)): effect.name for effect in CATALOGUE}


def bench(campaign: Campaign, found: Diagnosis | None = None) -> Bench:
    """Fit the linear plant, and take a middle size for each effect; an effect that a diagnosis found as it found it.

    Raises
    ------
    stepid.errors.StepidError
        If no linear plant can be fitted.
    """
    scales = prepare(campaign).scales
    starts = {effect.name: _middle(effect.starts(scales)) for effect in CATALOGUE}
    out = Bench(campaign, stepid.fit(campaign).model, {}, starts, scales.displacement / scales.duration)
    return out if found is None or len(found.model.effects) != 1 else _with(out, found.model)


def best(at: Bench, effect: str) -> Bench:
    """Return the bench with the best fit of an effect to all runs; StepidError where there is none."""
    return _with(at, stepid.fit(at.campaign, effects=(effect,)).model)


def _with(at: Bench, model: PlantModel) -> Bench:
    (one,) = model.effects
    values = tuple(one.values[p.name] for p in _effect(one.name).parameters)
    return replace(at, fitted={**at.fitted, one.name: model}, starts={**at.starts, one.name: values})


def knobs(at: Bench, run: str, effect: str) -> tuple[Knob, ...]:
    """Knobs of the linear parameters that a run has, and of an effect (`NONE` for none)."""
    one, model = at.campaign[run], at.model(effect)
    out = [
        _linear("base_mass", "base mass [kg]", model.base_mass[one.base], 2.0),
        _linear("stiffness", "stiffness [N/m]", model.stiffness[one.spring], 2.0),
        _linear("damping", "damping [N·s/m]", model.damping[one.damper], 4.0),
        _linear("force_gain", "force gain [N/V]", model.force_gain, 2.0),
    ]
    if effect != NONE:
        for parameter, value in zip(_effect(effect).parameters, at.starts[effect], strict=True):
            out.append(_own(effect, parameter, value, at.drift))
    return tuple(replace(knob, label=quantities_of(at.campaign).text(knob.label)) for knob in out)


def turned(at: Bench, run: str, effect: str, values: Mapping[str, float]) -> PlantModel:
    """Return the plant with the knobs' values."""
    one, model = at.campaign[run], at.model(effect)
    effects: tuple[EffectModel, ...] = ()
    if effect != NONE:
        own = {p.name: values[f"{effect}.{p.name}"] for p in _effect(effect).parameters}
        effects = (EffectModel(name=effect, values=own),)
    return model.model_copy(
        update={
            "base_mass": {**model.base_mass, one.base: values["base_mass"]},
            "stiffness": {**model.stiffness, one.spring: values["stiffness"]},
            "damping": {**model.damping, one.damper: values["damping"]},
            "force_gain": values["force_gain"],
            "effects": effects,
        }
    )


def response(at: Bench, run: str, model: PlantModel) -> tuple[Array | None, str]:
    """Simulate a run; return its position [m] and a sentence: the RMS left, or why there is no response."""
    one = at.campaign[run]
    try:
        simulated = stepid.simulate(model, at.campaign[[run]])[run]
    except StepidError as error:
        return None, str(error)
    left = length(float(np.sqrt(np.mean((one.position - simulated) ** 2))))
    return simulated, quantities_of(at.campaign).text(f"{left} RMS are left.")


def reach(at: Bench, run: str) -> float:
    """How far the scale of what is left reaches, m: a fifth of the motion, so that it stays while knobs are turned."""
    return 0.2 * float(np.ptp(at.campaign[run].position)) or 1e-6


def _effect(name: str) -> Effect:
    return resolve((name,))[0]


def _middle(starts: object) -> tuple[float, ...]:
    several = [tuple(map(float, one)) for one in starts]  # type: ignore[attr-defined]
    return several[len(several) // 2]


def _linear(key: str, label: str, value: float, times: float) -> Knob:
    far = times * value or 1.0
    low, high = min(0.0, far), max(0.0, far)
    if key != "damping":  # a plant without mass or spring is none
        low, high = sorted((value / 4, far))
    return Knob(key, label, *_round(low, high), value)


def _own(effect: str, parameter: Parameter, value: float, drift: float) -> Knob:
    far = {"rad": math.pi, "m/s": drift}.get(parameter.unit, 1.0) if value == 0 else 4 * abs(value)
    low = max(parameter.lower, -far)
    high = min(parameter.upper, far)
    scale, unit = _shown_in(value or high, parameter.unit)
    label = parameter.name.replace("_", " ") + (f" [{unit}]" if unit else "")
    return Knob(f"{effect}.{parameter.name}", label, *_round(low, high), value, scale)


def _shown_in(value: float, unit: str) -> tuple[float, str]:
    """The unit in which tables show a value, and how much of the SI unit it is."""
    shown = prefixed(value, None, unit)[2]
    return (1.0 if shown == unit else 1e-3), shown


def _round(low: float, high: float) -> tuple[float, float, float]:
    """Bounds and a step with two digits."""
    step = (high - low) / _STEPS
    places = 1 - math.floor(math.log10(step))
    return low, high, round(step, places)
