"""Kills (SIGKILL) while saving and while writing the folder of a report, some of what ``benchmarks/kills.py`` does."""

import os
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))
import kills

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not hasattr(os, "fork"), reason="kills forks"),
    pytest.mark.filterwarnings("ignore:.*fork:DeprecationWarning"),
]


def test_saving_through_kills() -> None:
    tally = kills.kill(kills.save_result, kills.saved_generation, kills=20)
    assert (tally.kills, tally.broken, tally.wrong) == (20, 0, [])


def test_writing_a_folder_through_kills() -> None:
    write = kills.write_folder({f"{n}.png": bytes(40_000 * n) for n in range(8)})
    tally = kills.kill(write, kills.folder_generation, kills=20)
    assert (tally.kills, tally.broken, tally.wrong) == (20, 0, [])
