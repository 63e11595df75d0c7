"""Pictures: what must be drawn is drawn, with units on the axes."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib import image
from matplotlib import pyplot as plt

import stepid
from stepid import plot
from stepid.identification.transfer.verification import Verification, VerificationRun
from stepid.plot.style import figure_of


@pytest.fixture(autouse=True)
def _no_windows() -> Iterator[None]:
    mpl.use("Agg")
    yield
    plt.close("all")


def run(name: str = "case 4") -> VerificationRun:
    time = 0.01 * np.arange(200)
    simulated = 0.018 * (1 - np.exp(-5 * time) * np.cos(12 * time))
    return VerificationRun(
        name=name,
        time=time,
        measured=simulated + 1e-4 * np.sin(40 * time),
        simulated=simulated,
        fit_percent=97.5,
        rms=7e-5,
        peak_time=0.25,
    )


def test_response_draws_dots_and_line() -> None:
    _, axes = plt.subplots()
    one = run()
    assert plot.response(one, axes=axes) is axes
    dots, line, peak = axes.get_lines()
    assert set(peak.get_xdata()) == {0.25}
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["measured", "model", "first peak"]
    assert (dots.get_marker(), line.get_linestyle()) == (".", "-")
    np.testing.assert_allclose(dots.get_ydata(), 1e3 * one.measured)
    np.testing.assert_allclose(line.get_ydata(), 1e3 * one.simulated)
    assert axes.get_ylabel() == "position [mm]"
    assert "97.5 %" in axes.get_title(loc="left")


def test_long_names_are_broken() -> None:
    _, axes = plt.subplots()
    plot.response(run("a run whose name would not fit above a picture"), axes=axes)
    lines = axes.get_title(loc="left").splitlines()
    assert lines == ["a run whose name would not fit", "above a picture", "fit 97.5 %"]


def test_residual_is_measured_minus_model_with_the_peak_marked() -> None:
    _, axes = plt.subplots()
    one = run()
    assert plot.residual(one, axes=axes) is axes
    zero, dots, peak = axes.get_lines()
    assert set(zero.get_ydata()) == {0.0}
    np.testing.assert_allclose(dots.get_ydata(), 1e6 * (one.measured - one.simulated))
    assert set(peak.get_xdata()) == {0.25}
    assert axes.get_ylabel() == "residual [µm]"
    assert axes.get_xlabel() == "time [s]"


def test_verification_makes_its_own_figure_or_takes_axes() -> None:
    upper, lower = plot.verification(run())
    assert upper.figure is lower.figure
    assert upper.get_position().y0 > lower.get_position().y1
    assert upper.figure.get_size_inches()[0] == pytest.approx(85 / 25.4)
    _, mine = plt.subplots(2)
    assert plot.verification(run(), axes=(mine[0], mine[1])) == (mine[0], mine[1])


@pytest.mark.parametrize("count", [1, 2, 4, 9])
def test_grid_shows_every_run(count: int) -> None:
    drawn = plot.verification_grid(Verification(runs=tuple(run(f"case {i}") for i in range(count))))
    assert drawn.shape == (count, 2)
    assert [a.get_title(loc="left").split(":")[0] for a in drawn[:, 0]] == [f"case {i}" for i in range(count)]
    (figure,) = {a.figure for a in drawn.ravel()}
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["measured", "model", "first peak"]


def test_the_legend_of_a_page_names_what_any_run_shows() -> None:
    release = run("release").model_copy(update={"peak_time": None})
    drawn = plot.verification_grid(Verification(runs=(release, run("step"))))
    labels = [text.get_text() for text in figure_of(drawn[0, 0]).legends[0].get_texts()]
    assert labels == ["measured", "model", "first peak"]


def test_paper_figure_marks_what_was_measured() -> None:
    limits = set()
    for one in stepid.rebuild_paper().responses:
        upper, lower = plot.paper_figure(one)
        labels = [text.get_text() for text in upper.get_legend().get_texts()]
        assert labels == ["model, printed Table 2", "model, rebuilt", "measured peak", "measured steady state"]
        assert upper.get_title(loc="left").startswith(one.figure)
        assert [text.get_text() for text in lower.texts] == ["no measured record is published"]
        assert lower.get_ylabel() == "difference [µm]"
        limits.add(lower.get_ylim())
    assert len(limits) == 1


def test_save_writes_a_picture_and_closes_it(tmp_path: Path) -> None:
    upper, _ = plot.verification(run())
    path = plot.save(upper, tmp_path / "response.png")
    pixels = image.imread(path)
    assert pixels.shape[1] == 669  # 85 mm at 200 dots an inch
    assert pixels.std() > 0.05
    assert not plt.get_fignums()


def test_user_settings_are_left_alone() -> None:
    before = dict(mpl.rcParams)
    plot.verification(run())
    assert dict(mpl.rcParams) == before
