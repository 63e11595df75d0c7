"""The catalogue lists itself, and everything that needs a part for each effect has one."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import hidden
import stepid
from exact_plants import EFFECTS, NEW_EFFECTS
from hidden.plant import EVERY
from stepid.effects import CATALOGUE, Effect
from stepid.lab.rig import Rig, draw_plant, scale_of
from stepid.lab.sizes import SIZES

ROOT = Path(__file__).resolve().parents[2]
ROUND_ONE = [
    *("coulomb_friction", "load_proportional_friction", "stribeck_friction", "asymmetric_friction"),
    *("presliding_hysteresis", "quadratic_damping", "position_dependent_damping", "cubic_stiffness"),
    *("quadratic_stiffness", "free_play", "end_stop", "viscoelastic_spring", "flexible_coupling", "actuator_lag"),
    *("input_delay", "actuator_dead_zone", "actuator_saturation", "periodic_disturbance", "cogging", "sensor_drift"),
]
MINE = '''
"""Air."""

from stepid.effects.base import Effect, Parameter


class _Moving(Effect):
    """A base without a name is no effect of its own."""


class HeadWind(_Moving):
    """A steady push."""

    name = "head_wind"
    parameters = (Parameter("push", "N"),)
    law = "-F"
    seen = "it leans"
    advice = "shut the window"
'''
ASK = """
import sys
from stepid.effects import CATALOGUE, resolve
heavy = {"numba", "scipy", "control", "pandas", "matplotlib"} & {m.split(".")[0] for m in sys.modules}
print(" ".join(e.name for e in CATALOGUE), sorted(heavy), resolve(["head_wind"])[0].parameters[0].unit)
import runpy
print([line for line in runpy.run_path(sys.argv[1])["catalogue"]().splitlines() if "wind" in line])
"""


def test_names_are_used_once_and_the_first_twenty_keep_their_order() -> None:
    names = [e.name for e in CATALOGUE]
    assert len(set(names)) == len(names) == 23
    assert [name for name in names if name in ROUND_ONE] == ROUND_ONE


def test_a_class_in_a_new_file_is_an_effect(tmp_path: Path) -> None:
    shutil.copytree(ROOT / "src" / "stepid", tmp_path / "stepid", ignore=shutil.ignore_patterns("__pycache__"))
    (tmp_path / "stepid" / "effects" / "air.py").write_text(MINE, encoding="utf-8")
    command = [sys.executable, "-c", ASK, str(ROOT / "docs" / "make_tables.py")]
    environment = {**os.environ, "PYTHONPATH": str(tmp_path)}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    first, row = done.stdout.splitlines()
    assert first == " ".join([*(e.name for e in CATALOGUE), "head_wind", "[]", "N"])
    assert "shut the window" in row


@pytest.mark.parametrize("effect", CATALOGUE, ids=lambda e: e.name)
def test_the_hidden_simulator_has_a_law_of_its_own(effect: Effect) -> None:
    assert effect.name in EVERY
    values = {**EFFECTS, **NEW_EFFECTS}[effect.name]
    assert values.keys() == {q.name for q in effect.parameters}
    inputs = np.repeat([0.0, 0.5, 0.0], [5, 60, 60])
    plant = {"mass": 0.95, "stiffness": 216.0, "damping": 8.0, "gain": 7.8, "sample_time": 0.01, "inputs": inputs}
    moved = hidden.reference(hidden.Run(**plant, effects={effect.name: values}))
    assert np.abs(moved - hidden.reference(hidden.Run(**plant))).max() > 1e-5, "the law is not there"


@pytest.mark.parametrize("effect", CATALOGUE, ids=lambda e: e.name)
def test_the_lab_knows_a_size(effect: Effect) -> None:
    at = scale_of(Rig(), draw_plant(Rig(), np.random.default_rng(1)))
    for strength in (0.3, 1.0, 3.0):
        values = SIZES[effect.name](np.random.default_rng(2), at, strength)
        assert values.keys() == {q.name for q in effect.parameters}
        assert all(q.lower <= values[q.name] <= q.upper for q in effect.parameters)


def test_sizes_are_for_effects_of_the_catalogue() -> None:
    assert SIZES.keys() == {e.name for e in CATALOGUE}
    assert set(stepid.lab.Draw().among) <= SIZES.keys()


def test_what_one_sees_of_a_law_is_told_where_its_parameters_do_not() -> None:
    """0.1 kg on 39.5 N/m swing at √(k/m)/2π = 3.16 Hz; a branch of 50 N/m and 10 N·s/m forgets in 0.2 s."""
    values = {"flexible_coupling": (0.1, 39.5, 0.0), "viscoelastic_spring": (50.0, 10.0)}
    said = {e.name: e.remark(values.get(e.name, (1.0, 1.0, 1.0, 1.0))) for e in CATALOGUE}
    assert {name: words for name, words in said.items() if words} == {
        "flexible_coupling": "The second mass alone swings at 3.16 Hz: a further mode of the plant.",
        "viscoelastic_spring": "The spring creeps with a relaxation time of 0.2 s. "
        "Step responses hardly tell one such time from several.",
    }
