"""What names of files and the lines above a table tell of a run."""

from __future__ import annotations

import pytest

from stepid.io.guess.file_names import mass_above, read_name, sample_time_above


@pytest.mark.parametrize(
    ("name", "mass", "weights"),
    [
        ("2mass", None, 2),
        ("no_mass", 0.0, 0),
        ("0.5kg", 0.5, None),
        ("soft_1,5kg_2", 1.5, None),
        ("0p5kg", 0.5, None),
        ("run2_500g", 0.5, None),
        ("case_5", None, None),
        ("three weights", None, 3),
        ("20210305_run1", None, None),
        ("unloaded", 0.0, 0),
        ("0x500g", 0.0, None),
        ("2x500g", 1.0, None),
        ("3 x 0.5 kg", 1.5, None),
        ("run_2*0,5kg", 1.0, None),
        ("cart+0.5kg", 0.5, None),
        ("1mass_0.5kg", 0.5, None),
        ("500g+500g", None, None),
        ("0.5+1kg", None, None),
        ("step_0.5kg_+1.0V", 0.5, None),
        ("0.5kg +0.8 volts", 0.5, None),
        ("0.5 x 2kg", None, None),
        ("1 kg 500 g", None, None),
        ("group 3 g 500g", None, None),
        ("2mass_0.5kg", None, None),
        ("1+2mass", None, None),
    ],
)
def test_masses_in_names(name: str, mass: float | None, weights: int | None) -> None:
    assert (read_name(name).mass, read_name(name).weights) == (mass, weights)


def test_springs_dampers_and_releases_in_names() -> None:
    said = read_name("stiff_spring_half-turn_free_release")
    assert (said.spring, said.damper, said.release) == ("stiff", "half turn", True)
    assert read_name("softball_freezer").spring is None


def test_masses_above_the_rows() -> None:
    assert mass_above(("Lab 3", "Zusatzmasse: 0,5 kg")) == 0.5
    assert mass_above(("mass = 500 g", "mass: 1 kg")) is None


@pytest.mark.parametrize(
    ("line", "mass"),
    [
        ("Cart mass: 0.77 kg", None),
        ("Total mass = 1.27 kg", None),
        ("Moving mass; 0.77 kg", None),
        ("mass of the cart: 0.77 kg", None),
        ("Proof mass: 0.77 kg", None),
        ("load cell range: 5 kg", None),
        ("added mass: 1,500 g", None),  # or one and a half
        ("Added mass: 1.500 kg", 1.5),
        ("Extra load = 0.500 kg", 0.5),
        ("weight: 500 g", 0.5),
        ("mass in kg: 0.5 kg", 0.5),
        ("Cart mass: 0.77 kg; added mass: 0.5 kg", None),
    ],
)
def test_only_added_masses_are_taken_from_the_lines_above(line: str, mass: float | None) -> None:
    assert mass_above(("Lab 3", line)) == mass


@pytest.mark.parametrize(
    ("line", "period"),
    [
        ("Sample rate: 200 Hz", 0.005),
        ("dt = 10 ms", 0.01),
        ("Abtastzeit 0,02 s", 0.02),
        ("Interval,0.01", None),
        ("Sampling frequency = 1 kHz", 0.001),
        ("sample time: 0.005 s", 0.005),
        ("Sample rate: 200 Hz, filter: 20 Hz", 0.005),
        ("Sample rate: 1,000 Hz", None),  # one, or a thousand
        ("Abtastrate: 1.000 Hz", None),
        ("dt = 8.854 ms", 0.008854),  # 9 s would be none
        ("dt = 1.024 us", None),
        ("Filter frequency: 20 Hz", None),
        ("Low-pass cutoff freq: 50 Hz", None),
        ("Sampled with a low-pass filter of 50 Hz", None),
        ("Square wave generated at 2 Hz", None),
        ("period of the square wave: 2 s", None),
    ],
)
def test_sample_times_above_the_rows(line: str, period: float | None) -> None:
    assert sample_time_above((line,)) == pytest.approx(period)


@pytest.mark.parametrize("name", ["r_0_3kg", "r_0-3kg", "run_2_3kg"])
def test_a_number_that_may_go_on_from_another_is_asked(name: str) -> None:
    """A point is written so where file systems or people do not like it: 0_3kg had been 3 kg."""
    assert read_name(name).mass is None
    assert read_name(f"{name.removesuffix('kg')}.0kg").mass == 3.0
