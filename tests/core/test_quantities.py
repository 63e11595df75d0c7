"""A plant's own words and units: translated whole, once, and leaving names alone."""

from __future__ import annotations

import ast
from pathlib import Path

import numpy as np
import pytest

import stepid
from stepid.core.latex import unit as latex_unit
from stepid.core.quantities import CART, Quantities, middle_dot, quantities_of
from stepid.effects import CATALOGUE
from stepid.errors import InputError

TURNED = Quantities("rotation", "A")
ALL = [Quantities("rotation", u) for u in ("V", "A", "N·m")] + [Quantities("translation", u) for u in ("A", "N", "N·m")]
SOURCE = Path(stepid.__file__).parent
TEXTS = sorted(
    {
        node.value
        for file in SOURCE.rglob("*.py")
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
    }
)


@pytest.mark.parametrize(
    ("of_a_cart", "of_a_disk"),
    [
        ("kg", "kg·m²"),
        ("m", "rad"),
        ("mm", "mrad"),
        ("µm", "µrad"),
        ("N", "N·m"),
        ("N/m", "N·m/rad"),
        ("N·s/m", "N·m·s/rad"),
        ("N/V", "N·m/A"),
        ("m/V", "rad/A"),
        ("N·s²/m²", "N·m·s²/rad²"),
        ("N·(s/m)^p", "N·m·(s/rad)^p"),
        ("1/m", "1/rad"),
        ("µm/s", "µrad/s"),
        ("V/s", "A/s"),
        ("mV", "mA"),
        ("rad/s", "rad/s"),
        ("s", "s"),
        ("", ""),
    ],
)
def test_units(of_a_cart: str, of_a_disk: str) -> None:
    assert TURNED.unit(of_a_cart) == of_a_disk
    if of_a_cart:
        assert TURNED.text(f"[{of_a_cart}], 3.4 {of_a_cart}.") == f"[{of_a_disk}], 3.4 {of_a_disk}."
    assert TURNED.unit(of_a_disk) == of_a_disk


def test_a_torque_below_the_line_is_in_brackets() -> None:
    assert Quantities("rotation", "N·m").unit("m/V") == "rad/(N·m)"
    assert latex_unit("rad/(N·m)") == r"\unit{\radian\per\newton\per\meter}"
    assert latex_unit("mrad") == r"\unit{\milli\radian}"


def test_every_unit_of_every_effect_is_one_of_a_rotation() -> None:
    units = {TURNED.unit(parameter.unit) for effect in CATALOGUE for parameter in effect.parameters}
    atoms = {atom for unit in units for atom in unit.replace("N·m", "").replace("kg·m²", "").split("/")}
    assert not atoms & {"m", "kg", "N", "V"}
    for effect in CATALOGUE:
        advice = TURNED.text(effect.advice)
        assert not {"cart", "rail", "rails", "mass", "force", "position"} & set(advice.replace(",", " ").split())


@pytest.mark.parametrize("own", ALL, ids=lambda q: f"{q.motion}, {q.input_unit}")
def test_twice_is_as_good_as_once(own: Quantities) -> None:
    changed = 0
    for text in TEXTS:
        once = own.text(text)
        assert own.text(once) == once
        changed += once != text
    assert changed > 10


@pytest.mark.parametrize(
    ("of_a_cart", "of_a_disk"),
    [
        ("A mass of 0.5 kg was added.", "An inertia of 0.5 kg·m² was added."),
        ("Positions in meters; the force gain.", "Angles in radians; the torque gain."),
        ("base_mass, force_gain, position_scale, position = 1", "base_mass, force_gain, position_scale, position = 1"),
        ("masses: needs two", "masses: needs two"),
        ("column 'mass' of m.csv in lab/cart.txt", "column 'mass' of m.csv in lab/cart.txt"),
        ("m·ω_d² − k and m[case 4]", "J·ω_d² − k and J[case 4]"),
        ("+V gives falling counts; how many volts", "+A gives falling counts; how many amperes"),
        ("a mass-spring-damper plant", "a torsional plant"),
    ],
)
def test_words(of_a_cart: str, of_a_disk: str) -> None:
    assert TURNED.text(of_a_cart) == of_a_disk
    assert CART.text(of_a_cart) == of_a_cart


def test_pages_keep_their_tags() -> None:
    page = '<p style="position: fixed" title="a mass"><b>mass</b> 2&nbsp;kg</p><script>let mass = "5 kg";</script>'
    told = '<p style="position: fixed" title="an inertia"><b>inertia</b> 2&nbsp;kg·m²</p>'
    assert TURNED.html(page) == told + '<script>let mass = "5 kg";</script>'
    assert CART.html(page) == page


def test_formulas() -> None:
    assert TURNED.formula(r"-k_3\, x^3 + \max(m v)") == r"-k_3\, \theta^3 + \max(J \omega)"
    assert Quantities("translation", "A").formula("x") == "x"


