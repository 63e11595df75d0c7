"""Broken campaigns through the whole diagnosis: never a wrong name, always a word about what is broken."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import stepid
from broken_campaigns import FRICTION, campaign, changed, jittered, scaled, shifted
from stepid.cli import run
from stepid.errors import UndeterminedError

LEFT_OUT: dict[str, tuple[Callable[[], stepid.Campaign], tuple[str, ...], str]] = {
    "leads": (lambda: shifted(campaign(11), 1, 3), (), r"'case 2'.*3 samples before its input"),
}
SLOW: dict[str, tuple[Callable[[], stepid.Campaign], tuple[str, ...], str]] = {
    "mass": (lambda: campaign(2, true_masses=(0, 0.5, 2.0, 2.0)), (), r"'case 3'.*With 2 kg added instead of 1.5 kg"),
    "scale": (lambda: scaled(campaign(10), 1, 1.3), (), r"'case 2'.*1\.3 times"),
    "sign": (lambda: scaled(campaign(6), 1, -1.0), (), r"'case 2'.*With its sign turned"),
    "mass, friction": (
        lambda: campaign(3, FRICTION, true_masses=(0, 0.6, 1.5, 2.0)),
        ("coulomb_friction",),
        r"'case 2'.*With 0\.(60|59[5-9])\d* kg added instead of 0.5 kg",
    ),
    "spring, friction": (
        lambda: campaign(5, FRICTION, true_springs=["medium", "medium", "stiff", "medium"]),
        ("coulomb_friction",),
        r"'case 3'.*With a stiffness of 39\d.*wrong spring label",
    ),
    "sign, friction": (
        lambda: scaled(campaign(7, FRICTION), 2, -1.0),
        ("coulomb_friction",),
        r"'case 3'.*With its sign turned",
    ),
    "half, friction": (
        lambda: scaled(campaign(9, FRICTION), 3, 0.5),
        ("coulomb_friction",),
        r"'case 4'.*readings are 0\.5 times",
    ),
}


def leaves_out(make: Callable[[], stepid.Campaign], effects: tuple[str, ...], said: str) -> None:
    whole = make()
    found = stepid.diagnose(whole)
    assert found.effects == effects
    assert found.verdict == ("named" if effects else "adequate")
    assert re.search(said + r".*It is left out of this diagnosis", found.notes[0]), found.notes
    assert len(found.runs) == len(whole.experiments) - 1
    assert found.data == whole
    assert found.notes[0] in found.summary()


@pytest.mark.parametrize("kind", LEFT_OUT)
def test_a_run_with_a_plain_mistake_is_left_out(kind: str) -> None:
    leaves_out(*LEFT_OUT[kind])


@pytest.mark.slow
@pytest.mark.parametrize("kind", SLOW)
def test_a_run_with_a_plain_mistake_is_left_out_beside_friction(kind: str) -> None:
    leaves_out(*SLOW[kind])


@pytest.mark.slow
def test_every_input_out_of_step_gives_no_name_but_a_delay() -> None:
    found = stepid.diagnose(jittered(campaign(13), (2, -2, 1, -1)))
    assert found.verdict == "unexplained" or set(found.effects) <= {"input_delay"}


def test_one_run_at_rest_is_left_out_by_name() -> None:
    whole = campaign(21)
    found = stepid.diagnose(changed(whole, 2, position=0.0 * whole.experiments[2].position))
    assert found.verdict == "adequate"
    assert [r.name for r in found.runs] == ["case 1", "case 2", "case 4"]
    assert "Run 'case 3' is left out: nothing moves in it although 0.5 V is commanded" in found.summary()


def test_one_usable_run_is_not_diagnosed() -> None:
    whole = campaign(22)
    same = tuple(changed(whole, 0, name=name).experiments[0] for name in ("a", "b", "c"))
    with pytest.raises(UndeterminedError, match=r"has one usable run.*'a', 'b', 'c' hold the same record"):
        stepid.diagnose(stepid.Campaign(name="copies", experiments=same))


def test_repeats_that_differ_set_no_floor() -> None:
    whole = scaled(campaign(23, masses=(0, 0, 1.5, 1.5), volts=(0.5,) * 4), 1, -1.0)
    found = stepid.fit(whole)
    assert found.noise < 2e-5
    assert re.search(r"'case 1', 'case 2' have the same labels and input but differ by 141 %", found.notes[0])
    assert re.search(r"'case 2' disagrees.*With its sign turned", found.notes[1])


def test_the_command_line_says_it_too(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    whole = campaign(21)
    one = changed(whole, 2, position=0.0 * whole.experiments[2].position)
    manifest = stepid.write_campaign(one, tmp_path / "one")
    assert run(["diagnose", str(manifest)]) == 0
    assert "Run 'case 3' is left out" in capsys.readouterr().out
    still = one
    for i in range(4):
        still = changed(still, i, position=0.0 * whole.experiments[i].position)
    manifest = stepid.write_campaign(still, tmp_path / "still")
    assert run(["diagnose", str(manifest)]) == 2
    err = capsys.readouterr().err
    assert "no run can be used" in err
    assert "drive was on" in err


REAL = os.environ.get("STEPID_REAL_DATA")


@pytest.mark.skipif(REAL is None, reason="STEPID_REAL_DATA does not name the folder of real recordings")
def test_a_real_amplifier_that_was_off_at_first() -> None:
    from stepid.fitting.screening import screen

    root = Path(REAL or "") / "ecp210-milan" / "steps"
    runs = [
        stepid.read_table(
            sorted(folder.glob("data*.txt")),
            input=0,
            position=2,
            position_scale=-1 / 56000,
            counts_per_meter=-56000.0,
            sample_time=0.005,
            name=folder.name,
            added_mass=0.986 if "2mass" in folder.name else 0.0,
            spring="medium",
            damper="motor",
        )
        for folder in sorted(root.glob("steps_kmed_*"))
    ]
    screened = screen(stepid.Campaign(name="medium", experiments=tuple(runs)))
    assert screened.campaign["steps_kmed_nomass"].time[0] == pytest.approx(971 * 0.005, abs=0.05)
    assert screened.campaign["steps_kmed_2mass"].input_before == 3.0
    assert len(screened.notes) == 2
    found = stepid.fit(stepid.Campaign(name="medium", experiments=tuple(runs)))
    assert found.rms < 1e-3
    assert np.all([rms < 1e-3 for rms in found.run_rms.values()])


def test_milliseconds_taken_for_seconds_are_suspected() -> None:
    whole = campaign(2)
    slow = [stepid.Experiment(**(e.model_dump() | {"time": 1000.0 * e.time})) for e in whole.experiments]
    found = stepid.diagnose(whole.model_copy(update={"experiments": tuple(slow)}))
    assert any("if the times are milliseconds, give time_scale = 0.001" in note for note in found.notes), found.notes
    assert not any("milliseconds" in note for note in stepid.diagnose(whole).notes)
