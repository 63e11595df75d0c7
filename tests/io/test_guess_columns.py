"""Columns that names do not tell: primes, names that stand twice, clocks that tick unevenly, texts."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import stepid
from stepid.errors import InputError
from stepid.io.guess.understand import draft_runs
from stepid.io.guess.words import read_title
from stepid.io.table_layout import cells

T = 0.08 * np.arange(200)
X = 8.0 * np.exp(-0.3 * T) * np.cos(5 * T)  # mm
SAID = {"position_unit": "mm", "step": 0.0, "added_mass": 0.0}


def write(file: Path, *columns: object, head: str = "") -> Path:
    texts = [[one if isinstance(one, str) else f"{one:.17g}" for one in column] for column in columns]  # type: ignore[attr-defined]
    file.write_text(head + "\n".join(map(",".join, zip(*texts, strict=True))) + "\n", encoding="utf-8")
    return file


@pytest.mark.parametrize(
    ("line", "split"),
    [
        ("X,Y,X',Y''", ["X", "Y", "X'", "Y''"]),
        ("'t (s)','x',\"u\",1.5'", ["t (s)", "x", "u", "1.5"]),
        ("'12,\"'x'\",\"x'\"", ["12", "x", "x'"]),
    ],
)
def test_an_apostrophe_behind_a_name_is_part_of_it(line: str, split: list[str]) -> None:
    assert cells(line, ",") == split


def test_a_prime_tells_columns_apart(tmp_path: Path) -> None:
    file = write(tmp_path / "run.csv", T, X, T + 0.02, np.gradient(X), head="X,Y,X',Y'\n")
    run = stepid.read_table(file, time="X", position="Y", position_scale=1e-3, input=np.zeros(T.size))
    assert run.position == pytest.approx(1e-3 * X)
    (draft,) = draft_runs([file])
    assert (dict(draft.columns), draft.choices) == ({"time": "X"}, ("Y", "X'", "Y'"))
    run = stepid.draft_campaign(file, position="Y", time_unit="s", **SAID).campaign().experiments[0]
    assert run.time == pytest.approx(T)
    assert run.position == pytest.approx(1e-3 * X)
    (prime,) = draft_runs([file], {"position": "Y'"})
    assert dict(prime.columns) == {"time": "X", "position": "Y'"}


def test_a_name_that_stands_twice_is_told_by_number(tmp_path: Path) -> None:
    file = write(tmp_path / "run.csv", T, X, T, 0.5 * X, head="X,Y,X,Y\n")
    assert draft_runs([file])[0].choices == ("1", "2", "3")
    with pytest.raises(InputError, match=r"has 2 columns 'Y' for position \(1, 3\)\. Give .* its number from 0"):
        stepid.draft_campaign(file, position="Y")
    run = stepid.draft_campaign(file, time=0, position=3, time_unit="s", **SAID).campaign().experiments[0]
    assert run.position == pytest.approx(0.5e-3 * X)


def test_a_first_column_that_rises_unevenly_from_zero_is_the_time(tmp_path: Path) -> None:
    uneven = 0.2 + np.cumsum(np.random.default_rng(1).uniform(0.04, 0.12, T.size))
    (draft,) = draft_runs([write(tmp_path / "run.csv", uneven, X)])
    assert dict(draft.columns) == {"time": 0, "position": 1}
    creep = 8.0 * (1 - np.exp(-0.3 * T)) + 0.01 * T  # a cart that comes to rest
    for first in (creep, 40 + uneven, -uneven, np.append(uneven[:-1], 0.0)):
        (draft,) = draft_runs([write(tmp_path / "run.csv", first, X)])
        assert "time" not in draft.columns
    (draft,) = draft_runs([write(tmp_path / "run.csv", X, uneven)])
    assert "time" not in draft.columns


def test_clock_times_that_are_said_to_be_the_time(tmp_path: Path) -> None:
    head = "Timestamp, Elapsed(s), Angle(mm)\n"
    even = [f"16:04:{31 + at:06.3f}" for at in T]
    draft = stepid.draft_campaign(write(tmp_path / "a.txt", even, T, X, head=head), time=0, position=2, **SAID)
    assert draft.campaign().experiments[0].time == pytest.approx(T)
    uneven = [f"16:04:{31 + at:06.3f}" for at in T + np.random.default_rng(1).uniform(0, 0.07, T.size)]
    file = write(tmp_path / "a.txt", uneven, T, X, head=head)
    with pytest.raises(
        InputError, match=r"column 0 for time holds no numbers\. .*, or leave it out and give sample_time"
    ):
        stepid.draft_campaign(file, time=0, position=2, **SAID)
    with pytest.raises(
        InputError, match=r"column 'Timestamp' for position holds no numbers\. Give a column of numbers"
    ):
        stepid.draft_campaign(file, position="Timestamp")


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("step", [0.0, 1e-7, 0.01])
def test_the_onset_of_a_step_late_on_a_clock_is_found_without_a_warning(step: float, tmp_path: Path) -> None:
    tick = np.arange(200)
    x = np.where(tick > 40, 8.0 * (1 - np.cos(0.05 * (tick - 40.0))), 0.0)
    file = write(tmp_path / "run.csv", 1488.998 + step * tick, x, head="time (s),x (mm)\n")
    found = stepid.draft_campaign(file, step=0.5, added_mass=0.0).runs[0].step
    assert found is not None
    assert found.value[1] == pytest.approx(1488.998 + 40 * step, abs=2 * step)


def test_a_name_that_two_columns_have_is_that_of_the_one_with_numbers(tmp_path: Path) -> None:
    clock = [f"12:00:0{n % 10}" for n in range(200)]
    file = write(tmp_path / "run.csv", T, X, clock, head="t (s),x (mm),x\n")
    (draft,) = draft_runs([file], {"position": "x"})
    np.testing.assert_array_equal(draft.readings["position"], X)


def test_a_clock_whose_first_cell_is_empty_is_in_doubt(tmp_path: Path) -> None:
    (draft,) = draft_runs([write(tmp_path / "run.csv", ["", *map(str, T[1:])], X)])
    assert draft.doubts == ("the time is no number in row 1 of the table",)


def test_two_columns_alike_make_no_export_of_a_table_without_header(tmp_path: Path) -> None:
    """Time, reference, and a position in m that follows it: neither a sample counter nor whole counts."""
    rows = np.column_stack([T, np.round(0.2 * T) / 400, 1e-3 * X, 1.001e-3 * X, 0.1 * X**2, 0.1 * X])
    text = "".join("\t".join(f"{value:.4f}" for value in row) + "\n" for row in rows)
    (tmp_path / "run.txt").write_text(text, encoding="utf-8")
    (draft,) = draft_runs([tmp_path / "run.txt"])
    assert (draft.format, dict(draft.columns)) == ("table", {"time": 0, "input": 1})
    assert draft.choices == ("2", "3", "4", "5")
    with pytest.raises(InputError, match=r"no header says what its 6 columns are\. .*other units .* read_table"):
        stepid.read_ecp(tmp_path / "run.txt", counts_per_meter=1.0)


def test_one_row_without_header_is_no_export(tmp_path: Path) -> None:
    (tmp_path / "run.txt").write_text("0 0.0 10 10 0.5\n", encoding="utf-8")
    with pytest.raises(InputError, match="no header says what its 5 columns are"):
        stepid.read_ecp(tmp_path / "run.txt", counts_per_meter=1.0)


@pytest.mark.parametrize(
    ("title", "found"),
    [
        ("Hubangle(Theta in rad)", ("position", "rad")),
        ("arm (yaw angle, deg)", ("position", "deg")),
        ("Armposition / mm", ("position", "mm")),
        ("Sollwinkel (rad)", ("other", None)),
        ("x (target, mm)", ("other", None)),
        ("u (x in V)", ("input", "V")),
        ("x (5 m)", ("position", None)),
        ("Rectangle (V)", ("input", "V")),
        ("p (Pa/s)", (None, None)),
        ("accurate position (mm)", ("position", "mm")),
        ("Substrate (mm)", ("position", "mm")),
        ("Reflexionswinkel (deg)", ("position", "deg")),
        ("Reflectionangle (rad)", ("position", "rad")),
        ("Referenzposition (mm)", ("other", None)),
        ("setposition (mm)", ("other", None)),
    ],
)
def test_compound_words_and_words_in_brackets(title: str, found: tuple[str, str | None]) -> None:
    assert read_title(title)[:2] == found


FLICKER = np.where(np.arange(T.size) % 7 == 0, 0.001, 0.0)
NOISE = np.random.default_rng(1).normal(0.0, 0.01, T.size)


@pytest.mark.parametrize("still", [FLICKER, NOISE, 0 * T])
@pytest.mark.parametrize("other", ["Hubangle(Theta in rad)", "B", "angle (quux)"])
def test_a_column_at_rest_beside_one_that_moves_is_asked_about(still: np.ndarray, other: str, tmp_path: Path) -> None:
    file = write(tmp_path / "run.csv", T, X, still, np.sign(T - 2), head=f"t (s),{other},Tip Deflection(m),u (V)\n")
    (draft,) = draft_runs([file])
    assert draft.choices == (other, "Tip Deflection(m)")
    file = write(tmp_path / "run.csv", T, NOISE + 1, X, np.sign(T - 2), head="t (s),B,Tip Deflection(mm),u (V)\n")
    (draft,) = draft_runs([file])
    assert dict(draft.columns) == {"time": "t (s)", "position": "Tip Deflection(mm)", "input": "u (V)"}


SPIKE = np.where(np.arange(T.size) == 100, 1e5, X)


@pytest.mark.parametrize("x", [8 * np.exp(-0.1 * T) * np.cos(0.4 * np.pi * np.arange(T.size)), SPIKE, X**9])
def test_fast_swings_and_spikes_are_no_rest(x: np.ndarray, tmp_path: Path) -> None:
    file = write(tmp_path / "run.csv", T, x, np.sin(3 * T), head="t (s),Position (mm),B\n")
    (draft,) = draft_runs([file])
    assert dict(draft.columns) == {"time": "t (s)", "position": "Position (mm)"}


@pytest.mark.parametrize(
    "title",
    [
        "xGyro",
        "ZGyro",
        "gyro_x",
        "pitch rate",
        "omega",
        "yaw vel",
        "Gyroskop y",
        "roll rate (deg)",
        "Winkelgeschwindigkeit",
        "yawrate",
    ],
)
def test_names_of_rates_are_no_positions(title: str) -> None:
    assert read_title(title).role == "other"


@pytest.mark.parametrize("title", ["VIn (V)", "VSupply (V)", "VApplied (V)", "VPlant (V)", "AIn (A)", "IIn (A)"])
def test_a_capital_before_the_name_of_an_input_is_no_word(title: str) -> None:
    assert read_title(title)[:2] == ("input", title[-2])


def test_angles_of_an_inertial_sensor_are_offered_and_its_rates_are_not(tmp_path: Path) -> None:
    head = "Time,sensPitch,sensRoll,sensYaw,xGyro,yGyro,ZGyro,xAcc\n"
    file = write(tmp_path / "run.csv", T, X, 0.5 * X, 2 * X, *4 * [np.gradient(X)], head=head)
    (draft,) = draft_runs([file])
    assert draft.choices == ("sensPitch", "sensRoll", "sensYaw")


@pytest.mark.parametrize("second", [X / 91.9, np.round(3 - X / 91.9, 5), X / 10])
@pytest.mark.parametrize("inputs", ["u (V),U_k (V)", "a,b"])
def test_scaled_copies_are_one_motion_and_no_two_runs(second: np.ndarray, inputs: str, tmp_path: Path) -> None:
    steps = [np.sign(T - 2), np.sign(T - 3)]
    file = write(tmp_path / "run.csv", T, X, second, *steps, head=f"t (s),Weg (mm),winkel (rad),{inputs}\n")
    (draft,) = draft_runs([file])
    assert draft.choices == ("Weg (mm)", "winkel (rad)")
    assert draft.doubts[-1].endswith("; Weg (mm) and winkel (rad) are one motion, to scale")
    assert len(draft_runs([file], {"position": "all"})) == 2
    head = "t (s),x left (mm),x right (mm),u left (V),u right (V)\n"
    file = write(tmp_path / "run.csv", T, X, np.exp(-0.1 * T) * np.cos(4 * T), *steps, head=head)
    assert len(draft_runs([file])) == 2


U = np.where(T > 2, 1.0, 0.0)


@pytest.mark.parametrize(
    ("head", "columns"),
    [
        ("t (s),x1 (mm),u1 (V),x2 (mm),u2 (V)\n", [T, X, U, 2 * X, 2 * U]),
        ("t (s),x1 (mm),u1 (V),x2 (mm),u2 (V)\n", [T, X, 0.5 + 0 * T, 2 * X, 1 + 0 * T]),
        ("t1 (s),x1 (mm),u1 (V),t2 (s),x2 (mm),u2 (V)\n", [T, X, U, T, 2 * X, 2 * U]),
        ("t (s),run 1 (mm),run 2 (mm)\n", [T, X, 2 * X]),
    ],
)
def test_runs_of_a_linear_plant_are_runs(head: str, columns: list[np.ndarray], tmp_path: Path) -> None:
    runs = draft_runs([write(tmp_path / "run.csv", *columns, head=head)])
    assert [run.readings["position"][9] for run in runs] == [X[9], 2 * X[9]]


def test_a_slow_clock_in_a_unit_that_is_told_is_not_doubted(tmp_path: Path) -> None:
    time = 0.1001 * np.arange(6000)
    file = write(tmp_path / "run.csv", time, np.cos(time), head="t (s),x (rad)\n")
    assert draft_runs([file])[0].doubts == ()
    for ms in (20 * time, np.arange(3000.0)):
        file = write(tmp_path / "run.csv", ms, np.cos(0.02 * ms), head="t (s),x (rad)\n")
        assert draft_runs([file])[0].doubts == ("the time is in s by its name, by its size in ms; check it",)


def test_of_several_sensors_in_every_run_one_is_asked_for(tmp_path: Path) -> None:
    """As Pasco's programs write them: a run's time and sensors side by side, then the next run's."""
    names = ("Time (s)", "Angle, Ch 1+2 (rad)", "Angle, Ch 3+4 (rad)")
    head = ";".join(f'"{name} Run #{run}"' for run in (1, 2, 3) for name in names)
    rows = np.column_stack([column for run in (1, 2, 3) for column in (T, run * X, 0.1 * run * np.sin(T))])
    file = tmp_path / "runs.csv"
    file.write_text(head + "\n" + "\n".join(";".join(f"{x:.9f}" for x in row) for row in rows) + "\n", encoding="utf-8")
    (asked,) = draft_runs([file])
    assert asked.choices == names[1:]
    assert "position" not in asked.columns
    found = draft_runs([file], {"position": "Angle, Ch 1+2 (rad)"})
    assert [draft.name for draft in found] == ["Run 1", "Run 2", "Run 3"]
    for run, draft in enumerate(found, 1):
        assert dict(draft.columns) == {"time": f"Time (s) Run #{run}", "position": f"Angle, Ch 1+2 (rad) Run #{run}"}
        np.testing.assert_allclose(draft.readings["position"], run * X, atol=1e-8)
    assert len(draft_runs([file], {"position": "all"})) == 6


