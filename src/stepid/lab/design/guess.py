"""The guess that a plan starts from: a linear plant, its effects and their sizes."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

from stepid.effects import Effect, Scales, resolve
from stepid.errors import InputError
from stepid.identification.second_order import overshoot_of_plant
from stepid.lab.choice import check_values
from stepid.simulation.model import EffectModel, PlantModel

LABELS = {"base_mass": "cart", "stiffness": "spring", "damping": "damper"}
PLANT = (*LABELS, "force_gain")
Guess = PlantModel | Mapping[str, float]
Given = str | EffectModel
_SETTLED = 4.0  # decay times until a swing is down to 2 %
_SWINGS = (3.0, 12.0)  # periods of the heaviest run that half a record lasts, at least and at most


def as_plant(given: Guess) -> PlantModel:
    """Make a linear plant of a guess, one label of each kind; what a model says of single runs is left out.

    Raises
    ------
    stepid.errors.InputError
        If it is no plant, or one with several springs, dampers or bases.
    """
    if isinstance(given, PlantModel):
        for what in LABELS:
            if len(getattr(given, what)) != 1:
                raise InputError(
                    f"plant: has {len(getattr(given, what))} values of {what}; a plan is about one",
                    "Give a PlantModel with one base, one spring and one damper.",
                )
        model = given.model_copy(update={"runs": {}})
    else:
        if not isinstance(given, Mapping) or set(given) != set(PLANT):
            raise InputError(
                f"plant: needs {', '.join(PLANT)}",
                'Give them by name: {"base_mass": 0.95, "stiffness": 216.0, "damping": 12.0, "force_gain": 7.8} in kg,'
                " N/m, N·s/m and N/V, or the model of a fit.",
            )
        values = {what: {label: given[what]} for what, label in LABELS.items()}
        model = PlantModel.model_validate(values | {"force_gain": given["force_gain"]})
    mass, stiffness, damping, gain = values_of(model)
    if not (mass > 0 and stiffness > 0 and damping >= 0 and gain != 0):
        raise InputError(
            "plant: needs a positive mass and stiffness, a damping that is not negative and a force gain that is not 0",
            "Guess from what the parts weigh and how fast the cart swings.",
        )
    return model


def values_of(plant: PlantModel) -> tuple[float, float, float, float]:
    """Base mass, stiffness, damping and force gain of a plant with one label of each."""
    (mass,), (stiffness,), (damping,) = (getattr(plant, what).values() for what in LABELS)
    return mass, stiffness, damping, plant.force_gain


def lasting(plant: PlantModel, heaviest: float) -> float:
    """Duration of a record, s: twice what the heaviest run takes to settle to 2 %, 3 to 12 periods each."""
    mass, stiffness, damping, _ = values_of(plant)
    period = 2 * math.pi * math.sqrt((mass + heaviest) / stiffness)
    settled = _SETTLED * 2 * (mass + heaviest) / damping if damping else math.inf
    return 2 * min(max(settled, _SWINGS[0] * period), _SWINGS[1] * period)


def reach(plant: PlantModel, level: float, heaviest: float) -> float:
    """Farthest displacement of the linear plant under a step and one back, m."""
    mass, stiffness, damping, gain = values_of(plant)
    return abs(gain * level / stiffness) * (1 + overshoot_of_plant(mass + heaviest, stiffness, damping))


def typical(plant: PlantModel, level: float, added: float, sample_time: float, duration: float) -> Scales:
    """Magnitudes of the motion that a step brings, for the usual size of an effect."""
    mass, stiffness, damping, gain = values_of(plant)
    total = mass + added
    peak, still = reach(plant, level, added), abs(gain * level / stiffness)
    speed = still * math.sqrt(stiffness / total)
    return Scales(
        displacement=peak,
        velocity=speed,
        force=stiffness * peak,
        mass=total,
        stiffness=stiffness,
        damping=damping,
        volts=abs(level),
        volts_least=abs(level),
        sample_time=sample_time,
        duration=duration,
        floor=0.0,
        low=min(math.copysign(peak, gain * level), 0.0),
        high=max(math.copysign(peak, gain * level), 0.0),
        resonances=(1.5 / math.pi * math.sqrt(stiffness / total),),
    )


def sized(
    given: Iterable[Given], known: Iterable[EffectModel], scales: Scales, catalogue: tuple[Effect, ...]
) -> tuple[EffectModel, ...]:
    """Give each effect its size: its own, that of the plant's effect of this name, or else a usual one.

    Raises
    ------
    stepid.errors.InputError
        If there is no such effect or no such parameter.
    """
    sizes = {effect.name: effect for effect in known}
    out = []
    for item in (given,) if isinstance(given, (str, EffectModel)) else tuple(given):
        model = item if isinstance(item, EffectModel) else sizes.get(item)
        (effect,) = resolve([item.name if isinstance(item, EffectModel) else item], catalogue=catalogue)
        if model is None:
            usual = effect.starts(scales)[0]
            values = {q.name: float(v) for q, v in zip(effect.parameters, usual, strict=True)}
            model = EffectModel(name=effect.name, values=values)
        check_values(effect.name, effect, model)
        out.append(model)
    return tuple(out)


def parameter_values(plant: PlantModel, effects: tuple[Effect, ...]) -> dict[str, tuple[float, str]]:
    """Value and unit of each shared parameter, named and in the order of a joint fit."""
    mass, stiffness, damping, gain = values_of(plant)
    (spring,), (damper,) = plant.stiffness, plant.damping
    out = {
        "base_mass": (mass, "kg"),
        f"stiffness[{spring}]": (stiffness, "N/m"),
        f"damping[{damper}]": (damping, "N·s/m"),
        "force_gain": (gain, "N/V"),
    }
    for effect, model in zip(effects, plant.effects, strict=True):
        out |= {f"{effect.name}.{q.name}": (model.values[q.name], q.unit) for q in effect.parameters}
    return out
