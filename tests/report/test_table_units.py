"""No number of a table stands without its unit: the header has it, a column has it, or the cell."""

from __future__ import annotations

import math
import re

import matplotlib as mpl
import pytest
from matplotlib import pyplot as plt

import diagnosis_example as example
import stepid
from stepid.core.estimate import format_value
from stepid.core.quantities import quantities_of
from stepid.report import provenance
from stepid.report.chapter import Table
from stepid.report.hand import HandMethod, by_hand
from stepid.report.pull import _by_hand, hand_method_rows
from stepid.report.story import tell
from stepid.report.tables import characteristics_table

BARE = re.compile(r"[+−-]?\d[\d.]*( ± [\d.]+)?(e-?\d+)?")
PURE = {"samples", "damping ratio", "final/noise", "version"}
UNIT = re.compile(r" \[[^\]]+\]$")


def bare_columns(table: Table) -> set[str]:
    """Columns with a number whose unit neither the header nor a cell of the row says."""
    units = table.header.index("unit") if "unit" in table.header else None
    found = set()
    for row in table.rows:
        if units is not None and row[units]:
            continue
        for title, cell in zip(table.header[1:], row[1:], strict=True):
            if BARE.fullmatch(cell) and not UNIT.search(title) and title not in PURE:
                found.add(title)
    return found


@pytest.mark.parametrize("motion", ["translation", "rotation"])
def test_every_number_of_a_report_has_a_unit(motion: str) -> None:
    d = example.named()
    hand = by_hand(example.campaign())
    assert isinstance(hand, HandMethod)
    if motion == "rotation":
        disk = quantities_of(example.campaign())._replace(motion=motion)
        d, hand = disk.bear(d), disk.bear(hand)
    tables = [table for chapter in tell(d, hand, provenance.of_data(d)) for table in chapter.tables]
    assert len(tables) >= 10
    assert {table.caption: bare for table in tables if (bare := bare_columns(table))} == {}
    said = " ".join(cell for table in tables for cell in (*table.header, *(c for row in table.rows for c in row)))
    assert ("kg·m²" in said) == ("N·m/rad" in said) == ("µrad" in said) == (motion == "rotation")


@pytest.mark.parametrize(("motion", "unit"), [("translation", "m/V"), ("rotation", "rad/V")])
def test_the_static_gain_is_one_number_in_one_unit_everywhere(motion: str, unit: str) -> None:
    mpl.use("Agg")
    campaign = example.campaign().model_copy(update={"motion": motion})
    hand = by_hand(campaign)
    assert isinstance(hand, HandMethod)
    told = quantities_of(campaign).result(characteristics_table(hand.system), words=True)
    title = f"static gain [{unit}]"
    in_report = {row[0]: row[told.header.index(title)] for row in told.rows}
    assert set(in_report) == set(example.RUNS)
    summary = hand.found.summary()
    latex = hand.found.to_latex()
    assert title in re.split(r"\s{2,}", summary.splitlines()[1])
    for run in hand.system.characteristics:
        value = in_report[run.name]
        assert float(value.split(" ± ")[0]) == pytest.approx(hand.found.static_gain[run.name], rel=1e-3)
        assert re.search(rf"^{run.name} .*  {re.escape(value)}$", summary, re.MULTILINE)
        assert re.search(rf"^static gain +{re.escape(value)} +{unit}$", run.summary(), re.MULTILINE)
        assert rf"static gain ({run.name}) & \num{{{value.replace('±', '+-')}}} & \unit{{" in latex
    drawn = stepid.plot.trend(stepid.find_trends(hand.system.characteristics).trends[0])
    assert title in [axes.get_ylabel() for axes in drawn]
    plt.close("all")


def test_a_number_without_a_unit_is_seen() -> None:
    table = Table(caption="made up", header=("run", "mass", "rms [m]"), rows=(("a", "1.5 ± 0.1", "2"),))
    assert bare_columns(table) == {"mass"}


def test_the_check_of_a_plan_has_units() -> None:
    guess = {"base_mass": 0.95, "stiffness": 216.0, "damping": 12.0, "force_gain": 7.8}
    plan = stepid.plan(
        guess, noise=2e-5, runs=(2,), masses=(0.0, 1.0), levels=(0.5,), sample_times=(0.01,), motion="rotation"
    )
    assert {"added [kg·m²]", "levels [V]", "every [ms]"} <= set(re.split(r"\s{2,}", plan.summary().splitlines()[-3]))
    shown = [line.split() for line in plan.check(10).summary().splitlines()[3:]]
    assert {name: unit for name, _, _, unit, _ in shown} == {
        "base_mass": "kg·m²",
        "stiffness[spring]": "N·m/rad",
        "damping[damper]": "N·m·s/rad",
        "force_gain": "N·m/V",
    }


def test_the_force_gain_by_peaks_is_as_uncertain_as_the_stiffness() -> None:
    """It is the product of both: the scatter of the runs alone says nothing of the stiffness, which they share."""
    hand = by_hand(example.campaign())
    assert isinstance(hand, HandMethod)
    found = hand.found
    told = _by_hand(found, several=False)
    (label,) = found.stiffness
    gain, stiffness = told["force_gain"], told[f"stiffness[{label}]"]
    assert gain.uncertainty is not None
    assert stiffness.uncertainty is not None
    assert gain.uncertainty / gain.value >= stiffness.uncertainty / stiffness.value


def test_the_scale_of_the_positions_makes_the_force_gain_by_peaks_as_uncertain() -> None:
    hand = by_hand(example.campaign())
    assert isinstance(hand, HandMethod)
    plain = _by_hand(hand.found, several=False)
    scaled = _by_hand(hand.found, several=False, scale=0.02)
    gain, other = plain["force_gain"], scaled["force_gain"]
    assert gain.uncertainty is not None
    assert other.uncertainty == pytest.approx(math.hypot(gain.uncertainty, 0.02 * gain.value))
    assert {name: value for name, value in scaled.items() if name != "force_gain"} == {
        name: value for name, value in plain.items() if name != "force_gain"
    }
    d = example.named()
    assert d.data is not None
    wide = d.model_copy(update={"data": d.data.model_copy(update={"scale_uncertainty": 0.02})})
    (told,) = (row for row in hand_method_rows(wide, hand.found)[1] if row[0] == "force_gain")
    assert told[1] == format_value(other.value, other.uncertainty)