@pytest.mark.parametrize(
    "titles",
    [
        ["x 0.5kg run 1", "x 0.5kg run 2", "x 1kg run 1", "x 1kg run 2"],
        ["x 0.5 kg Run #1", "x 1 kg Run #1"],  # masses are no sensors
        ["x (m) Run #1", "x (m) Run #2", "x (m) Run #10"],
        ["Position, Ch 1 (m) Run #1", "Position, Ch 1 (m) Run #2"],
        ["exp 1 rep 1 x (m)", "exp 1 rep 2 x (m)", "exp 2 rep 1 x (m)"],
    ],
)
def test_columns_of_runs_are_no_sensors(titles: list[str], tmp_path: Path) -> None:
    head = ",".join(f'"{title}"' for title in ("t (s)", *(t if "(m)" in t else f"{t} (m)" for t in titles))) + "\n"
    file = write(tmp_path / "runs.csv", T, *((1.0 + 0.1 * i) * X for i in range(len(titles))), head=head)
    found = draft_runs([file])
    assert len({draft.name for draft in found}) == len(found) == len(titles)


def test_a_sensor_that_one_run_has_goes_with_its_time(tmp_path: Path) -> None:
    head = "t (s) Run #1,A (m) Run #1,t (s) Run #2,A (m) Run #2,B (m) Run #2\n"
    file = write(tmp_path / "runs.csv", T, X, 2 * T, 0.5 * X, 0.2 * X, head=head)
    (draft,) = draft_runs([file], {"position": "B (m)"})
    assert dict(draft.columns) == {"time": "t (s) Run #2", "position": "B (m) Run #2"}


def test_each_column_of_many_runs_has_the_time_of_its_run(tmp_path: Path) -> None:
    runs = range(1, 13)
    head = ",".join(f"{name} Run #{run}" for run in runs for name in ("t (s)", "left x (m)", "right x (m)")) + "\n"
    file = write(tmp_path / "runs.csv", *(c for run in runs for c in (run * T, X, 0.5 * X)), head=head)
    found = draft_runs([file], {"position": "all"})
    assert [draft.columns["time"] for draft in found] == [f"t (s) Run #{run}" for run in runs for _ in range(2)]
