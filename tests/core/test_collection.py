"""A campaign is a collection of its runs, and a model as before."""

from __future__ import annotations

import json
import pickle
from copy import deepcopy

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib import pyplot as plt

import stepid
from stepid.errors import InputError

TIME = 0.01 * np.arange(40)


def run(name: str, added_mass: float = 0.0, **fields: object) -> stepid.Experiment:
    given = {"spring": "medium", "damper": "off", "time": TIME, "position": np.sin(TIME), "input": np.ones(40)}
    return stepid.Experiment(name=name, added_mass=added_mass, **given | fields)


@pytest.fixture
def c() -> stepid.Campaign:
    return stepid.Campaign(name="lab", experiments=[run("run 1"), run("run 2", 0.5), run("name", 1.0)])


def test_runs_are_counted_visited_and_found(c: stepid.Campaign) -> None:
    assert len(c) == 3
    assert c
    assert list(c) == list(c.experiments)
    assert [one.name for one in reversed(list(c))] == ["name", "run 2", "run 1"]
    assert "run 1" in c
    assert run("run 1") in c
    assert "run 3" not in c
    assert 3 not in c


def test_a_run_is_got_by_its_name_or_its_place(c: stepid.Campaign) -> None:
    assert c["run 2"] is c.experiments[1]
    assert c["name"] is c.experiments[2]  # not the field
    assert c[0] is c.experiments[0]
    assert c[np.int64(-1)] is c.experiments[2]
    for wrong in ("run 3", 3, -4, 1.0, None, True):
        with pytest.raises(InputError, match=r"campaign 'lab' has no run .*'run 1', 'run 2', 'name'"):
            c[wrong]  # type: ignore[call-overload]


def test_slices_and_lists_are_campaigns(c: stepid.Campaign) -> None:
    heavy = c.model_copy(update={"weight_uncertainty": 0.01})
    assert heavy[1:] == stepid.Campaign(name="lab", experiments=c.experiments[1:], weight_uncertainty=0.01)
    assert [one.name for one in c[::-1]] == ["name", "run 2", "run 1"]
    assert [one.name for one in c[["name", "run 1"]]] == ["name", "run 1"]
    assert [one.name for one in c[[1]]] == ["run 2"]
    with pytest.raises(InputError, match="holds no run"):
        c[3:]
    with pytest.raises(InputError, match="used by more than one run"):
        c[["run 1", "run 1"]]


def test_runs_are_added(c: stepid.Campaign) -> None:
    more = c + run("run 4", 2.0)
    assert [one.name for one in more] == ["run 1", "run 2", "name", "run 4"]
    assert c[:1] + c[1:] == c
    rest = [c[1], c[2]]
    assert c[:1] + rest == c
    assert len(c) == 3
    with pytest.raises(InputError, match="used by more than one run"):
        c + c["run 1"]
    with pytest.raises(InputError, match=r"differ in weight_uncertainty: 0\.005 and 0\.01"):
        c + stepid.Campaign(name="other", experiments=[run("b")], weight_uncertainty=0.01)
    for wrong in (3, "run 1", ["run 1"], None):
        with pytest.raises(TypeError):
            c + wrong


def test_json_dict_and_equality_are_as_before(c: stepid.Campaign) -> None:
    fields = {"name": "lab", "experiments": c.experiments, "weight_uncertainty": 0.005}
    assert {key: dict(c)[key] for key in fields} == fields
    assert list(dict(c)) == list(stepid.Campaign.model_fields)
    assert stepid.Campaign(**dict(c)) == c
    assert json.loads(json.dumps({"name": dict(c)["name"]})) == {"name": "lab"}
    assert stepid.Campaign.model_validate_json(c.model_dump_json()) == c
    assert stepid.Campaign.model_validate(c) == c
    assert stepid.Campaign.from_dict(c.to_dict()) == c
    assert c.to_dict().keys() == stepid.Campaign.model_fields.keys()
    assert c.model_dump()["name"] == "lab"
    assert pickle.loads(pickle.dumps(c)) == c == deepcopy(c) == c.model_copy()
    assert hash(c) == hash(deepcopy(c))
    assert c != c[:2]


def test_it_is_shown_as_a_table(c: stepid.Campaign) -> None:
    shown = c + run("free <b>", input=np.zeros(40)) + run("two", input=np.repeat([0.0, 1.0, 0.5, -1.0], 10))
    assert repr(c) == "Campaign('lab', 3 runs: 'run 1', 'run 2', 'name')"
    text = str(shown)
    assert text == shown.summary()
    assert "Campaign 'lab': 5 runs" in text
    rows = {line.split("  ")[0]: line for line in text.splitlines()[3:]}
    assert "0 → 1" in rows["run 1"]
    assert "release" in rows["free <b>"]
    assert "-1 … 1, 3 changes" in rows["two"]
    html = shown._repr_html_()
    assert html.count("<svg") == html.count("</tr>") - 1 == 5
    assert "free &lt;b&gt;" in html
    assert "<b>" not in html


def test_it_draws_itself(c: stepid.Campaign) -> None:
    mpl.use("Agg")
    upper, lower = c.plot()
    assert [line.get_label() for line in upper.get_lines()] == ["run 1", "run 2", "name"]
    assert (upper.get_ylabel(), lower.get_ylabel(), lower.get_xlabel()) == ("position [mm]", "input [V]", "time [s]")
    _, (one, two) = plt.subplots(2)
    assert c.plot(axes=(one, two)) == (one, two)
    plt.close("all")


def test_models_without_words_of_their_own_are_shown_on_a_line_and_as_a_table() -> None:
    assert repr(stepid.Effort()) == "Effort()"
    assert repr(stepid.Estimate(value=1.0, unit="kg")) == "Estimate(value=1.0, unit='kg')"
    one = run("a")
    assert repr(one).startswith("Experiment(name='a', time=<40 numbers>")
    assert len(repr(one)) <= 125
    plant = stepid.PlantModel(base_mass={"cart": 1.0}, stiffness={"soft": 2.0 / 3}, damping={}, force_gain=1.0)
    assert "stiffness [soft]  0.666667" in plant.summary()
    for shown in (one, plant, stepid.Criteria(), stepid.Effort.quick(), stepid.RunState(rest=0.0)):
        assert "\n" not in repr(shown)
        assert len(repr(shown)) <= 125
        assert shown._repr_html_().startswith("<table>")
        assert str(shown) == repr(shown)
