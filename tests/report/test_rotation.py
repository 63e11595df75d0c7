"""The same campaign as a cart that moves and as a disk that turns: the same numbers in other words and units."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import matplotlib as mpl
import matplotlib.pyplot as plt
import pytest
from matplotlib.text import Text

import stepid
from diagnosis_example import campaign
from page_text import Tags, packed
from stepid import plot
from stepid.cli import run
from stepid.core.base import Model
from stepid.core.quantities import quantities_of
from stepid.errors import InputError, StepidError

GUESS = {"base_mass": 0.95, "stiffness": 216.0, "damping": 12.0, "force_gain": 7.8}
OF_A_CART = re.compile(
    r"\bkg\b(?!·m²)|\bmm\b|µm|\bcm\b|N/m|N·s/m|(?<![\w·])N(?![\w·])|(?<![\w·/'])m(?![\w·'])|\bV\b|\bvolts?\b"
    r"|\b(?:carts?|mass|masses|forces?|positions?|displacement|meters?|rails?)\b|\\kilogram}|\\newton}"
)


def cart() -> stepid.Campaign:
    return campaign()


def disk() -> stepid.Campaign:
    return stepid.Campaign(name="cases 4 to 7", experiments=cart().experiments, motion="rotation", input_unit="A")


@cache
def results(*, turned: bool) -> dict[str, Any]:
    """Every result of a campaign, by what it is."""
    c = disk() if turned else cart()
    found = stepid.identify(c)
    read = [stepid.characterize(one) for one in c]
    how = {"motion": "rotation", "input_unit": "A"} if turned else {}
    return {
        "campaign": c,
        "identified": found,
        "difference": found.base_difference("cart", "cart"),
        "system": stepid.assemble(read, c.mass_offsets),
        "solved": stepid.solve(stepid.assemble(read, c.mass_offsets)),
        "verified": stepid.verify(found, c),
        "characteristics": read[0],
        "trends": stepid.find_trends(read),
        "fit": stepid.fit(c, effects="coulomb_friction"),
        "diagnosis": stepid.diagnose(c, effort=stepid.Effort.quick()),
        "plan": stepid.plan(GUESS, noise=2e-5, runs=(2, 4), wanted={"base_mass": 1e-4}, **how),
    }


def leaves(values: Any, key: str = "") -> Iterator[tuple[str, Any]]:
    """What stands at the ends of nested dictionaries and lists, each with its key."""
    if isinstance(values, dict):
        for name, one in values.items():
            yield from leaves(one, name)
    elif isinstance(values, list):
        for one in values:
            yield from leaves(one, key)
    else:
        yield key, values


def numbers(text: str) -> list[str]:
    return re.findall(r"(?<![\w.])\d+(?:\.\d+)?(?:e-?\d+)?(?![\w²])", text)


def speaks(text: str) -> None:
    """Nothing is left of a cart driven in V."""
    said = text.replace("$\\cdot$", "·").replace("$^2$", "²")
    said = re.sub(r"\\kilogram\\meter\\squared|\\newton\\meter", "", said)
    left = OF_A_CART.search(said)
    assert left is None, said[max(left.start() - 60, 0) : left.end() + 60]


def texts(figure: Any) -> str:
    figure.draw_without_rendering()
    return "\n".join(one.get_text() for one in figure.findobj(Text) if one.get_text())


NAMES = (
    "campaign",
    "identified",
    "difference",
    "system",
    "solved",
    "verified",
    "characteristics",
    "trends",
    "fit",
    "diagnosis",
    "plan",
)


@pytest.mark.parametrize("name", NAMES)
def test_the_same_numbers_in_other_words(name: str) -> None:
    one, other = results(turned=False)[name], results(turned=True)[name]
    for of_cart, of_disk in zip(leaves(one.to_dict()), leaves(other.to_dict()), strict=True):
        assert of_cart[0] == of_disk[0]
        if not isinstance(of_cart[1], str):
            assert of_cart == of_disk
    assert numbers(one.summary()) == numbers(other.summary())
    assert OF_A_CART.search(one.summary() + str(one))
    for text in (other.summary(), repr(other), str(other), Tags(other._repr_html_()).text):
        speaks(text)


@pytest.mark.parametrize("name", ["identified", "fit", "diagnosis", "characteristics"])
def test_latex(name: str) -> None:
    one, other = results(turned=False)[name].to_latex(), results(turned=True)[name].to_latex()
    assert re.findall(r"\\num\{[^}]*\}", one) == re.findall(r"\\num\{[^}]*\}", other)
    speaks(other)
    assert one != other


def test_units_of_estimates_and_tables() -> None:
    fit, d = (results(turned=True)[name] for name in ("fit", "diagnosis"))
    units = {name: e.unit for name, e in fit.parameters.items()}
    assert units == {
        "base_mass": "kg·m²",
        "stiffness[medium]": "N·m/rad",
        "damping[1/2 turn]": "N·m·s/rad",
        "force_gain": "N·m/A",
        "coulomb_friction.level": "N·m",
    }
    assert list(fit.to_dataframe()["unit"]) == list(units.values())
    assert {e.unit for e in d.linear_parameters.values()} <= set(units.values())
    assert d.scatter["rest"].unit == "rad"
    assert "kg·m²" in set(results(turned=True)["identified"].to_dataframe()["unit"])
    assert results(turned=True)["difference"].unit == "kg·m²"


@pytest.mark.parametrize("name", NAMES)
def test_results_remember(name: str, tmp_path: Path) -> None:
    found: Model = results(turned=True)[name]
    again = stepid.load(found.save(tmp_path / "result.json"))
    assert again == found
    assert type(found).model_validate_json(found.model_dump_json()) == found
    if name != "difference":  # an Estimate knows its unit only
        assert again.summary() == found.summary()
        assert found.to_dict()["motion"] == "rotation"


def test_columns_of_tables_stay_aligned() -> None:
    for name in ("identified", "verified", "fit", "campaign", "plan", "trends"):
        summary = results(turned=True)[name].summary()
        blocks = [block.splitlines() for block in summary.split("\n\n")]
        for lines in blocks:
            rules = [i for i, line in enumerate(lines) if line and set(line) == {"-", " "}]
            for i in rules:
                ends = [found.end() for found in re.finditer("-+", lines[i])]
                assert len(lines[i - 1]) == ends[-1]
                assert all(len(line) <= ends[-1] for line in lines[i + 1 :])
                assert all(line[end : end + 2].strip() == "" for line in lines[i - 1 :] for end in ends)


@pytest.mark.slow
def test_reports(tmp_path: Path) -> None:
    mpl.use("Agg")
    d = results(turned=True)["diagnosis"]
    page = d.to_html(tmp_path / "report.html").read_text(encoding="utf-8")
    tags = Tags(page)
    speaks(tags.text)
    assert "Diagnosis of a torsional plant" in tags.text
    for _, attributes in tags.tags:
        for key in ("alt", "aria-label", "title"):
            speaks(attributes.get(key) or "")
    said = [value for _, value in leaves(json.loads(packed(page, "pictures"))) if isinstance(value, str)]
    assert "angle [mrad]" in said
    speaks("\n".join(value for value in said if value not in ("v", "h", "x", "y")))
    for file in ("note.md", "lab.md", "lab.tex"):
        write = d.to_markdown if file == "note.md" else d.to_lab_report
        speaks(write(tmp_path / file).read_text(encoding="utf-8").replace("\\_", "_"))
    tex = (tmp_path / "lab.tex").read_text(encoding="utf-8")
    assert r"J\,\ddot \theta + c\,\dot \theta + k\,\theta = K_T\,u" in tex
    assert r"\unit{\kilogram\meter\squared}" in tex


def test_pictures() -> None:
    mpl.use("Agg")
    found = results(turned=True)
    page = plot.diagnosis(found["diagnosis"])
    assert page["velocity"].get_ylabel() == "residual torque [N·m]"
    assert page["position"].get_xlabel() == "angle from rest [mrad]"
    drawn = [
        page["gap"],
        found["campaign"].plot()[0],
        plot.verification_grid(found["verified"])[0, 0],
        plot.verification(found["verified"].runs[0])[0],
        plot.trends(found["trends"])[0, 0],
        plot.gap_runs(found["diagnosis"])[0, 0],
        next(iter(found["plan"].plot().values())),
    ]
    for axes in drawn:
        speaks(texts(axes.figure))
    assert drawn[1].get_ylabel() == "angle [mrad]"
    plt.close("all")


def test_a_caller_s_own_figure_keeps_its_own_words() -> None:
    mpl.use("Agg")
    figure, axes = plt.subplots()
    figure.suptitle("position and force")
    plot.gap_bars(results(turned=True)["diagnosis"], axes=axes)
    assert figure.get_suptitle() == "position and force"
    assert axes.get_ylabel() == "RMS gap [µrad]"
    plt.close(figure)


def test_errors_and_progress() -> None:
    c = disk()
    with pytest.raises(StepidError, match="no inertia") as refused:
        stepid.plan(GUESS, noise=1e-5, masses=(0.0,), motion="rotation")
    speaks(str(refused.value).replace("masses:", ""))
    with pytest.raises(StepidError) as refused:
        stepid.identify(c[["case 4"]])
    speaks(str(refused.value))
    assert "inertia" in str(refused.value)
    stages: list[str] = []
    stepid.diagnose(c[:2], effort=stepid.Effort.quick(), progress=lambda p: stages.append(str(p)))
    assert any("µrad" in stage for stage in stages)
    for stage in stages:
        speaks(stage)


def test_plans_know_the_fit_that_they_start_from() -> None:
    fit = results(turned=True)["fit"]
    plan = stepid.plan(fit.model, noise=2e-5, runs=(2,))
    assert (plan.motion, plan.input_unit) == ("rotation", "A")
    assert quantities_of(fit.model).motion == "rotation"
    with pytest.raises(InputError, match="plan: motion is 'turning'"):
        stepid.plan(GUESS, noise=2e-5, motion="turning")  # type: ignore[arg-type]


@pytest.mark.slow
def test_the_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    mpl.use("Agg")
    manifest = stepid.write_campaign(disk(), tmp_path / "lab")
    for command in ("identify", "diagnose"):
        out = tmp_path / command
        effort = ["--effort", "quick"] if command == "diagnose" else []
        assert run([command, str(manifest), "--out", str(out), *effort]) == 0
        told = capsys.readouterr()
        speaks(told.out.replace(str(tmp_path), ""))
        speaks(told.err.replace(str(tmp_path), ""))
        assert "N·m/rad" in told.out
    argv = "plan -m 0.95 -k 216 -c 12 -g 7.8 --noise 2e-5 --runs 2 --motion rotation --input-unit Nm"
    assert run(argv.split()) == 0
    speaks(capsys.readouterr().out)
