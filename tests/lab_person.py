"""A scripted person at a terminal, who was in the lab and answers what `stepid init` asks."""

from __future__ import annotations

import os
import pty
import select
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

import stepid
from folder_score import answers_of, files_of
from lab_folders import Truth

SOURCE = str(Path(stepid.__file__).parents[1])
QUESTIONS = {
    "Which column is the position": "position",
    "In which unit is the time": "time_unit",
    "How many seconds are two samples apart": "sample_time",
    "In which unit is the position": "position_unit",
    "Does the plant turn": "motion",
    "How many counts are one meter": "counts_per_meter",
    "In which unit is the input": "input_unit",
    "How large was the step": "step",
    "How many kg is one weight": "weight",
    "Which masses were added": "added_mass",
    "How many counts are one radian": "counts_per_meter",
    "How many kg·m² is one weight": "weight",
    "Which inertias were added": "added_mass",
}


def person(folder: Path, truths: list[Truth], *, limit: float = 60.0) -> tuple[int, str]:
    """Run `stepid init` on a terminal and answer what it asks; how many answers, and all that was shown."""
    leader, follower = pty.openpty()
    names = [file.name for file in files_of(truths, folder)]
    child = subprocess.Popen(
        [sys.executable, "-m", "stepid", "init", *names],
        cwd=folder,
        env=os.environ | {"TERM": "xterm-256color", "COLUMNS": "200", "PYTHONPATH": SOURCE},
        stdin=follower,
        stdout=follower,
        stderr=follower,
    )
    os.close(follower)
    shown, heard, answers, end = "", 0, 0, time.monotonic() + limit
    while time.monotonic() < end:
        if select.select([leader], [], [], 0.1)[0]:
            try:
                chunk = os.read(leader, 65536)
            except OSError:  # how Linux says that the other end is closed
                break
            shown += chunk.decode(errors="replace")
        for words, key in QUESTIONS.items():
            if words in shown[heard:] and shown.endswith(("? ", "] ")):
                heard, answers = len(shown), answers + 1
                os.write(leader, ("all" if key == "position" else answers_of(key, truths)).encode() + b"\n")
    os.close(leader)
    assert child.wait(timeout=10) == 0, shown
    return answers, shown


def check_campaign(folder: Path, truths: list[Truth]) -> None:
    """The campaign holds what the script wrote, in SI units."""
    runs = stepid.read_campaign(folder).experiments
    assert len(runs) == len(truths)
    for truth in truths:
        (mine,) = [
            e
            for e in runs
            if e.position.size == truth.position.size
            and np.allclose(e.position, truth.position * truth.scale, rtol=1e-6, atol=1e-12)
        ]
        assert abs(mine.added_mass - truth.real_mass) < 1e-9
        tolerance = 1e-3 if truth.format == "ecp" else 1e-9
        np.testing.assert_allclose(mine.time, truth.seconds, atol=tolerance)
