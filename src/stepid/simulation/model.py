"""The plant model: a linear mass-spring-damper plus named effects, with where each run began."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pydantic import SerializerFunctionWrapHandler, model_serializer

from stepid.core.base import Finite, Label, Model
from stepid.core.field_units import field_unit
from stepid.core.takes import a
from stepid.effects import CATALOGUE

_DEVIATIONS = {"start_time": "s", "added_mass": "kg"}  # the others are relative


class EffectModel(Model):
    """One effect with its parameter values; see `stepid.effects.CATALOGUE`.

    Parameters
    ----------
    name : str
        Canonical name.
    values : mapping
        Parameter name to value, SI units.
    """

    name: Label
    values: Mapping[str, Finite]

    def _unit(self, field: str, key: str = "") -> str:
        return parameter_unit(f"{self.name}.{key}") if field == "values" else ""


class RunState(Model):
    """What belongs to one run alone.

    Parameters
    ----------
    rest : float
        m, reading of the spring's rest position.
    displacement : float
        m, from the rest position at the first sample (friction holds the cart off it; a release begins off it).
    velocity : float
        m/s at the first sample, zero unless the record starts in motion.
    phases : mapping
        The effects' parameters that are the run's own, for example ``"periodic_disturbance.phase"`` [rad].
    states : mapping
        Where a record starts in motion: how far the effects' own states are from those of a plant at rest there, for
        example ``"flexible_coupling.1"`` [m].
    deviations : mapping
        By how much the run differs from the plant, where it does: ``"start_time"`` [s] (later), ``"gain"``,
        ``"damping"``, ``"friction"``, ``"stiffness"`` (relative), ``"added_mass"`` [kg].
    """

    rest: Finite = 0.0
    displacement: Finite = 0.0
    velocity: Finite = 0.0
    phases: Mapping[str, Finite] = {}
    states: Mapping[str, Finite] = {}
    deviations: Mapping[str, Finite] = {}

    def _unit(self, field: str, key: str = "") -> str:
        if field in ("phases", "deviations"):
            return _DEVIATIONS.get(key, "") if field == "deviations" else parameter_unit(key)
        return super()._unit(field, key)

    @model_serializer(mode="wrap")
    def _without_empty(self, serialize: SerializerFunctionWrapHandler) -> dict[str, Any]:
        out: dict[str, Any] = serialize(self)
        if not self.deviations:
            out.pop("deviations", None)
        return out


class PlantModel(Model):
    """m x″ + c x′ + k x = K_f u plus effects.

    Parameters
    ----------
    base_mass, stiffness, damping : mapping
        By label: kg, N/m, N·s/m.
    force_gain : float
        N/V.
    effects : tuple of EffectModel
    runs : mapping
        Run name to `RunState`.
    """

    base_mass: Mapping[str, Finite]
    stiffness: Mapping[str, Finite]
    damping: Mapping[str, Finite]
    force_gain: Finite
    effects: tuple[EffectModel, ...] = ()
    runs: Mapping[str, RunState] = {}


def parameter_unit(name: str) -> str:
    """Return the unit of a parameter by its full name; empty where it is a pure number, or of no known effect.

    Parameters
    ----------
    name : str
        As `stepid.fit` has it: ``"stiffness[medium]"``, ``"coulomb_friction.level"``.
    """
    effect, _, own = name.partition(".")
    units = {q.name: q.unit for e in CATALOGUE if e.name == effect for q in (*e.parameters, *e.run_parameters)}
    return units.get(own, "") if own in units else field_unit("", name.partition("[")[0])


a_model = a(PlantModel, "a PlantModel, as fit.model or diagnosis.model")
"""Check of an argument `model`."""
