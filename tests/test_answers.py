"""What `stepid.fit` and `stepid.diagnose` say of standing hidden campaigns stays as it is, and takes no more work."""

from __future__ import annotations

from importlib import import_module

import pytest

import counting
import golden_answers as golden
import stepid
from hidden.sets import one

REMEDY = (
    "If the change is meant, write the answers again with `python tests/golden_answers.py`, look at the table that it "
    "prints, and add a line to CHANGELOG.md. Counts of simulated samples and fits may grow by a tenth: for more, say "
    "which campaigns take more, and why."
)
CASES = [*golden.QUICK, *(pytest.param(*case, marks=pytest.mark.slow) for case in golden.SLOW)]


@pytest.mark.parametrize(("which", "number"), CASES)
def test_the_answer_is_the_committed_one(which: str, number: int) -> None:
    key = golden.name(which, number)
    off = list(golden.differences(golden.committed()[key], golden.answer(which, number)))
    assert not off, f"\n{golden.table([(key, *row) for row in off])}\n{REMEDY}"


@pytest.mark.parametrize(("which", "number"), golden.FIT)
def test_the_fit_of_two_effects_is_the_committed_one(which: str, number: int) -> None:
    key = golden.name(which, number)
    campaign, truth = one(which, number)
    campaign = campaign.model_copy(update=golden.EXACT)
    before, after = {"fit": golden.committed()[key]["fit"]}, {"fit": golden.fitted(campaign, truth["effects"])}
    off = list(golden.differences(before, after))
    assert not off, f"\n{golden.table([(key, *row) for row in off])}\n{REMEDY}"


def test_every_campaign_has_its_answer_and_no_other() -> None:
    assert list(golden.committed()) == [golden.name(*case) for case in (*golden.QUICK, *golden.SLOW)]


def test_what_differs_is_told() -> None:
    before = golden.committed()["single 5"]
    said = before["diagnose"]
    mass, spread = said["parameters"]["base_mass"]

    def changed(**fields: object) -> list[str]:
        after = {**before, "diagnose": said | {k.replace("_", " "): v for k, v in fields.items()}}
        return [what for what, _, _ in golden.differences(before, after)]

    assert changed() == []
    assert changed(verdict="adequate", effects=[]) == ["diagnose: verdict", "diagnose: effects"]
    assert changed(samples=int(1.09 * said["samples"]), fits=1) == []
    assert changed(samples=int(1.11 * said["samples"])) == ["diagnose: samples"]
    assert changed(rms_after=1.004 * said["rms after"]) == []
    assert changed(rms_after=1.006 * said["rms after"]) == ["diagnose: rms after"]
    near, far = (mass + share * max(1e-3 * mass, spread / 3) for share in (0.9, 1.1))
    assert changed(parameters=said["parameters"] | {"base_mass": [near, spread]}) == []
    assert changed(parameters=said["parameters"] | {"base_mass": [far, spread]}) == ["diagnose: base_mass"]
    fewer = {key: value for key, value in said["parameters"].items() if key != "base_mass"}
    assert changed(parameters=fewer) == ["diagnose: base_mass"]


def test_the_work_is_counted_and_the_engine_left_as_it_was() -> None:
    simulator = getattr(import_module(counting.SIMULATOR[0]), counting.SIMULATOR[1])
    before = simulator._run
    campaign, _ = one("none", 1)
    with counting.counting() as counts:
        stepid.fit(campaign)
    size = sum(run.time.size for run in campaign.experiments)
    assert counts.fits >= 1
    assert counts.samples >= size
    assert counts.samples % size == 0
    assert simulator._run is before
    again = counts.samples
    stepid.fit(campaign)
    assert counts.samples == again
