"""What recordings hold is found out from their bytes, names and numbers."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import numpy as np
import pytest

import stepid
from folder_score import asked_by, judge
from lab_folders import make_folder, write_workbook
from stepid.errors import InputError
from stepid.io.guess.answers import Answers, with_answers
from stepid.io.guess.manifest_text import manifest_text
from stepid.io.guess.questions import open_questions
from stepid.io.guess.sizes import position_unit, time_unit
from stepid.io.guess.text import find_encoding
from stepid.io.guess.understand import draft_runs, recordings
from stepid.io.guess.words import read_title
from stepid.io.workbook import sheet_names, workbook_lines

T = np.arange(200) * 0.01
X = 8.0 * (1 - np.exp(-2 * T) * np.cos(15 * T))  # mm


def table(head: str, *, x: np.ndarray = X, t: np.ndarray = T, u: float | None = 0.5, sep: str = ",") -> str:
    rows = (sep.join(f"{v:.6g}" for v in ((a, b) if u is None else (a, b, u))) for a, b in zip(t, x, strict=True))
    return head + "\n".join(rows) + "\n"


def one(folder: Path, text: str | bytes, name: str = "run.csv"):
    file = folder / name
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    (draft,) = with_answers(draft_runs([file]), Answers())
    return draft


def check_folders(folder: Path, seeds: range, *, held_out: bool = False) -> tuple[Counter[str], int]:
    count: Counter[str] = Counter()
    most = 0
    for seed in seeds:
        truths = make_folder(folder / str(seed), seed, held_out=held_out)
        found, _ = judge(truths, folder / str(seed))
        count += found
        most = max(most, len(asked_by(truths, folder / str(seed))))
    return count, most


def test_made_up_folders_are_understood(tmp_path: Path) -> None:
    count, most = check_folders(tmp_path, range(3))
    assert count["wrong"] == count["wrong unit"] == 0
    assert count["right"] >= 0.85 * sum(count.values())
    assert most <= 4


@pytest.mark.slow
def test_thirty_folders_are_understood(tmp_path: Path) -> None:
    count, most = check_folders(tmp_path / "practice", range(20))
    held_out, most_held_out = check_folders(tmp_path / "held out", range(10), held_out=True)
    count, most = count + held_out, max(most, most_held_out)
    assert count["wrong unit"] == 0
    assert count["right"] >= 0.9 * (count["right"] + count["asked"] + count["wrong"])
    assert most <= 4


@pytest.mark.parametrize(
    ("name", "role", "unit"),
    [
        ("x_mm", "position", "mm"),
        ("Weg [cm]", "position", "cm"),
        ("Zeit / s", "time", "s"),
        ("elapsed_ms", "time", "ms"),
        ("u_V", "input", "V"),
        ("Spannung (mV)", "input", "mV"),
        ("V_motor", "input", None),
        ("u_in", "input", None),
        ("Encoder 1 Pos", "position", None),
        ("Commanded Pos", "other", None),
        ("velocity (mm/s)", "other", None),
        ("angle_deg", "position", "deg"),
        ("θ (rad)", "position", "rad"),
        ("Position in µm", "position", "um"),
        ("[mm]", "position", "mm"),
        ("y (run 1) [mm]", "position", "mm"),
        ("x_mm_2", "position", "mm"),
        ("torque [Nm]", "input", "N·m"),
        ("Kraft (N)", "input", "N"),
        ("Temperature", "other", None),
        ("quux", None, None),
        ("degrees", "position", "deg"),
        ("mm", "position", "mm"),
        ("rad/s", "other", None),
    ],
)
def test_titles_of_columns(name: str, role: str | None, unit: str | None) -> None:
    assert read_title(name)[:2] == (role, unit)


def test_a_unit_that_two_sizes_fit_is_not_guessed(tmp_path: Path) -> None:
    assert position_unit(X) is None
    assert position_unit(X / 1000) == "m"
    assert position_unit(np.rint(1000 * X)) == "counts"
    assert [time_unit(T * factor) for factor in (1, 1e3, 1e6)] == ["s", "ms", "us"]
    draft = one(tmp_path, table("t,x,u\n"))
    assert "position" not in draft.units
    assert [q.key for q in open_questions([draft])] == ["position_unit", "added_mass"]


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "cp1252"])
def test_encodings(encoding: str, tmp_path: Path) -> None:
    draft = one(tmp_path, table("Prüfstand\nZeit [s];Auslenkung [mm];Spannung [V]\n", sep=";").encode(encoding))
    assert draft.layout.get("encoding") == (None if encoding.startswith("utf-8") else encoding)
    text = manifest_text([draft.having(mass=None)], "rig", tmp_path)
    (tmp_path / "campaign.toml").write_text(text.replace('added_mass = "?"', "added_mass = 0.0"), encoding="utf-8")
    run = stepid.read_campaign(tmp_path)["run"]
    np.testing.assert_allclose(run.position, X / 1000, rtol=1e-5, atol=1e-12)


def test_binary_files_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="not text"):
        find_encoding(bytes(range(256)) * 20, tmp_path / "photo.csv")


def test_without_header_the_content_tells(tmp_path: Path) -> None:
    draft = one(tmp_path, table("", x=X / 1000))
    assert dict(draft.columns) == {"time": 0, "position": 1}
    assert draft.units["position"].why == "its size"


def test_a_column_that_never_changes_may_be_a_setting_and_is_asked_for(tmp_path: Path) -> None:
    """The input of a step at the first sample, or the uncertainty of the readings: nothing tells which."""
    draft = one(tmp_path, table("", x=X / 1000))
    assert "step" in [q.key for q in open_questions([draft])]
    (said,) = draft_runs([tmp_path / "run.csv"], {"input": "2"})
    assert dict(said.columns) == {"time": 0, "position": 1, "input": 2}
    assert "step" not in [q.key for q in open_questions([said])]


def test_two_lines_of_titles_make_runs(tmp_path: Path) -> None:
    head = "0 kg;;0.5 kg;\nt [s];x [mm];t [s];x [mm]\n"
    rows = "\n".join(f"{t:g};{x:.5f};{t:g};{x / 2:.5f}" for t, x in zip(T, X, strict=True))
    (tmp_path / "all.csv").write_text(head + rows + "\n")
    first, second = draft_runs([tmp_path / "all.csv"])
    assert (first.mass.value, second.mass.value) == (0.0, 0.5)
    assert [dict(d.columns) for d in (first, second)] == [{"time": 0, "position": 1}, {"time": 2, "position": 3}]


def units_of(draft) -> dict[str, str]:
    return {role: unit.value for role, unit in draft.units.items()}


def test_what_loggers_write(tmp_path: Path) -> None:
    rows = [f"{1000 * t:.0f},{56 * x:.0f},128" for t, x in zip(T, X, strict=True)]
    serial = one(tmp_path, "millis,counts,pwm\n" + "\n".join(rows))
    assert dict(serial.columns) == {"time": "millis", "position": "counts", "input": "pwm"}
    assert units_of(serial) == {"time": "ms", "position": "counts", "input": "counts"}
    rows = [f"12:03:{t + 4:06.3f};{x:.4f};0.5" for t, x in zip(T, X, strict=True)]
    clock = one(tmp_path, "Uhrzeit;Weg [mm];u [V]\n" + "\n".join(rows))
    assert clock.sample_time.value == pytest.approx(0.01)
    assert "time" not in clock.columns
    comma = one(tmp_path, table("# t x u\n# s mm V\n", sep=" "))
    assert dict(comma.columns) == {"time": 0, "position": 1, "input": 2}
    assert units_of(comma) == {"time": "s", "position": "mm", "input": "V"}
    labview = one(tmp_path, table("***End_of_Header***\nX_Value\tPosition (cm)\tVoltage (V)\n", sep="\t"))
    assert dict(labview.columns) == {"time": "X_Value", "position": "Position (cm)", "input": "Voltage (V)"}


def test_a_column_that_is_named_is_the_only_position_without_a_header(tmp_path: Path) -> None:
    rows = "\n".join(f"{t:.6g},{x:.6g},{2 * x + 1:.6g}" for t, x in zip(T, X, strict=True))
    (tmp_path / "run.csv").write_text(rows, encoding="utf-8")
    asked = stepid.draft_campaign(tmp_path / "run.csv", position_unit="mm", added_mass=0.0, step=0.5)
    with pytest.raises(InputError, match=r"Which column is the position \(1, 2;"):
        asked.campaign()
    told = stepid.draft_campaign(
        tmp_path / "run.csv", position="2", position_unit="mm", added_mass=0.0, step=0.5
    ).campaign()
    assert told.experiments[0].position == pytest.approx(1e-3 * (1 + 2 * X), abs=1e-7)


def test_a_line_above_that_names_too_few_columns_is_no_header(tmp_path: Path) -> None:
    """What is written has to be read again."""
    rows = "\n".join(f"{t:.6g}\t0.5\t{x:.6g}" for t, x in zip(T, X, strict=True))
    (tmp_path / "run.txt").write_text(f"--- Pendolo ---\nTempo.Forzante\n{rows}", encoding="utf-8")
    draft = stepid.draft_campaign(
        tmp_path / "run.txt", position=2, input=1, position_unit="mm", input_unit="V", added_mass=0.0
    )
    draft.write(tmp_path / "campaign.toml")
    assert stepid.read_campaign(tmp_path / "campaign.toml").experiments[0].position == pytest.approx(X / 1000, abs=1e-7)


def test_a_column_of_stamps_is_the_time_though_samples_were_dropped(tmp_path: Path) -> None:
    kept = np.delete(np.arange(T.size), [17, 18, 90])
    rows = "\n".join(f"{T[i]:.6g},{X[i]:.6g}" for i in kept)
    assert one(tmp_path, rows).columns == {"time": 0, "position": 1}
    slow = "\n".join(f"{i},{x:.6g}" for i, x in enumerate(1 - np.exp(-T)))  # a position that only rises is none
    assert one(tmp_path, slow, "slow.csv").columns == {"time": 0, "position": 1}


def test_lines_below_the_rows_are_left_out(tmp_path: Path) -> None:
    draft = one(tmp_path, "sep=;\n" + table("t_s;x_mm;u_V\n", sep=";") + "Mean;3.2;0.5\nEnd\n")
    assert draft.layout == {"delimiter": ";", "skiprows": 1, "stop": 200}
    run = stepid.read_table(draft.file, time="t_s", position="x_mm", input="u_V", position_scale=0.001, **draft.layout)
    assert run.time.size == 200


def test_a_unit_that_stepid_does_not_know_is_asked_for(tmp_path: Path) -> None:
    assert "position" not in one(tmp_path, table("t(s),pos(V),in(V)\n", x=X / 1000)).units
    both = one(tmp_path, table("t(s),pos(mm),pos(V)\n"))
    assert both.columns["position"] == "pos(mm)"


def test_a_unit_that_does_not_fit_its_numbers_is_doubted(tmp_path: Path) -> None:
    assert [doubt.split(";")[0] for doubt in one(tmp_path, table("time_ms,x_m,u_V\n")).doubts] == [
        "the time is in ms by its name, by its size in s",
        "the position spans 13.3 m in m by its name",
    ]


def test_notes_are_no_recordings_and_folders_are_runs(tmp_path: Path) -> None:
    for mass in ("0kg", "0.5kg"):
        (tmp_path / mass).mkdir()
        (tmp_path / mass / "run.csv").write_text(table("t_s,x_mm,u_V\n"))
    (tmp_path / "notes.txt").write_text("We met on Monday.\n")
    (tmp_path / "photo.jpg").write_bytes(bytes(range(256)) * 20)
    runs = [tmp_path / "0kg" / "run.csv", tmp_path / "0.5kg" / "run.csv"]
    files, refused = recordings([runs[0], tmp_path / "notes.txt", tmp_path / "photo.jpg", runs[1]])
    assert len(refused) == 2
    assert "photo.jpg: is not text but binary" in refused[1]
    assert [(d.name, d.mass.value) for d in draft_runs(files)] == [("0kg", 0.0), ("0.5kg", 0.5)]


def test_two_carts_are_asked_about(tmp_path: Path) -> None:
    file = tmp_path / "run.csv"
    file.write_text(
        "t [s],x1 [mm],x2 [mm]\n" + "".join(f"{t:g},{x:.4f},{x / 2:.4f}\n" for t, x in zip(T, X, strict=True))
    )
    assert open_questions(draft_runs([file]))[0].key == "position"
    (draft,) = draft_runs([file], {"position": "x2 [mm]"})
    assert draft.columns["position"] == "x2 [mm]"
    assert len(draft_runs([file], {"position": "all"})) == 2


def test_falling_readings_get_a_negative_scale(tmp_path: Path) -> None:
    text = manifest_text([one(tmp_path, table("t_s,x_mm,u_V\n", x=-X))], "rig", tmp_path)
    assert "position_scale = -0.001 " in text
    assert "negative because readings fall" in text


def test_a_step_that_was_told_starts_where_the_motion_does(tmp_path: Path) -> None:
    late = np.where(T < 0.3, 0.0, np.interp(T - 0.3, T, X))
    file = tmp_path / "run.csv"
    file.write_text(table("t_s,x_mm\n", x=late, u=None))
    (draft,) = with_answers(draft_runs([file]), Answers(step=0.5))
    assert draft.step.value == (0.5, pytest.approx(0.3, abs=0.011))


def test_sheets_of_a_workbook_are_runs(tmp_path: Path) -> None:
    write_workbook(tmp_path / "book.xlsx", [["Lab 3"]], ["t [s]", "x [mm]"], None, [T, X])
    raw = (tmp_path / "book.xlsx").read_bytes()
    assert sheet_names(raw, "book") == ("Tabelle1",)
    assert workbook_lines(raw, "book")[1] == "t [s]\tx [mm]"
    (draft,) = draft_runs([tmp_path / "book.xlsx"])
    assert draft.layout == {"skiprows": 1}
    with pytest.raises(InputError, match="no sheet 'other'"):
        workbook_lines(raw, "book", "other")
    with pytest.raises(InputError, match="damaged workbook"):
        workbook_lines(raw[:200], "book")


@pytest.mark.parametrize("said", ["furlong", "0", "nan"])
def test_what_is_no_unit_is_refused(said: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no unit of the position"):
        with_answers([one(tmp_path, table("t,x,u\n"))], Answers(position_unit=said))


def test_files_without_numbers_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no table of numbers"):
        one(tmp_path, "a letter\nto a friend\n")


@pytest.mark.parametrize(
    ("raw", "options", "words"),
    [
        (table("t,x\n").encode("utf-16"), {}, 'Give encoding = "utf-16"'),
        ("Prüfstand\n".encode("cp1252") + table("t,x\n").encode(), {}, 'Give encoding = "cp1252"'),
        (table("t,x\n").encode(), {"encoding": "klingon"}, "encoding is 'klingon'"),
        ("Prüfstand".encode("cp1252"), {"encoding": "utf-8"}, "is not utf-8 text"),
        (b"", {"encoding": "cp1252"}, "is empty"),
        (table("t,x\n").encode(), {"encoding": ""}, "Give its name as text"),
        (table("t,x\n").encode(), {"sheet": "two"}, "is no workbook"),
        (b"PK\x03\x04 and no more", {}, "damaged workbook"),
    ],
)
def test_encodings_and_sheets_that_cannot_be(raw: bytes, options: dict[str, str], words: str, tmp_path: Path) -> None:
    (tmp_path / "run.csv").write_bytes(raw)
    with pytest.raises(InputError) as refused:
        stepid.read_table(tmp_path / "run.csv", time="t", position="x", **options)
    assert words in str(refused.value)
