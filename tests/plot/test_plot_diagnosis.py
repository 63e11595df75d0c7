"""Pictures of a diagnosis: what must be drawn is drawn, with units, and the numbers are those of the diagnosis."""

from __future__ import annotations

from collections.abc import Iterator

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.colors import to_hex

import diagnosis_example as example
from diagnosis_example import changed
from stepid import plot
from stepid.core.words import digits
from stepid.diagnosis.headline import answer
from stepid.diagnosis.result import Diagnosis, Gap
from stepid.diagnosis.wording import per_cent
from stepid.errors import InputError
from stepid.plot.panels import ranked_candidates


@pytest.fixture(autouse=True)
def _no_windows() -> Iterator[None]:
    mpl.use("Agg")
    yield
    plt.close("all")


@pytest.fixture
def axes() -> Axes:
    return plt.subplots()[1]


def test_response_shows_measured_before_and_after(axes: Axes) -> None:
    d = example.named()
    assert plot.gap_response(d, "case 7", axes=axes) is axes
    lines = {line.get_label(): line for line in axes.get_lines()}
    assert list(lines) == ["measured", "linear model", "with the effect added"]
    run = d.runs[3]
    for line, values in zip(lines.values(), (run.measured, run.linear, run.model), strict=True):
        np.testing.assert_allclose(line.get_ydata(), 1e3 * values)
    assert lines["linear model"].get_linestyle() == "--"  # told apart without color, too
    assert axes.get_ylabel() == "position [mm]"
    assert axes.get_title(loc="left") == f"case 7: {1e6 * run.before:.0f} µm → {1e6 * run.after:.1f} µm"


def test_adequate_shows_no_second_model(axes: Axes) -> None:
    plot.gap_response(example.adequate(), "case 7", axes=axes)
    assert [line.get_label() for line in axes.get_lines()] == ["measured", "linear model"]
    assert "→" not in axes.get_title(loc="left")


def test_residuals_share_one_scale_and_show_the_noise() -> None:
    d = example.named()
    _, pair = plt.subplots(2)
    limits = set()
    for name, one in zip(("case 5", "case 7"), pair, strict=True):
        plot.gap_residual(d, name, axes=one)
        limits.add(one.get_ylim())
        before, after = one.get_lines()
        run = next(r for r in d.runs if r.name == name)
        np.testing.assert_allclose(before.get_ydata(), 1e3 * (run.measured - run.linear))
        np.testing.assert_allclose(after.get_ydata(), 1e3 * (run.measured - run.model))
        (band,) = one.patches
        assert band.get_y() == pytest.approx(-2e3 * d.gap.noise)
        assert band.get_height() == pytest.approx(4e3 * d.gap.noise)
        assert one.get_ylabel() == "residual [mm]"
    assert len(limits) == 1
    largest = max(float(np.abs(r.measured - r.linear).max()) for r in d.runs)
    assert limits.pop()[1] == pytest.approx(1.05e3 * largest)


def test_residual_in_micrometers_where_small(axes: Axes) -> None:
    plot.gap_residual(example.named(), "case 4", axes=axes, largest=2e-4)
    assert axes.get_ylabel() == "residual [µm]"
    assert axes.get_ylim()[1] == pytest.approx(210)


def test_unknown_run_is_refused(axes: Axes) -> None:
    with pytest.raises(InputError, match=r"no run 'case 9'.*'case 4'"):
        plot.gap_response(example.named(), "case 9", axes=axes)


def test_dots_are_at_the_values_of_the_gap(axes: Axes) -> None:
    d = example.named()
    plot.gap_bars(d, axes=axes)
    g = d.gap
    assert g.held_out_before is not None
    assert g.held_out_after is not None
    expected = [g.before, g.after, g.noise, g.held_out_before, g.held_out_after, g.noise]
    assert [dot.get_ydata()[0] for dot in axes.get_lines()] == pytest.approx([1e6 * v for v in expected])
    assert [t.get_text() for t in axes.get_xticklabels()] == ["fitted", "held out"]
    assert [t.get_text() for t in axes.texts] == [digits(1e6 * v) for v in expected]
    assert axes.get_yscale() == "log"
    assert axes.get_ylabel() == "RMS gap [µm]"
    assert len({(to_hex(dot.get_color()), dot.get_marker()) for dot in axes.get_lines()}) == 3


def test_dots_without_held_out_runs_or_effects(axes: Axes) -> None:
    plot.gap_bars(example.adequate(), axes=axes)
    assert len(axes.get_lines()) == 2
    assert [t.get_text() for t in axes.get_xticklabels()] == ["fitted"]
    _, other = plt.subplots()
    exact = changed(example.named(), gap=Gap(before=0.0, after=0.0, noise=0.0))
    assert plot.gap_bars(exact, axes=other).get_yscale() == "linear"  # nothing to take a logarithm of
    nothing = [one.model_copy(update={"rms": 0.0}) for one in exact.ranking]
    _, other = plt.subplots()
    assert plot.candidates(changed(exact, ranking=tuple(nothing)), axes=other).get_xscale() == "linear"


