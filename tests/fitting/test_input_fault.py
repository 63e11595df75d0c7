"""An input that is plainly joined by lines while its record says held."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lsim

import stepid
from hidden import Run, reference, sets
from stepid.fitting.fit import prepare
from stepid.fitting.input_fault import changes_throughout, find_input_fault

PERIOD, N = 0.0088542, 450
TIME = PERIOD * np.arange(N)
KINDS = ("multisine", "slow", "random", "ramps")


def volts(kind: str, rng: np.random.Generator) -> np.ndarray:
    if kind == "multisine":
        waves = zip((0.4, 1.1, 1.9, 2.7, 4.3), rng.uniform(0, 6, 5), strict=True)
        return 0.15 * np.sum([np.sin(2 * np.pi * f * TIME + p) for f, p in waves], axis=0)
    if kind == "slow":  # begins with a step
        return 0.4 * np.sin(np.pi * TIME + rng.uniform(0, 6))
    if kind == "random":
        return 0.5 * rng.standard_normal(N)
    if kind == "ramps":
        return 0.5 * np.abs(TIME % 2 - 1)
    return np.repeat([0.0, rng.choice([-0.5, 0.5])], [10, N - 10])


def campaign(kind: str, way: str, *, noise: float = 1e-5, truth: str = "lines", delay: float = 0.0) -> stepid.Campaign:
    rng = np.random.default_rng(1)
    runs = []
    for added in (0.0, 0.5, 1.0):
        u, mass = volts(kind, rng), 0.95 + added
        if truth == "lines":
            plant = [[0.0, 1.0], [-216.0 / mass, -6.0 / mass]], [[0.0], [7.8 / mass]], [[1.0, 0.0]], [[0.0]]
            _, y, _ = lsim(plant, u, TIME)
        else:
            effects = {"input_delay": {"delay": delay}} if delay else {}
            y = reference(Run(mass, 216.0, 6.0, 7.8, PERIOD, u, effects))
        runs.append(
            stepid.Experiment(
                name=f"{added:g} kg",
                time=TIME,
                position=y + noise * rng.standard_normal(N),
                input=u,
                added_mass=added,
                spring="s",
                damper="d",
                input_between=way,
            )
        )
    return stepid.Campaign(name=kind, experiments=tuple(runs))


@pytest.mark.parametrize("kind", KINDS)
def test_lines_that_are_said_to_be_held_are_told(kind: str) -> None:
    wrong = campaign(kind, "held")
    found = stepid.diagnose(wrong)
    assert found.verdict == "unexplained"
    assert not found.effects
    assert not found.alternatives
    assert len(found.ranking) == 1  # the search was not started
    assert set(found.wrong_inputs) == {run.name for run in wrong.experiments}
    assert found.summary().splitlines()[1].startswith("No model can be judged: the input of run ")
    assert "joined by straight lines" in found.notes[0]
    assert all(repr(run.name) in found.notes[0] for run in wrong.experiments)
    assert 'input_between="lines"' in (found.next_experiment or "")
    assert sum("input_between='lines'" in note for note in stepid.fit(wrong).notes) == 1


@pytest.mark.parametrize("kind", KINDS)
def test_lines_that_are_said_to_be_lines_are_adequate(kind: str) -> None:
    right = campaign(kind, "lines")
    assert stepid.diagnose(right).verdict == "adequate"
    assert not stepid.fit(right).notes


@pytest.mark.parametrize("kind", [*KINDS, "step"])
def test_held_inputs_are_no_fault(kind: str) -> None:
    context = prepare(campaign(kind, "held", truth="held"))
    assert find_input_fault(context) is None


def test_held_inputs_that_are_said_to_be_lines_are_told() -> None:
    context = prepare(campaign("multisine", "lines", truth="held"))
    fault = find_input_fault(context)
    assert fault is not None
    assert fault.way == "held"
    assert "say 'lines'" in fault.words


@pytest.mark.parametrize("samples", [0.3, 1.0])
def test_a_delay_is_no_fault(samples: float) -> None:
    context = prepare(campaign("random", "held", truth="held", delay=samples * PERIOD))
    assert find_input_fault(context) is None


@pytest.mark.slow
def test_steps_are_not_asked() -> None:
    made = [c for which in ("single", "none") for c, _ in sets.make(sets.requests(which, 15))]
    assert not any(changes_throughout(run) for c in made for run in c.experiments)
    assert not any(changes_throughout(run) for run in campaign("step", "held").experiments)
