"""Tables that only one reading makes sense of: two columns with decimal commas, empty last lines, coarse clocks."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest

import stepid
from exports import export_bytes, write
from stepid.errors import InputError
from stepid.io.guess.understand import draft_runs
from stepid.io.guess.words import read_title

T = np.arange(600) / 30  # s
X = 0.3 * np.exp(-0.1 * T) * np.cos(3.0 * T)  # rad
RELEASED = {"step": 0.0, "added_mass": 0.0}


@pytest.mark.parametrize("separator", [";", "\t"])
@pytest.mark.parametrize("head", ["t / s{}x / rad\n", ""])
def test_two_columns_with_decimal_commas_are_two(separator: str, head: str, tmp_path: Path) -> None:
    file = tmp_path / "run.txt"
    rows = [f"{t:.3f}{separator}{x:.3f}".replace(".", ",") for t, x in zip(T, X, strict=True)]
    file.write_text(head.format(separator) + "\n".join(rows) + "\n", encoding="utf-8")
    (draft,) = draft_runs([file])
    np.testing.assert_array_equal(draft.readings["time"], T.round(3))
    np.testing.assert_array_equal(draft.readings["position"], X.round(3))


@pytest.mark.filterwarnings("ignore:.* 1 line below the rows is left out")
@pytest.mark.parametrize("below", ["", ";;;\n", ";;;\n;;;\n", "mean;0;;\n"])
def test_runs_of_unequal_length_side_by_side_end_where_they_end(below: str, tmp_path: Path) -> None:
    cut = [f"{t:.4f};{x:.5f}" if t < 15 else ";" for t, x in zip(T, X, strict=True)]
    whole = [f"{t:.4f};{x:.5f}" for t, x in zip(T, X[::-1], strict=True)]
    file = tmp_path / "runs.csv"
    rows = [f"{one};{other}\n" for one, other in zip(cut, whole, strict=True)]
    file.write_text("t1 (s);x1 (rad);t2 (s);x2 (rad)\n" + "".join(rows) + below, encoding="utf-8")
    found = stepid.draft_campaign(tmp_path, **RELEASED).campaign()
    assert [run.time.size for run in found.experiments] == [450, 600]


def test_empty_cells_in_the_middle_are_still_refused(tmp_path: Path) -> None:
    file = tmp_path / "run.csv"
    rows = [f"{t:.4f};{x:.5f}\n" for t, x in zip(T, X, strict=True)]
    file.write_text("".join([*rows[:300], ";\n", *rows[300:]]), encoding="utf-8")
    with pytest.raises(InputError, match="line 301"):
        stepid.read_table(file, time=0, position=1)


def stamped(file: Path, time: np.ndarray) -> Path:
    rows = [f"{t:.10g},{x:.5f}\n" for t, x in zip(time, X, strict=True)]
    file.write_text("t (s),x (rad)\n" + "".join(rows), encoding="utf-8")
    return file


COARSE = {
    "three digits": np.array([float(f"{t:.3g}") for t in T]),  # 10.0, 10.0, 10.1 from ten seconds on
    "rounded": (T + 0.04).round(1),  # the first stamp is off, too
    "cut off": np.floor(10 * T) / 10,
    "seconds": np.floor(T + 0.5),
    "dead": np.full(T.size, 5.0),
}


@pytest.mark.parametrize("printed", COARSE)
def test_a_clock_that_is_printed_too_coarsely_asks_for_the_sample_time(printed: str, tmp_path: Path) -> None:
    time = COARSE[printed]
    stamped(tmp_path / "run.csv", time)
    with pytest.raises(InputError, match="How many seconds are two samples apart"):
        stepid.draft_campaign(tmp_path, **RELEASED).campaign()
    found = stepid.draft_campaign(tmp_path, **RELEASED, sample_time=1 / 30).campaign()
    np.testing.assert_allclose(found.experiments[0].time, time[0] + T, atol=1e-9)


@pytest.mark.parametrize("printed", ["three digits", "rounded", "cut off", "seconds"])
def test_repeated_stamps_are_checked_against_the_sample_time(printed: str, tmp_path: Path) -> None:
    file = stamped(tmp_path / "run.csv", COARSE[printed])
    with pytest.raises(InputError, match="does not increase") as refused:
        stepid.read_table(file, time=0, position=1)
    assert "printed rounded" in refused.value.remedy
    with pytest.raises(InputError, match=r"sample off 0\.04 s"):
        stepid.read_table(file, time=0, position=1, sample_time=0.04)


def test_three_digits_are_named_as_what_hides_the_sample_time(tmp_path: Path) -> None:
    file = stamped(tmp_path / "run.csv", COARSE["three digits"])
    with pytest.raises(InputError, match=r"printed to 0\.1 s only, and rows are about 0\.0333\d+ s") as refused:
        stepid.read_table(file, time=0, position=1)
    assert refused.value.remedy.startswith("Give sample_time=")
    with pytest.raises(InputError, match=r"line \d+: .*, printed to 0\.1 s only, .*about 0\.0333\d+ s") as refused:
        stepid.read_table(file, time=0, position=1, sample_time=1 / 300)
    assert refused.value.remedy.startswith("Correct sample_time")
    draft = stepid.draft_campaign(file, time_unit="s", **RELEASED)
    assert draft.questions[0].startswith(
        "The times are printed too coarsely, so that they repeat. Rows are about 0.0333"
    )
    assert "600 × 33.39 ms?" in draft.summary()


@pytest.mark.parametrize("late", [True, False])
def test_of_coarse_stamps_the_one_that_is_off_most_is_named(late: bool, tmp_path: Path) -> None:
    tick = np.arange(600)
    off = np.where((tick > 30) & (tick < 60), 0.009 - 0.004 * late, 0.0)
    off -= np.where((tick > 120) & (tick < 150), 0.005 + 0.004 * late, 0.0)
    time = np.maximum.accumulate(np.round(np.floor((0.003 * tick + 0.005 + off) * 100 + 1e-9) / 100, 2))
    with pytest.raises(InputError, match=r"printed to 0\.01 s only, is more than half a sample off") as refused:
        stepid.read_table(stamped(tmp_path / "run.csv", time), time=0, position=1, sample_time=0.003)
    row = int(refused.value.cause.split("line ")[1].split(":")[0]) - 2
    assert off[row] == pytest.approx(-0.009 if late else 0.009)


@pytest.mark.parametrize("gap", [0.1, 1.0, 100.0])
def test_a_gap_is_no_rounding(gap: float, tmp_path: Path) -> None:
    time = T + gap * (T > 10)
    time[100] = time[99]
    file = stamped(tmp_path / "run.csv", time)
    for sample_time in (1 / 30, (time[-1] - time[0]) / (time.size - 1)):
        with pytest.raises(InputError, match="sample off"):
            stepid.read_table(file, time=0, position=1, sample_time=sample_time)


def test_the_sample_time_goes_before_stamps_of_which_few_repeat(tmp_path: Path) -> None:
    """The step is looked for on that clock, too."""
    time = np.arange(600) / 103.0
    stamped(tmp_path / "run.csv", time.round(2))
    found = stepid.draft_campaign(tmp_path, **RELEASED, sample_time=1 / 103.0).campaign()
    np.testing.assert_allclose(found.experiments[0].time, time, atol=1e-9)


@pytest.mark.parametrize("title", ["Ay ({})", "Ay / {}", "Ay, {}", "Ay in {}"])
@pytest.mark.parametrize("unit", ["m/s", "m/s²", "mm/s^2", "rad/s", "m/min", "cm/s"])
def test_a_rate_is_no_position(title: str, unit: str, tmp_path: Path) -> None:
    file = tmp_path / "run.csv"
    rows = [f"{t:.4f};{x:.5f}\n" for t, x in zip(T, X, strict=True)]
    file.write_text(f"t (s);{title.format(unit)}\n" + "".join(rows), encoding="utf-8")
    (draft,) = draft_runs([file])
    assert "position" not in draft.columns
    (draft,) = draft_runs([file], {"position": "1"})  # where somebody says so
    assert draft.columns["position"] == title.format(unit)


@pytest.mark.parametrize("unit", ["mm s^-1", "m·s⁻²", "m s⁻¹"])
def test_a_rate_by_a_negative_power_is_one(unit: str) -> None:
    assert read_title(f"Ay ({unit})").role == "other"


@pytest.mark.parametrize(
    ("title", "role"),
    [
        ("pos (counts/step)", "position"),
        ("x (V/sensor)", "position"),
        ("x (cas-1)", "position"),
        ("x run 1 (5 m/s)", "position"),
        ("x (m) at v = 1 m/s", "position"),
        ("u (volts-DC)", "input"),
        ("u (V/step)", "input"),
        ("u (V/s)", "input"),
    ],
)
def test_what_is_no_rate_keeps_its_role(title: str, role: str) -> None:
    assert read_title(title).role == role


@pytest.mark.parametrize(
    "title", ["uncertainty A", "x uncertainty (m)", "sigma_x", "Unsicherheit Winkel", "stdev x [mm]"]
)
def test_how_sure_a_reading_is_is_no_reading(title: str) -> None:
    assert read_title(title).role == "other"


@pytest.mark.parametrize("names", ["t y dy", "time y dy", "t  y   dy", "Zeit y1 y2", "t position dx"])
def test_names_with_blanks_above_rows_with_tabs(names: str, tmp_path: Path) -> None:
    file = tmp_path / "run.txt"
    rows = [f"{t:.4f}\t{x:.5f}\t0.017\n" for t, x in zip(T, X, strict=True)]
    file.write_text(names + "\n" + "".join(rows), encoding="utf-8")
    (draft,) = draft_runs([file], {"position": names.split()[1]})
    assert dict(draft.columns) == {"time": 0, "position": 1}
    assert draft.titles == {"time": names.split()[0], "position": names.split()[1]}


@pytest.mark.parametrize(
    "title", ["Position over time", "Weg gegen Zeit", "x of t", "run of x", "red car run", "Time in s"]
)
def test_words_of_a_title_are_no_names(title: str, tmp_path: Path) -> None:
    file = tmp_path / "run.txt"
    rows = [f"{t:.4f}\t{x:.5f}\t{np.sign(t - 5):.1f}\n" for t, x in zip(T, X, strict=True)]
    file.write_text(title + "\n" + "".join(rows), encoding="utf-8")
    (draft,) = draft_runs([file])
    assert not set(draft.titles.values()) & set(title.split())


@pytest.mark.parametrize("units", ["ms", "[ms]", "ms;"])
def test_a_line_of_units_that_ends_early_keeps_the_names(units: str, tmp_path: Path) -> None:
    file = tmp_path / "run.csv"
    rows = [f"{1e3 * t:.1f};{x:.5f}\n" for t, x in zip(T, X, strict=True)]
    file.write_text(f"t;x\n{units}\n" + "".join(rows), encoding="utf-8")
    (draft,) = draft_runs([file])
    assert draft.titles == {"time": "t", "position": "x"}


def test_an_abscissa_is_not_taken_for_the_position(tmp_path: Path) -> None:
    file = tmp_path / "run.txt"
    rows = [f"{t:.2E}\t{x:.2E}\t0.017\t0.05\n" for t, x in zip(6.33 + T, X, strict=True)]
    file.write_text("x y dx dy\n" + "".join(rows), encoding="utf-8")
    (draft,) = draft_runs([file], {"position": "y"})
    assert draft.columns["position"] == 1
    assert "input" not in draft.columns


@pytest.mark.parametrize(
    ("head", "x"),
    [
        ("", X),
        ("", 0.0975 + 0.1 * X),
        ("", 5 + X),
        ("x (mm)\n", 0.5 + 0.3 * X),
        ("Lab 3\nWeg in mm\n", 30.5 + np.rint(9 * X)),
    ],
)
def test_one_column_with_decimal_commas_is_one(head: str, x: np.ndarray, tmp_path: Path) -> None:
    file = tmp_path / "run.txt"
    file.write_text(head + "".join(f"{value:.4f}\n".replace(".", ",") for value in x), encoding="utf-8")
    draft = stepid.draft_campaign(file, sample_time=1 / 30, position_unit="mm", **RELEASED)
    assert draft.campaign()[0].position == pytest.approx(1e-3 * x.round(4))


@pytest.mark.parametrize("head", ["", "x1,x2\n", "encoder, pot\n"])
def test_two_columns_of_counts_are_two(head: str, tmp_path: Path) -> None:
    file = tmp_path / "run.txt"
    rows = [f"{round(1e3 * x)},{round(500 + 1e3 * x)}\n" for x in X]
    file.write_text(head + "".join(rows), encoding="utf-8")
    assert len(draft_runs([file], {"position": "all"})) == 2


@pytest.mark.parametrize(
    ("head", "first"),
    [
        ("", 0),  # an input that is off
        ("Position record 3\n", None),
        ("Time and position\n", None),
        ("Weg und Zeit\n", None),
        ("Cart position run\n", None),
    ],
)
def test_whole_numbers_beside_counts_are_no_decimals(head: str, first: int | None, tmp_path: Path) -> None:
    file = tmp_path / "run.txt"
    counts = np.rint(2e4 * (1 + X)).astype(int)
    rows = [f"{i if first is None else first},{count}\n" for i, count in enumerate(counts)]
    file.write_text(head + "".join(rows), encoding="utf-8")
    (draft,) = draft_runs([file], {"position": "1"})
    np.testing.assert_array_equal(draft.readings["position"], counts)


@pytest.mark.parametrize(("unit", "scale"), [("rad", 1.0), ("deg", np.pi / 180), ("m", 1.0), ("cm", 0.01)])
def test_a_column_called_by_its_unit_may_be_the_position(unit: str, scale: float, tmp_path: Path) -> None:
    rows = [f"{t:.4f},{x:.5f},{3 - x**2:.5f},{-x:.5f}\n" for t, x in zip(T, X, strict=True)]
    (tmp_path / "run.csv").write_text(f"t,x,y,{unit}\n" + "".join(rows), encoding="utf-8")
    (question,) = stepid.draft_campaign(tmp_path, time_unit="s", **RELEASED).questions
    assert question.startswith(f"Which column is the position (x, y, {unit};")
    run = stepid.draft_campaign(tmp_path, time_unit="s", position=unit, **RELEASED).campaign()[0]
    np.testing.assert_allclose(run.position, -scale * X.round(5), atol=2e-5)


def test_an_index_that_nobody_named_is_no_clock(tmp_path: Path) -> None:
    """As pandas writes it: rows 0, 1, 2… had been milliseconds, whatever was said of the sample time."""
    rows = [f"{i},{x:.5f}\n" for i, x in enumerate(X)]
    (tmp_path / "run.csv").write_text(",x (rad)\n" + "".join(rows), encoding="utf-8")
    with pytest.raises(InputError, match="How many seconds are two samples apart"):
        stepid.draft_campaign(tmp_path, **RELEASED).campaign()
    (run,) = stepid.draft_campaign(tmp_path, **RELEASED, sample_time=1 / 30).campaign().experiments
    np.testing.assert_allclose(run.time, np.arange(X.size) / 30)
    clock = [f"2024-05-03T14:59:{30 + i // 30:02d}.{1000 * (i % 30) // 30:03d}" for i in range(600)]
    moments = [f"{i},{moment},{x:.5f}\n" for i, (moment, x) in enumerate(zip(clock, X, strict=True))]
    (tmp_path / "run.csv").write_text(",timestamp,x (rad)\n" + "".join(moments), encoding="utf-8")
    (run,) = stepid.draft_campaign(tmp_path, **RELEASED).campaign().experiments
    assert run.sample_time == pytest.approx(1 / 30, rel=0.03)


def test_a_trigger_is_no_drive_and_of_several_inputs_it_is_said_which_is_taken(tmp_path: Path) -> None:
    step = np.where(T > 1.0, 1.0, 0.0)
    early = np.where(T > 0.8, 5.0, 0.0)
    rows = [f"{t:.4f},{e:g},{x:.5f},{u:g}\n" for t, e, x, u in zip(T, early, X, step, strict=True)]
    for name, said in (("trigger_in (V)", False), ("force (V)", True)):
        (tmp_path / "run.csv").write_text(f"t (s),{name},x (rad),drive (V)\n" + "".join(rows), encoding="utf-8")
        draft = stepid.draft_campaign(tmp_path, added_mass=0.0, spring="s", damper="d")
        assert ("may be the input, too" in draft.summary()) is said
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            (run,) = draft.campaign().experiments
        assert run.input.max() == (5.0 if said else 1.0)


def test_an_encoder_without_a_number_is_asked_about(tmp_path: Path) -> None:
    """It had ended in an error of Python's."""
    file = write(tmp_path / "run_1.txt", export_bytes().replace(b"Encoder 1 Pos", b"Encoder Pos  "))
    with pytest.raises(InputError, match="Which column is the position"):
        stepid.draft_campaign(file, added_mass=0.0, spring="s", damper="d").campaign()
