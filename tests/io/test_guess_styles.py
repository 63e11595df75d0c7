"""Recordings in ten styles of labs, and what their preambles tell: units, sample times, encoders."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import stepid
from folder_score import asked_by, judge
from lab_styles import STYLES, make_styled_folder
from stepid.io.guess.answers import Answers, with_answers
from stepid.io.guess.file_names import encoder_above
from stepid.io.guess.questions import open_questions
from stepid.io.guess.understand import draft_runs

ROWS = "\n".join(f"{0.01 * i:g},{round(900 * np.sin(0.3 * i))},{float(i > 3):g}" for i in range(60))


@pytest.mark.parametrize("number", range(len(STYLES)))
def test_folders_in_styles_of_their_own(number: int, tmp_path: Path) -> None:
    truths = make_styled_folder(tmp_path, number)
    count, trouble = judge(truths, tmp_path)
    assert count["wrong"] == count["wrong unit"] == 0, trouble
    assert count["right"] >= 0.8 * sum(count.values()), trouble
    assert len(asked_by(truths, tmp_path)) <= 2


@pytest.mark.parametrize(
    ("line", "scale"),
    [
        ("encoder: 16000 counts/rev", (2 * np.pi / 16000, True)),
        ("Counts per revolution = 4096", (2 * np.pi / 4096, True)),
        ("# scale 226.6 counts per mm", (1e-3 / 226.6, False)),
        ("Encoder;226600 Inkremente je m", (1 / 226600, False)),
        ("5000 ticks/inch", (0.0254 / 5000, False)),
        ("44.4 counts per degree", (np.pi / 180 / 44.4, True)),
        ("16,000 counts/rev", None),  # sixteen, or thousands
        ("16 000 counts/rev", None),
        ("1000 pulses per revolution", None),  # four counts a pulse, or one
        ("counts/rev", None),
        ("0 counts/rev", None),
    ],
)
def test_encoders_above_the_rows(line: str, scale: tuple[float, bool] | None) -> None:
    found = encoder_above(("Lab 3", line))
    assert found == (None if scale is None else (pytest.approx(scale[0]), scale[1]))


def test_encoders_that_contradict_each_other_tell_nothing() -> None:
    assert encoder_above(("1000 counts/rev", "4000 counts/rev")) is None


def written(folder: Path, top: str) -> Path:
    file = folder / "run 0kg.csv"
    file.write_text(f"{top}\n{ROWS}\n", encoding="utf-8")
    return file


def test_counts_of_a_length_are_taken(tmp_path: Path) -> None:
    file = written(tmp_path, "encoder: 200 counts/mm\ntime [s],x [counts],u [V]")
    (run,) = stepid.draft_campaign(file).campaign()
    assert float(run.position.max()) == pytest.approx(900 / 200e3, rel=1e-2)


def test_counts_of_a_revolution_ask_what_moves(tmp_path: Path) -> None:
    file = written(tmp_path, "encoder: 8000 counts/rev\ntime [s],x [counts],u [V]")

    def asked(**said: object) -> list[str]:
        return [q.key for q in open_questions(with_answers(draft_runs([file]), Answers(**said)))]  # type: ignore[arg-type]

    assert asked() == ["motion"]
    assert asked(motion="rotation") == []
    assert asked(motion="translation") == ["counts_per_meter"]
    turning = stepid.draft_campaign(file, motion="rotation").campaign()
    assert turning.motion == "rotation"
    assert float(turning[0].position.max()) == pytest.approx(900 * 2 * np.pi / 8000, rel=1e-2)
    (question,) = stepid.draft_campaign(file).questions
    assert question.endswith("Give motion=….")


def test_a_line_of_units_counts_wherever_it_stands(tmp_path: Path) -> None:
    file = written(tmp_path, "Unit,ms,mm\nUnits,s,mm,V\nComment,nothing,at all\nt,x,u")
    (draft,) = draft_runs([file])
    assert {role: unit.value for role, unit in draft.units.items()}["position"] == "counts"  # whole numbers
    file = written(tmp_path, "Unit,mm,V\nDate,1.2.,3\ntime,x,u")
    (draft,) = draft_runs([file])
    assert (draft.units["position"].value, draft.units["input"].value) == ("mm", "V")


@pytest.mark.parametrize("head", ["", "t,left,right\n"])
def test_a_run_that_ends_before_another_is_read_back_so(head: str, tmp_path: Path) -> None:
    time = 0.01 * np.arange(200)
    x = 10 * (1 - np.exp(-2 * time) * np.cos(12 * time))
    cells = [
        (f"{t:.2f}", f"{a:.4f}" if i < 150 else "", f"{a / 2:.4f}")
        for i, (t, a) in enumerate(zip(time, x, strict=True))
    ]
    file = tmp_path / "all.csv"
    file.write_text(head + "\n".join(map(",".join, cells)))
    for draft, count in zip(draft_runs([file], {"position": "all"}), (150, 200), strict=True):
        columns = {role: draft.columns[role] for role in ("time", "position")}
        assert stepid.read_table(file, **columns, **draft.layout, position_scale=0.001).time.size == count
