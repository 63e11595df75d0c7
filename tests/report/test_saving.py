"""Saved results: equal when loaded, now and in later versions, with what they come from; whatever is wrong is said."""

from __future__ import annotations

import inspect
import json
import pickle
import random
import typing
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

import stepid
from stepid.core.base import Model
from stepid.core.saving import SCHEMA, checksum
from stepid.errors import InputError
from stepid.report import saved

GOLDEN = Path(__file__).resolve().parents[1] / "golden"
VERSIONS = sorted(GOLDEN.glob("saved-*"))  # made by tests/saved_example.py and kept for good
FILES = [path for version in VERSIONS for path in sorted(version.iterdir())]
ESTIMATE = stepid.Estimate(value=1.5, uncertainty=0.25, unit="N/m")


def rewritten(path: Path, **changes: object) -> Path:
    """Change what a saved file says, and have its own hash agree."""
    document = json.loads(path.read_text(encoding="utf-8")) | changes
    document["sha256"] = checksum(document)
    path.write_text(json.dumps(document), encoding="utf-8")
    return path


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return ESTIMATE.save(tmp_path / "estimate.json")


def label(path: Path) -> str:
    return f"{path.parent.name}/{path.stem}"


def example(name: str) -> Model:
    return stepid.load(VERSIONS[-1] / f"{name}.json")


@pytest.mark.parametrize("kept", FILES, ids=label)
def test_what_is_loaded_equals_what_was_saved(kept: Path, tmp_path: Path) -> None:
    result = stepid.load(kept)
    path = result.save(tmp_path / kept.name)
    again = stepid.load(path)
    assert type(again) is type(result)
    assert again == result
    assert again.provenance == result.provenance
    assert stepid.load(again.save(path), kind=type(result)) == result
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


def assert_holds(now: object, then: object) -> None:
    """All that the file says is there; what has been added since has its default."""
    if isinstance(then, dict):
        assert isinstance(now, dict)
        for key, value in then.items():
            assert_holds(now[key], value)
    elif isinstance(then, list):
        assert isinstance(now, list)
        assert len(now) == len(then)
        for one, other in zip(now, then, strict=True):
            assert_holds(one, other)
    else:
        assert now == then


@pytest.mark.parametrize("path", FILES, ids=label)
def test_files_of_every_version_load(path: Path) -> None:
    document = json.loads(path.read_text(encoding="utf-8"))
    again = stepid.load(path)
    assert type(again).__name__ == document["kind"]
    assert_holds(again.to_dict(), document["result"])
    if document["provenance"] is not None:
        assert again.provenance is not None
        assert again.provenance.function == document["provenance"]["function"]
        assert len(again.provenance.sources) == len(document["provenance"]["sources"])


def test_files_of_this_schema_are_kept() -> None:
    schemas = {json.loads(p.read_text(encoding="utf-8"))["schema"] for p in FILES}
    assert schemas == set(range(1, SCHEMA + 1))


def models_in(annotation: object) -> set[type[Model]]:
    if inspect.isclass(annotation):
        return {annotation} if issubclass(annotation, Model) else set()
    return {kind for argument in typing.get_args(annotation) for kind in models_in(argument)}


def test_what_public_functions_return_can_be_loaded() -> None:
    returned: set[type[Model]] = set()
    for room in (stepid, stepid.lab, stepid.datasets):
        for name in getattr(room, "__all__", None) or dir(room):
            function = getattr(room, name)
            if inspect.isfunction(function) and function is not stepid.load:
                names = vars(inspect.getmodule(inspect.unwrap(function)))
                hint = inspect.signature(function).return_annotation
                try:
                    returned |= models_in(eval(hint, names) if isinstance(hint, str) else hint)
                except NameError:  # a name that only type checkers see: another package's
                    continue
    assert {stepid.Diagnosis, stepid.Fit, stepid.Campaign, stepid.Characteristics} <= returned
    assert returned <= set(saved.kinds().values())


def test_lines_are_such_as_editors_take(tmp_path: Path) -> None:
    trend = stepid.Campaign(name="c", experiments=[_long(10_000)])
    lines = trend.save(tmp_path / "c.json").read_text(encoding="utf-8").splitlines()
    assert max(map(len, lines)) < 2000
    assert 600 < len(lines) < 800
    assert stepid.load(tmp_path / "c.json") == trend


def _long(n: int) -> stepid.Experiment:
    t = np.arange(n) * 1e-3
    return stepid.Experiment(
        name="a", time=t, position=np.sin(t), input=0 * t, added_mass=0.0, spring="s", damper="d", starts="motion"
    )


def test_the_parts_of_a_loaded_result_know_where_they_come_from(tmp_path: Path) -> None:
    campaign = example("campaign")
    assert isinstance(campaign, stepid.Campaign)
    again = stepid.load(campaign.save(tmp_path / "c.json"), kind=stepid.Campaign)
    for one, two in zip(campaign.experiments, again.experiments, strict=True):
        assert one.provenance is not None
        assert one.provenance == two.provenance