def made(**fields: object) -> stepid.Campaign:
    t = np.arange(40) * 0.01
    runs = [
        stepid.Experiment(
            name=name, time=t, position=0.01 * t, input=np.ones(40), added_mass=m, spring="s", damper="5 kg oil"
        )
        for name, m in (("cart 1", 0.0), ("cart 2", 0.5))
    ]
    return stepid.Campaign(name="mass lab", experiments=runs, **fields)


def test_names_are_no_words() -> None:
    said = made(motion="rotation").summary()
    for name in ("cart 1", "mass lab", "5 kg oil"):
        assert name in said
    for word in ("added inertia [kg·m²]", "travel [mrad]", "disk"):
        assert word in said


def test_runs_of_a_rotation_know_it_and_the_caller_s_own_do_not() -> None:
    cart = made()
    disk = stepid.Campaign(name="turned", experiments=cart.experiments, motion="rotation", input_unit="A")
    assert quantities_of(disk[0]).motion == "rotation"
    assert quantities_of(disk[0].slice(0, 20)).input_unit == "A"
    assert quantities_of(cart[0]) == CART
    assert disk[0] == cart[0]
    assert quantities_of(disk[:1]).motion == "rotation"
    with pytest.raises(InputError, match="differ in motion"):
        disk + stepid.Campaign(name="more", experiments=cart.experiments, input_unit="A")


@pytest.mark.parametrize("typed", ["N·m", "Nm", "N m", "N*m"])
def test_torques_as_they_are_typed(typed: str) -> None:
    assert made(motion="rotation", input_unit=typed).input_unit == "N·m"
    assert middle_dot(typed) == "N·m"


@pytest.mark.parametrize(
    ("fields", "said"),
    [
        ({"motion": "turning"}, "motion: Input should be 'translation' or 'rotation'"),
        ({"motion": None}, "motion"),
        ({"input_unit": "kV"}, "input_unit: Input should be 'V', 'A', 'N' or 'N·m'"),
        ({"input_unit": 3}, "input_unit"),
        ({"motion": "rotation", "input_unit": "N"}, "give the torque, force times lever arm, in N·m"),
    ],
)
def test_what_is_no_motion_and_no_unit(fields: dict[str, object], said: str) -> None:
    with pytest.raises(InputError) as refused:
        made(**fields)
    assert said in str(refused.value)


def test_campaigns_round_trip() -> None:
    disk = made(motion="rotation", input_unit="A")
    assert stepid.Campaign.model_validate_json(disk.model_dump_json()) == disk
    again = stepid.Campaign.from_dataframe(disk.to_dataframe(), name="mass lab", motion="rotation", input_unit="A")
    assert again == disk
    assert disk != made()


def test_manifests_round_trip(tmp_path: Path) -> None:
    disk = made(motion="rotation", input_unit="N·m")
    manifest = stepid.write_campaign(disk, tmp_path)
    assert 'motion = "rotation"\ninput_unit = "N·m"\n' in manifest.read_text(encoding="utf-8")
    assert stepid.read_campaign(tmp_path) == disk
    cart = stepid.write_campaign(made(), tmp_path / "cart").read_text(encoding="utf-8")
    assert "motion" not in cart
    assert "input_unit" not in cart


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('motion = "rotation"', 'motion = "turning"', 'It must be "translation" (the default) or "rotation"'),
        ('input_unit = "A"', 'input_unit = "kA"', 'It must be "V" (the default), "A", "N" or "N·m"'),
        ('input_unit = "A"', "input_unit = 1", 'It must be "V"'),
        ('motion = "rotation"', 'motio = "rotation"', "Did you mean 'motion'?"),
        ("added_mass = 0.5", "added_mass = -0.5", "the inertia in kg·m² that was added"),
        ('position = "position"', 'position = "position"\nposition_scale = 1e9', "rad, which is no plant's travel"),
        ('spring = "s"', 'spring = "s"\nmotion = "rotation"', "'motion' is a key of the campaign"),
    ],
)
def test_mistakes_in_manifests(tmp_path: Path, old: str, new: str, said: str) -> None:
    manifest = stepid.write_campaign(made(motion="rotation", input_unit="A"), tmp_path)
    text = manifest.read_text(encoding="utf-8")
    assert old in text
    manifest.write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(InputError) as refused:
        stepid.read_campaign(tmp_path)
    assert said in str(refused.value)


def test_the_equation_of_motion_of_a_disk() -> None:
    law = "(m₀ + added mass) a = K_f u − c v − k x − F_c sign(v)"
    turned = "(J₀ + added inertia) α = K_T u − c ω − k θ − T_c sign(ω)"
    disk = Quantities("rotation", "V")
    assert disk.law(law) == disk.law(turned) == turned
    assert CART.law(law) == law