def test_force_is_broken_at_zero_velocity() -> None:
    d = example.named()
    _, (left, right) = plt.subplots(1, 2)
    plot.force_against_velocity(d, axes=left)
    plot.force_against_position(d, axes=right)
    down, up = left.get_lines()[2:]
    assert max(down.get_xdata()) < 0 < min(up.get_xdata())
    assert min(down.get_ydata()) > 0.15 > -0.15 > max(up.get_ydata())  # a step of 0.6 N
    np.testing.assert_allclose(right.get_lines()[2].get_xdata(), 1e3 * d.where.position_levels)
    assert (left.get_xlabel(), left.get_ylabel()) == ("velocity [m/s]", "residual force [N]")
    assert right.get_xlabel() == "position from rest [mm]"
    assert d.where.jump is not None
    assert f"jump {abs(d.where.jump):.2g} N" in [text.get_text() for text in left.texts]
    assert f"jumps by {abs(d.where.jump):.2g} N" in " ".join(d.where.sentences)
    assert not right.texts
    plain = d.where.model_copy(update={"jump": None})
    assert not plot.force_against_velocity(plain, axes=plt.subplots()[1]).texts


def test_phases_against_the_noise(axes: Axes) -> None:
    d = example.named()
    plot.phase_bars(d, axes=axes)
    assert [bar.get_height() for bar in axes.patches] == pytest.approx([1e6 * v for v in d.where.phases.values()])
    assert [t.get_text() for t in axes.get_xticklabels()] == list(d.where.phases)
    assert axes.get_lines()[0].get_ydata()[0] == pytest.approx(1e6 * d.gap.noise)


def test_candidates_best_on_top_and_linear_last(axes: Axes) -> None:
    d = example.named()
    plot.candidates(d, axes=axes)
    assert [dot.get_xdata()[0] for dot in axes.get_lines()[:-1]] == pytest.approx([1e6 * one.rms for one in d.ranking])
    names = [t.get_text() for t in axes.texts[1::2]]
    assert names == ["Coulomb friction", "quadratic damping and input delay, start times differ", "linear"]
    assert axes.yaxis_inverted()
    markers = [dot.get_marker() for dot in axes.get_lines()[:-1]]
    assert markers == ["o", "D", "D"]
    said = [t.get_text() for t in axes.texts[::2]]
    assert said[0].endswith(f"({per_cent(d.ranking[0].explained)}, >99 %)")
    assert said[1].endswith("(84 %, <1 %)")
    assert "(" not in said[2]
    _, nothing = plt.subplots()  # the linear model keeps its color where none is better
    plot.candidates(changed(d, verdict="adequate", effects=()), axes=nothing)
    assert [dot.get_marker() for dot in nothing.get_lines()[:-1]] == ["D"] * 3
    _, empty = plt.subplots()
    plot.candidates(example.adequate(), axes=empty)
    assert [t.get_text() for t in empty.texts] == ["none was needed"]


def test_a_set_of_effects_is_named_once_whatever_differs_between_runs() -> None:
    d = example.named()
    first = d.ranking[0]
    other = first.model_copy(update={"deviations": ("gain",), "rms": 0.99 * first.rms})
    plain, shifted = d.ranking[-1], d.ranking[-1].model_copy(update={"deviations": ("gain",)})
    shown = ranked_candidates(changed(d, ranking=(other, first, shifted, plain)), most=6).shown
    assert [(one is first, one is plain) for one, _, named in shown if named] == [(True, False)]
    assert [one for one, _, _ in shown] == [other, first, shifted, plain]


def test_long_names_of_candidates_are_broken(axes: Axes) -> None:
    d = example.named()
    names = ("load_proportional_friction", "position_dependent_damping", "periodic_disturbance")
    one = d.ranking[1].model_copy(update={"effects": names, "deviations": ()})
    plot.candidates(changed(d, ranking=(one,)), axes=axes)
    first, second = axes.texts[1].get_text().split("\n")
    assert first == "load proportional friction and position dependent damping"
    assert second == "and periodic disturbance"


@pytest.mark.parametrize("make", [example.named, example.adequate, example.ambiguous])
def test_page_holds_every_panel(make: type[Diagnosis]) -> None:
    d = make()
    drawn = plot.diagnosis(d)
    assert {"gap", "velocity", "position", "phases", "candidates"} < set(drawn)
    shown = [name for name in drawn if name in example.RUNS]
    gaps = {run.name: run.before for run in d.runs}
    assert {max(gaps, key=lambda n: gaps[n]), min(gaps, key=lambda n: gaps[n])} < set(shown)
    assert len(shown) == 3
    (figure,) = {one.figure for one in drawn.values()}
    assert figure.get_size_inches()[0] == pytest.approx(7.2)
    assert " ".join(figure.get_suptitle().split()) == f"cases 4 to 7: {answer(d, sizes=False)}"
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert labels[:2] == ["measured", "linear model"]
    assert labels[-1] == "noise, ±2σ"
    figure.canvas.draw()
    width, height = figure.bbox.width, figure.bbox.height
    for text in [figure._suptitle, *figure.legends]:
        box = text.get_window_extent()
        assert box.x0 >= 0
        assert box.x1 <= width
        assert box.y1 <= height


def test_page_of_chosen_runs() -> None:
    drawn = plot.diagnosis(example.named(), runs=["case 6"])
    assert [name for name in drawn if name in example.RUNS] == ["case 6"]
    assert drawn["case 6 residual"].get_xlabel() == "time [s]"


def test_every_run_on_a_page() -> None:
    drawn = plot.gap_runs(example.named())
    assert drawn.shape == (4, 2)
    assert [a.get_title(loc="left").split(":")[0] for a in drawn[:, 0]] == list(example.RUNS)
    assert len({a.get_ylim() for a in drawn[:, 1]}) == 1
