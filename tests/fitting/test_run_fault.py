"""One run that a single deviation sets apart: found with its size, behind effects and scatter, too; else nobody is."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np
import pytest

import stepid
from broken_campaigns import FRICTION, SAMPLE_TIME, campaign, changed, inputs, scaled, shifted
from scattered_campaigns import scattered
from stepid.effects import resolve
from stepid.fitting.fit import prepare
from stepid.fitting.fit_effects import fit_effects
from stepid.fitting.record_fault import RecordFault
from stepid.fitting.run_fault import accuse, find_fault

MASSES = (0.0, 0.5, 1.5, 2.0, 1.0, 0.25)
TWO = {"coulomb_friction": {"level": 0.3}, "free_play": {"gap": 5e-4}}
Make = Callable[[], stepid.Campaign]
FAULTS: dict[str, tuple[Make, str, str, float, str]] = {
    "mass": (lambda: campaign(1, true_masses=(0, 0.5, 2, 2)), "case 3", "added_mass", 0.5, "kg"),
    "spring": (
        lambda: campaign(1, true_springs=["medium"] * 3 + ["stiff"]),
        "case 4",
        "stiffness",
        390.0 - 216.0,
        "N/m",
    ),
    "damper": (lambda: scattered(1, damping=(0, 0, 0.5, 0, 0, 0)), "case 3", "damping", 3.5, "N·s/m"),
    "sign": (lambda: scaled(campaign(1), 1, -1.0), "case 2", "gain", -1.0, ""),
    "scale": (lambda: scaled(campaign(1), 0, 2.0), "case 1", "gain", 2.0, ""),
    "amplifier": (lambda: scaled(campaign(1), 2, 1.3), "case 3", "gain", 1.3, ""),
    "start": (lambda: shifted(campaign(1), 2, -3), "case 3", "start_time", 3 * SAMPLE_TIME, "s"),
}


def found_in(whole: stepid.Campaign, *effects: str) -> RecordFault | None:
    context = prepare(whole)
    optimum = fit_effects(context, resolve(tuple(effects)))
    assert optimum is not None
    return find_fault(optimum, context.floor)


@pytest.mark.parametrize("which", FAULTS)
def test_a_fault_is_found_with_its_size(which: str) -> None:
    make, run, kind, size, unit = FAULTS[which]
    found = found_in(make())
    assert found is not None
    assert (found.run, found.kind, found.unit) == (run, kind, unit)
    assert found.size == pytest.approx(size, rel=0.02)
    assert found.words.startswith(f"Run {run!r} disagrees with the others")


def test_a_wrong_damper_label_names_the_one_that_fits() -> None:
    whole = scattered(2, damping=(0, 0, 0, 0.6, 0.6, 0.6))
    for run in (4, 5):
        whole = changed(whole, run, damper="full")
    found = found_in(whole)
    assert found is not None
    assert re.search(r"that of damper 'full' instead of the 7\S* N·s/m of damper 'half'", found.words)


def test_a_mass_is_found_behind_two_effects() -> None:
    whole = campaign(1, TWO, masses=MASSES, true_masses=(0, 0.5, 1.8, 2.0, 1.0, 0.25))
    found = found_in(whole, *TWO)
    assert found is not None
    assert (found.run, found.kind) == ("case 3", "added_mass")
    assert found.size == pytest.approx(0.3, abs=0.01)


def test_a_scale_is_found_behind_friction() -> None:
    found = found_in(scaled(campaign(1, FRICTION), 1, -1.0), "coulomb_friction")
    assert found is not None
    assert (found.run, found.kind, round(found.size, 2)) == ("case 2", "gain", -1.0)


def test_a_mass_is_found_among_runs_that_scatter() -> None:
    whole = scattered(
        1,
        masses=(0.0, 0.5, 1.8, 2.0, 1.0, 0.25),
        late=(0.3, -0.2, 0.1, 0.4, -0.3, 0.0),
        gain=(0.01, -0.01, 0.0, 0.012, -0.008, 0.0),
    )
    found = found_in(changed(whole, 2, added_mass=1.5))
    assert found is not None
    assert (found.run, found.kind) == ("case 3", "added_mass")
    assert found.size == pytest.approx(0.3, abs=0.04)


@pytest.mark.parametrize("seed", [1, 2, pytest.param(3, marks=pytest.mark.slow)])
def test_scatter_accuses_nobody(seed: int) -> None:
    late, gain, damping, friction = (np.random.default_rng(seed).standard_normal((4, 6)).T * (0.7, 0.02, 0.06, 0.05)).T
    whole = scattered(seed, late=list(late), gain=list(gain), damping=list(damping), friction=list(friction), level=0.1)
    assert found_in(whole) is None


@pytest.mark.parametrize("effects", [{}, FRICTION, {"cubic_stiffness": {"coefficient": 6e4}}, TWO])
def test_a_law_of_the_plant_accuses_nobody(effects: dict[str, dict[str, float]]) -> None:
    assert found_in(campaign(3, effects)) is None
    assert found_in(campaign(3, effects, volts=(0.5, -0.5, 0.5, 0.15))) is None


def test_two_runs_accuse_nobody() -> None:
    assert found_in(campaign(7, masses=(0.0, 1.5), true_masses=(0.0, 1.0))) is None


@pytest.mark.parametrize("noise", [2e-4, 3e-4, 4e-4])
def test_a_fault_that_the_floor_hides_is_found_where_the_rest_has_a_pattern(noise: float) -> None:
    context = prepare(campaign(1, true_masses=(0.05, 0.5, 1.5, 2.0), noise=noise))
    assert context.linear.rms < 1.08 * context.floor
    assert accuse(context.linear, context.floor) is None
    found = accuse(context.linear, context.floor, patterned=True)
    assert found is not None
    assert (found.fault.run, found.fault.kind) == ("case 1", "added_mass")
    assert found.fault.size == pytest.approx(0.05, rel=0.2)


@pytest.mark.parametrize("seed", range(10))
def test_white_noise_accuses_nobody_whatever_is_asked(seed: int) -> None:
    context = prepare(campaign(seed, noise=2e-4))
    assert accuse(context.linear, context.floor, patterned=True) is None


def test_a_run_is_not_accused_of_a_weight_less_than_none() -> None:
    found = found_in(campaign(1, true_masses=(-0.3, 0.5, 1.5, 2.0)))
    assert found is None or (found.run, found.kind) == ("case 1", "stiffness")
    assert found_in(campaign(1, true_masses=(0.3, 0.5, 1.5, 2.0))).kind == "added_mass"  # type: ignore[union-attr]


def curved(volts: tuple[float, ...]) -> stepid.Campaign:
    """A drive that grows weaker by 10 % a volt, steadily."""
    weak = [inputs(v * (1.0 - 0.1 * abs(v))) for v in volts]
    made = campaign(5, masses=MASSES, drives=weak)
    for i, v in enumerate(volts):
        made = changed(made, i, input=inputs(v))
    return made


@pytest.mark.parametrize("last", [1.5, 2.0])
def test_the_only_run_of_its_input_is_not_accused_of_what_a_law_leaves_there(last: float) -> None:
    """A saturation takes what two sizes of input tell; a third size is what refutes it."""
    assert found_in(curved((1, -1, 2, -2, 1, last)), "actuator_saturation") is None


def test_of_two_runs_of_one_input_one_is_accused() -> None:
    """Its readings are off by a share which that of the same input does not know."""
    whole = curved((1, -1, 2, -2, 1, 2))
    found = found_in(scaled(whole, 5, 0.945), "actuator_saturation")
    assert found is not None
    assert (found.run, found.kind) == ("case 6", "gain")
    assert found.size == pytest.approx(0.945, abs=0.005)
