"""Every number in a table of fields has its unit."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Iterator
from typing import get_args

import pytest

import diagnosis_example as example
import stepid
from stepid import lab
from stepid.core.base import Model
from stepid.core.field_units import UNITS
from stepid.simulation.model import parameter_unit

PURE = {  # shares, ratios, counts, χ² and evidence
    "CharacteristicsUncertainty": {"overshoot", "damping_ratio"},
    "Design": {"separation", "misfit"},
    "Draw": {"none"},
    "NoiseColor": {"effective_samples"},
    "Answer": {"visibility"},
    "Ranked": {"evidence", "explained", "probability"},
    "Rig": {"spread"},
    "RunGap": {"explained"},
}
ALL_PURE = {"Criteria", "Effort"}
BY_KEY = {
    "Answer": {"parameters", "attainable"},
    "Design": {"uncertainty", "from_noise", "from_weights"},
    "EffectModel": {"values"},
    "LabTruth": {"parameters"},
    "Ranked": {"parameters"},
    "RunState": {"phases", "states", "deviations"},  # the effects' own states have units of their own
}


def models(of: type[Model] = Model) -> Iterator[type[Model]]:
    for one in of.__subclasses__():
        yield one
        yield from models(one)


def holds_numbers(annotation: object) -> bool:
    return annotation is float or any(map(holds_numbers, get_args(annotation)))


def test_each_field_of_numbers_has_a_unit_or_is_known_to_be_pure() -> None:
    for module in pkgutil.walk_packages(stepid.__path__, "stepid."):
        if not module.name.startswith(("stepid.webapp.views", "stepid.__main__")):
            importlib.import_module(module.name)
    looked_at = set()
    for model in set(models()):
        name, fields = model.__name__, model.model_fields
        if not model.__module__.startswith("stepid.") or "unit" in fields or name in ALL_PURE:
            continue
        if not model.summary.__qualname__.startswith("Model."):
            continue  # has words of its own
        known = PURE.get(name, set()) | BY_KEY.get(name, set())
        numbers = {field for field, info in fields.items() if holds_numbers(info.annotation)}
        assert known <= numbers, name
        assert not {f for f in numbers - known if not (UNITS.get(f) or UNITS.get(f"{name}.{f}"))}, name
        looked_at |= {name} if numbers else set()
    assert {"Experiment", "PlantModel", "Gap", "Rig", "StepInput"} <= looked_at


def table(model: Model) -> dict[str, str]:
    rows = [line.rsplit("  ", 1) for line in model.summary().splitlines()[3:]]
    return {row[0].strip(): row[-1].strip() for row in rows}


def test_numbers_stand_with_their_units() -> None:
    d = example.named()
    shown = table(d.model)
    assert shown["stiffness [medium]"].endswith(" N/m")
    assert shown["force gain"].endswith(" N/V")
    assert table(d.gap)["before"].endswith(" m")
    assert table(lab.Rig())["before"].endswith(" s")
    assert table(stepid.StepInput(level=0.5, start=1.0)) == {"level": "0.5 V", "start": "1.0 s", "end": "None"}
    ranked = d.ranking[0].model_copy(update={"parameters": {"coulomb_friction.level": 0.3}})
    shown = table(ranked)
    assert shown["parameters [coulomb_friction.level]"] == "0.3 N"
    assert shown["rms"].endswith(" m")
    assert float(shown["probability"]) == pytest.approx(ranked.probability)


def test_a_disk_has_the_units_of_a_disk() -> None:
    fields = example.campaign().model_dump() | {"motion": "rotation", "input_unit": "N·m"}
    disk = stepid.Campaign(**{**fields, "experiments": example.campaign().experiments})
    shown = table(stepid.fit(disk[:2]).model)
    assert shown["stiffness [medium]"].endswith(" N·m/rad")
    assert next(value for name, value in shown.items() if name.startswith("base")).endswith(" kg·m²")


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("base_mass", "kg"),
        ("stiffness[medium]", "N/m"),
        ("coulomb_friction.level", "N"),
        ("input_delay.delay", "s"),
        ("power_damping.power", ""),
        ("no_such_effect.level", ""),
    ],
)
def test_units_of_parameters(name: str, unit: str) -> None:
    assert parameter_unit(name) == unit
