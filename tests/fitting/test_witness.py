"""Runs that alone show what a law does: of no other run's input, or travel."""

from __future__ import annotations

import numpy as np

import stepid
from stepid.effects import resolve
from stepid.fitting.run_fault import is_witness
from stepid.simulation.records import lay_out


def test_a_run_whose_input_no_other_has_is_the_only_witness_of_a_law_there() -> None:
    """Beside a linear plant in the middle, too, nothing is seen that those on both sides do not show."""
    t = 0.01 * np.arange(60)
    runs = tuple(
        stepid.Experiment(
            name=f"{i}", time=t, position=1e-3 * np.sin(t), input=np.where(t < 0.1, 0.0, size), added_mass=0.0,
            spring="s", damper="d",
        )
        for i, size in enumerate((0.5, -1.0, 2.0, 0.0))
    )  # fmt: skip
    records = lay_out(stepid.Campaign(name="c", experiments=runs))
    assert [is_witness(records, run, beside=()) for run in range(4)] == [True, False, True, False]
    effects = resolve(["actuator_saturation"])
    assert [is_witness(records, run, beside=effects) for run in range(4)] == [True, True, True, False]
    more = stepid.Campaign(name="c", experiments=(*runs, runs[1].model_copy(update={"name": "4", "spring": "t"})))
    assert not any(is_witness(lay_out(more), run, beside=effects) for run in (1, 4))


def test_a_release_that_travels_as_no_other_run_is_such_a_witness() -> None:
    """Of 1, 2, 2.2 and 4 mm: beside effects, and the farthest and the shortest beside a linear plant."""
    t = 0.01 * np.arange(400)
    runs = tuple(
        stepid.Experiment(
            name=f"{i}", time=t, position=1e-3 * size * np.cos(5.0 * t), input=np.zeros(t.size), added_mass=0.0,
            spring="s", damper="d",
        )
        for i, size in enumerate((1.0, 2.0, 2.2, 4.0, 3.0))
    )  # fmt: skip
    records = lay_out(stepid.Campaign(name="c", experiments=runs[:4]))
    assert [is_witness(records, run, beside=()) for run in range(4)] == [True, False, False, True]
    assert [is_witness(records, run, beside=resolve(["sine_stiffness"])) for run in range(4)] == [
        True, False, False, True,
    ]  # fmt: skip
    records = lay_out(stepid.Campaign(name="c", experiments=(runs[0], runs[1], runs[3])))
    assert [is_witness(records, run, beside=()) for run in range(3)] == [True, False, True]
    assert all(is_witness(records, run, beside=resolve(["sine_stiffness"])) for run in range(3))
