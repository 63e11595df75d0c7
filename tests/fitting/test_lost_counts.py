"""Readings that jump and stay so: found where and as large as they are; drifts, laws and wrong labels are none."""

from __future__ import annotations

import numpy as np
import pytest

import stepid
from broken_campaigns import COUNTS, FRICTION, SAMPLE_TIME, campaign, changed, scaled
from stepid.effects import resolve
from stepid.fitting.fit import fit_effects, prepare
from stepid.fitting.lost_counts import Jump, find_jump

BENT = {"cubic_stiffness": {"coefficient": 4e5}}
SIX = (0.0, 0.5, 1.5, 2.0, 1.0, 0.25)


def jumped(whole: stepid.Campaign, run: int, sample: int, counts: float) -> stepid.Campaign:
    position = whole.experiments[run].position.copy()
    position[sample:] += counts / COUNTS
    return changed(whole, run, position=position)


def found_in(whole: stepid.Campaign, *effects: str) -> Jump | None:
    context = prepare(whole)
    optimum = fit_effects(context, resolve(tuple(effects)))
    assert optimum is not None
    return find_jump(optimum, context.floor, context.period)


@pytest.mark.parametrize("counts", [-60.0, 25.0])
@pytest.mark.parametrize(("run", "sample"), [(0, 90), (2, 260), (3, 380)])
def test_a_jump_is_found_at_its_sample_and_as_large_as_it_is(run: int, sample: int, counts: float) -> None:
    found = found_in(jumped(campaign(1), run, sample, counts))
    assert found is not None
    assert found.run == f"case {run + 1}"
    assert found.time == pytest.approx(sample * SAMPLE_TIME, abs=1.01 * SAMPLE_TIME)
    assert found.size == pytest.approx(counts / COUNTS, rel=0.15)
    assert f"{abs(counts):.0f} steps of the sensor" in found.fault.words or counts > 0
    assert "stay so" in found.fault.words


def test_it_is_found_beside_an_effect() -> None:
    found = found_in(jumped(campaign(2, FRICTION), 1, 150, 80.0), "coulomb_friction")
    assert found is not None
    assert (found.run, found.fault.kind, found.fault.unit) == ("case 2", "jump", "m")


def test_what_is_taken_out_is_the_jump_alone() -> None:
    plain = campaign(1)
    read = jumped(plain, 1, 200, 40.0)
    found = found_in(read)
    assert found is not None
    mended = found.mended(read)
    assert [e.name for e in mended] == [e.name for e in plain]
    off = [np.abs(one.position - true.position).max() for one, true in zip(mended, plain, strict=True)]
    assert np.array(off)[[0, 2, 3]].tolist() == [0.0, 0.0, 0.0]
    assert np.median(np.abs(mended.experiments[1].position - plain.experiments[1].position)) < 5 / COUNTS


@pytest.mark.parametrize("seed", range(4))
def test_noise_jumps_nowhere(seed: int) -> None:
    assert found_in(campaign(seed)) is None


@pytest.mark.parametrize(
    "whole",
    [
        campaign(1, FRICTION),
        campaign(1, BENT),
        campaign(1, {"free_play": {"gap": 1e-3}}),
        campaign(1, masses=SIX, true_masses=(0, 0.5, 2.0, 2.0, 1.0, 0.25)),
        scaled(campaign(1), 2, 1.3),
    ],
    ids=["friction", "bent", "play", "mass", "gain"],
)
def test_laws_and_wrong_labels_are_no_jump(whole: stepid.Campaign) -> None:
    assert found_in(whole) is None


def test_a_drift_is_no_jump() -> None:
    whole = campaign(1)
    drifting = whole.experiments[2]
    assert found_in(changed(whole, 2, position=drifting.position + 1e-4 * drifting.time)) is None


@pytest.mark.slow
def test_a_diagnosis_goes_on_without_the_run() -> None:
    read = jumped(campaign(3, FRICTION, masses=SIX), 1, 150, 90.0)
    found = stepid.diagnose(read)
    assert found.effects == ("coulomb_friction",)
    assert [(f.run, f.kind) for f in found.faults] == [("case 2", "jump")]
    assert found.data == read


@pytest.mark.slow
def test_a_jump_in_a_run_that_no_other_is_like_is_taken_out(monkeypatch: pytest.MonkeyPatch) -> None:
    """No run can be left out then."""
    read = jumped(campaign(3, springs=["medium", "medium", "stiff", "stiff"]), 1, 150, 40.0)
    for i, damper in enumerate(("half", "full", "half", "none")):
        read = changed(read, i, damper=damper)
    found = stepid.diagnose(read)
    assert (found.verdict, [(f.run, f.kind) for f in found.faults]) == ("adequate", [("case 2", "jump")])
    assert len(found.runs) == len(read)
    monkeypatch.setattr("stepid.diagnosis.diagnose.wrong_readings", lambda *_: ())
    assert stepid.diagnose(read).verdict == "unexplained"
