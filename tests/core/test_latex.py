"""Tables of parameters in LaTeX: the numbers of the text tables, units that siunitx knows, names that print."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import stepid
from stepid.core.estimate import format_value
from stepid.core.frames import Row, rows_of
from stepid.core.latex import escaped, number, parameter_name, parameter_table, unit

GOLDEN = Path(__file__).resolve().parents[1] / "golden"
KEPT = max(GOLDEN.glob("saved-*"))


@pytest.mark.parametrize("name", ["fit", "diagnosis", "parameters", "characteristics"])
def test_numbers_are_those_of_the_summary(name: str) -> None:
    found = stepid.load(KEPT / f"{name}.json")
    assert isinstance(found, stepid.Fit | stepid.Diagnosis | stepid.IdentifiedParameters | stepid.Characteristics)
    shown = re.findall(r"\\num\{(.*?)\}", found.to_latex())
    assert len(shown) >= 5
    assert all(one.replace("+-", "±") in found.summary() for one in shown)


def test_a_table_with_a_caption_is_a_float() -> None:
    rows = [Row("coulomb_friction.level", 0.3, 0.01, "N"), Row("stiffness[50 % & [a]]", 216.0, None, "N/m")]
    text = parameter_table(rows, caption="Fit #1", label="tab:fit")
    assert text.splitlines()[0] == r"\begin{table}"
    assert r"\caption{Fit \#1}" in text
    assert r"\label{tab:fit}" in text
    assert r"Coulomb friction, level & \num{0.300 +- 0.010} & \unit{\newton} \\" in text
    assert r"stiffness (50 \% \& {[}a{]}) & \num{216} (undetermined) & \unit{\newton\per\meter} \\" in text
    assert text.count("{") == text.count("}")
    assert "undetermined" not in parameter_table([Row("a", 1.0, None, "")])


@pytest.mark.parametrize(
    ("limits", "written"),
    [
        ((4.31e-4, None), r"at least \num{0.43} & \unit{\milli\meter}"),
        ((None, 0.0), r"at most \num{0} & \unit{\meter}"),
    ],
)
def test_a_size_with_one_end_says_so(limits: tuple[float | None, float | None], written: str) -> None:
    gap = stepid.Estimate(value=5e-4, unit="m", limits=limits)
    known = stepid.Estimate(value=216.0, uncertainty=1.4, unit="N/m")
    text = parameter_table(rows_of({"stiffness[medium]": known, "free_play.gap": gap}))
    assert rf"free play, gap & {written} \\" in text
    assert "undetermined" not in text


@pytest.mark.parametrize(
    ("symbol", "written"),
    [
        ("N·s²/m²", r"\unit{\newton\second\squared\per\meter\squared}"),
        ("1/m", r"\unit{\per\meter}"),
        ("kg·m²", r"\unit{\kilogram\meter\squared}"),
        ("N·m/rad", r"\unit{\newton\meter\per\radian}"),
        ("", "--"),
        ("N·(s/m)^p", r"N$\cdot$(s/m)\textasciicircum{}p"),
    ],
)
def test_units(symbol: str, written: str) -> None:
    assert unit(symbol) == written


def test_every_unit_of_the_catalogue_is_written() -> None:
    units = {q.unit for e in stepid.effects.CATALOGUE for q in (*e.parameters, *e.run_parameters)}
    assert {u for u in units if u and not unit(u).startswith(r"\unit{")} <= {"N·(s/m)^p"}


def test_small_and_large_numbers_keep_their_digits() -> None:
    assert format_value(1.23456e-11, 3e-13) == "(1.235 ± 0.030)e-11"
    assert number(1.23456e-11, 3e-13) == r"\num{1.235 +- 0.030 e-11}"
    assert number(-123456789.0, 2e4) == r"\num{-1.23457 +- 0.00020 e8}"
    assert number(0.036, None) == r"\num{0.036}"


def test_text_prints_as_it_is() -> None:
    assert escaped("a_b\\c{ } ~ ω_d² 5 %\n\n$x$") == (
        r"a\_b\textbackslash{}c\{ \} \textasciitilde{} $\omega_d$$^2$ 5 \% \$x\$"
    )
    assert parameter_name("input_delay.delay") == "input delay"
    assert parameter_name("damping_from_stiffness[case 4]") == "damping from stiffness (case 4)"
