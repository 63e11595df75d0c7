"""Compiled and plain Python are one kernel; without numba or a cache it still runs, and says so."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from hidden.accuracy_cases import ALONE

TESTS = Path(__file__).resolve().parents[1]
CODE = """
import json, warnings
from dataclasses import replace
warnings.simplefilter("always")
with warnings.catch_warnings(record=True) as caught:
    from hidden.accuracy_cases import run
    from hidden_runs import simulated
    found = {}
    for case in %r:
        told = run(case)
        found[case] = simulated(replace(told, inputs=told.inputs[:%d]), tolerance=1e-6).tolist()
    from stepid.simulation.compiled import JIT
said = [str(w.message) for w in caught if w.category is RuntimeWarning]
print(json.dumps({"found": found, "said": said, "compiled": bool(JIT)}))
"""
BLOCK = "import sys\nsys.modules['numba'] = None\n"
SHORT = [f"{name} step" for name in ALONE] + ["linear step", "combination 10", "combination 18", "straight friction"]


def told_by(cases: list[str], *, first: str = "", size: int = 60, **environment: str) -> dict:
    surroundings = os.environ | {"PYTHONPATH": f"{os.environ.get('PYTHONPATH', '')}{os.pathsep}{TESTS}", **environment}
    command = [sys.executable, "-c", first + CODE % (cases, size)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=surroundings)
    assert done.returncode == 0, done.stderr
    answer: dict = json.loads(done.stdout)
    return answer


def near(one: dict, other: dict) -> None:
    for case, reading in one["found"].items():
        expected = np.array(other["found"][case])
        travel = np.abs(expected).max()
        assert travel > 1e-4, case
        np.testing.assert_allclose(reading, expected, rtol=0, atol=1e-9 * travel, err_msg=case)


@pytest.fixture(scope="module")
def compiled() -> dict:
    return told_by(SHORT)


@pytest.mark.slow
def test_plain_python_and_machine_code_agree(compiled: dict) -> None:
    plain = told_by(SHORT, NUMBA_DISABLE_JIT="1")
    assert compiled["compiled"]
    assert not plain["compiled"]
    assert plain["said"] == compiled["said"] == []
    near(plain, compiled)


def test_without_numba_it_is_plain_python_and_says_so_once(compiled: dict) -> None:
    bare = told_by(["stribeck_friction step", "actuator_lag step"], first=BLOCK)
    assert not bare["compiled"]
    (message,) = bare["said"]
    assert "numba cannot be imported" in message
    assert "Install numba" in message
    near(bare, compiled)


@pytest.mark.slow
def test_without_a_cache_it_compiles_in_every_process_and_says_so_once(compiled: dict, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("not a folder")
    nowhere = str(tmp_path / "file" / "cache")
    cases = ["coulomb_friction step", "cubic_stiffness step"]
    found = told_by(cases, NUMBA_CACHE_DIR=nowhere, HOME=nowhere, XDG_CACHE_HOME=nowhere)
    assert found["compiled"]
    (message,) = found["said"]
    assert "no cache for compiled laws can be written" in message
    assert "NUMBA_CACHE_DIR" in message
    near(found, compiled)


@pytest.mark.slow
def test_a_cache_is_filled_and_used(compiled: dict, tmp_path: Path) -> None:
    cases = ["coulomb_friction step"]
    for _ in range(2):
        found = told_by(cases, NUMBA_CACHE_DIR=str(tmp_path))
        assert found["said"] == []
        near(found, compiled)
        kept = sorted((tmp_path / "stepid").glob("coulomb_friction_*.py"))
        assert len(kept) == 1