def test_no_path_of_the_machine_is_saved(tmp_path: Path) -> None:
    campaign = stepid.read_campaign(stepid.write_campaign(example("campaign"), tmp_path / "lab"))  # type: ignore[arg-type]
    text = campaign.save(tmp_path / "c.json").read_text(encoding="utf-8")
    assert str(tmp_path) not in text
    assert '"name": "campaign.toml"' in text


def test_a_class_of_ones_own_is_loaded_when_it_is_named(tmp_path: Path) -> None:
    class Mine(Model):
        value: float

    path = Mine(value=2.0).save(tmp_path / "mine.json")
    with pytest.raises(InputError, match=r"holds a Mine, which this version .* kind="):
        stepid.load(path)
    assert stepid.load(path, kind=Mine) == Mine(value=2.0)


def test_another_kind_is_refused(file: Path) -> None:
    with pytest.raises(InputError, match=r"estimate.json: holds an Estimate, not a Fit"):
        stepid.load(file, kind=stepid.Fit)
    with pytest.raises(InputError, match="is no kind of result"):
        stepid.load(file, kind="Fit")  # type: ignore[type-var]


OTHERS = ("", "[1, 2", '{"verdict": "named"}', "[]", "3", "\0", "time,position\n1,2\n", "[" * 9**5)


@pytest.mark.parametrize("content", OTHERS, ids=lambda content: repr(content[:20]))
def test_other_files_are_refused(tmp_path: Path, content: str) -> None:
    path = tmp_path / "other.json"
    path.write_text(content, encoding="utf-8")
    with pytest.raises(InputError, match=r"other\.json"):
        stepid.load(path)


def test_missing_files_and_folders_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="there is no such file"):
        stepid.load(tmp_path / "none.json")
    with pytest.raises(InputError, match="is a folder"):
        stepid.load(tmp_path)
    with pytest.raises(InputError, match=r"is a folder\. Name a file in it"):
        ESTIMATE.save(tmp_path)
    with pytest.raises(InputError, match="is not a path"):
        ESTIMATE.save(3)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="cannot be written"):
        ESTIMATE.save(tmp_path / ("x" * 300))


def test_a_newer_schema_is_refused(file: Path) -> None:
    with pytest.raises(InputError, match=rf"has schema {SCHEMA + 1}; .*update stepid with pip"):
        stepid.load(rewritten(file, schema=SCHEMA + 1))


def test_what_a_newer_version_added_is_refused_with_the_reason(file: Path) -> None:
    rewritten(file, result=ESTIMATE.to_dict() | {"color": "red"}, versions={"stepid": "99.1.0"})
    with pytest.raises(InputError, match=r"color: Extra .* saved by stepid 99\.1\.0, and this is .*: update stepid"):
        stepid.load(file)
    rewritten(file, versions={"stepid": stepid.__version__})
    with pytest.raises(InputError, match="Save the result again"):
        stepid.load(file)


def test_an_older_schema_is_brought_up_to_date(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def renamed(document: saved.Document) -> saved.Document:
        old = dict(document["result"])
        return document | {"result": old | {"unit": old.pop("in")}}

    rewritten(file, result={"value": 1.5, "uncertainty": 0.25, "in": "N/m"})
    monkeypatch.setattr(saved, "SCHEMA", SCHEMA + 1)
    monkeypatch.setattr(saved, "UPGRADES", {SCHEMA: renamed})
    assert stepid.load(file) == ESTIMATE


@pytest.mark.parametrize(
    "changes",
    [
        {"result": {}},
        {"result": []},
        {"kind": 3},
        {"kind": "StepidError"},
        {"parts": None},
        {"provenance": {"function": 3}},
        {"provenance": []},
        {"versions": {}, "result": {"value": "x"}},
        {"schema": 0},
        {"schema": True},
    ],
    ids=str,
)
def test_files_that_make_no_sense_are_refused(file: Path, changes: dict[str, object]) -> None:
    rewritten(file, **changes)
    with pytest.raises(InputError, match=r"estimate\.json") as caught:
        stepid.load(file)
    assert caught.value.remedy


def test_damage_is_found(tmp_path: Path) -> None:
    result = example("fit")
    path = result.save(tmp_path / "fit.json")
    whole = path.read_bytes()
    draw = random.Random(5)
    for _ in range(60):
        raw = bytearray(whole)
        place = draw.randrange(len(raw))
        if draw.random() < 0.5:
            raw[place] ^= 1 << draw.randrange(8)
        else:
            del raw[place : place + draw.choice([1, 10, len(raw)])]
        path.write_bytes(raw)
        with suppress(InputError):  # nothing but stepid's own error
            assert stepid.load(path) == result
            assert json.loads(bytes(raw)) == json.loads(whole)  # a blank that says nothing


def test_pickles_keep_what_a_result_comes_from() -> None:
    found = example("parameters")
    assert found.provenance is not None
    assert pickle.loads(pickle.dumps(found)).provenance == found.provenance
