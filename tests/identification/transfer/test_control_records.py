"""Records as control.TimeResponseData and back."""

from __future__ import annotations

import control
import matplotlib as mpl
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib import pyplot as plt

import control_example as example
import stepid
from stepid.errors import InputError

LABELS = {"name": "run", "added_mass": 0.5, "spring": "medium", "damper": "plug"}
FINITE = st.floats(-1e6, 1e6, allow_nan=False)


@given(
    st.integers(8, 24).flatmap(
        lambda n: st.tuples(st.lists(FINITE, min_size=n, max_size=n), st.lists(FINITE, min_size=n, max_size=n))
    ),
    st.floats(-100, 100),
    st.floats(1e-4, 1.0),
    st.sampled_from([None, 226600.0, -226600.0]),
    FINITE,
)
@settings(max_examples=60, deadline=None)
def test_an_experiment_comes_back(
    record: tuple[list[float], list[float]], start: float, period: float, counts: float | None, before: float
) -> None:
    run = stepid.Experiment(
        **LABELS,
        time=start + period * np.arange(len(record[0])),
        position=record[0],
        input=record[1],
        counts_per_meter=counts,
        input_before=before,
        base="other",
    )
    data = stepid.to_time_response(run)
    again = stepid.from_time_response(data, **LABELS, counts_per_meter=counts, input_before=before, base="other")
    assert again == run


def test_the_data_are_a_copy() -> None:
    run = example.step_run()
    data = stepid.to_time_response(run)
    data.y[0, 3] = 99.0
    assert run.position[3] == 0.0


def test_a_simulation_is_plotted_beside_the_record() -> None:
    mpl.use("Agg")
    run = example.release_run()
    simulated = example.simulated(example.model(), run)
    shown = stepid.to_time_response(run, position=simulated)
    np.testing.assert_array_equal(shown.outputs, simulated)
    assert shown.title == "release, simulated"
    both = control.combine_time_responses([stepid.to_time_response(run), shown], trace_labels=["measured", "model"])
    axes = both.plot(plot_inputs=False).axes
    lines = [line for ax in axes.flat for line in ax.get_lines() if line.get_xdata().size == run.time.size]
    assert len(lines) == 2
    np.testing.assert_array_equal(lines[0].get_ydata(), run.position)
    np.testing.assert_array_equal(lines[1].get_ydata(), simulated)
    plt.close("all")


def test_one_record_is_plotted_with_its_input() -> None:
    mpl.use("Agg")
    axes = stepid.to_time_response(example.step_run()).plot().axes
    assert [ax.get_ylabel() for ax in axes.flat] == ["position", "voltage"]
    plt.close("all")


def test_controls_step_response_becomes_an_experiment() -> None:
    g = stepid.transfer_function(example.model(), example.step_run())
    data = control.step_response(g, np.linspace(0, 2, 401))
    run = stepid.from_time_response(data, **LABELS)
    np.testing.assert_array_equal(run.input, np.ones(401))
    np.testing.assert_array_equal(run.position, np.ravel(data.outputs))
    assert stepid.characterize(run).static_gain == pytest.approx(7.8 / 216.0, rel=1e-3)


def test_an_initial_response_is_a_release() -> None:
    s = stepid.state_space(example.model(), example.step_run())
    run = stepid.from_time_response(control.initial_response(s, np.linspace(0, 2, 401), [0.02, 0.0]), **LABELS)
    assert run.is_release
    assert run.position[0] == 0.02


def test_a_simulated_system_becomes_an_experiment() -> None:
    run = example.step_run()
    data = stepid.simulate_system(stepid.nonlinear_system(example.model("cubic_stiffness"), run), run)
    again = stepid.from_time_response(data, **LABELS)
    np.testing.assert_array_equal(again.input, run.input)
    assert again.sample_time == pytest.approx(run.sample_time, rel=1e-12)


def _many() -> control.TimeResponseData:
    system = control.ss(
        [[0.0, 1.0], [-144.0, -3.0]],
        [[0.0, 0.0], [5.0, 1.0]],
        np.eye(2),
        np.zeros((2, 2)),
        inputs=["voltage", "push"],
        outputs=["position", "velocity"],
    )
    return control.step_response(system, np.linspace(0, 2, 101))


def test_several_outputs_inputs_and_traces_need_a_choice() -> None:
    data = _many()
    with pytest.raises(InputError, match=r"have 2 traces.*trace=….*0 .*, 1 "):
        stepid.from_time_response(data, **LABELS)
    with pytest.raises(InputError, match=r"have 2 outputs.*output=….*0 \('position'\), 1 \('velocity'\)"):
        stepid.from_time_response(data, **LABELS, trace=0)
    with pytest.raises(InputError, match=r"have 2 inputs.*input=….*0 \('voltage'\), 1 \('push'\)"):
        stepid.from_time_response(data, **LABELS, trace=0, output="position")
    run = stepid.from_time_response(data, **LABELS, trace=1, output="position", input="push")
    np.testing.assert_array_equal(run.position, data.y[0, 1])
    np.testing.assert_array_equal(run.input, np.ones(101))
    other = stepid.from_time_response(data, **LABELS, trace=data.trace_labels[0], output=1, input=1)
    np.testing.assert_array_equal(other.position, data.y[1, 0])
    np.testing.assert_array_equal(other.input, np.zeros(101))


@pytest.mark.parametrize("choice", [2, -1, "acceleration", 0.0])
def test_a_choice_that_is_not_there_is_refused(choice: object) -> None:
    with pytest.raises(InputError, match=r"have no output .*There are: 0 \('position'\)"):
        stepid.from_time_response(_many(), **LABELS, trace=0, output=choice)  # type: ignore[arg-type]


def test_combined_responses_are_chosen_by_trace() -> None:
    run = example.release_run()
    shown = stepid.to_time_response(run, position=example.simulated(example.model(), run))
    both = control.combine_time_responses([stepid.to_time_response(run), shown], trace_labels=["measured", "model"])
    again = stepid.from_time_response(both, **LABELS, trace="model")
    np.testing.assert_array_equal(again.position, shown.outputs)
    np.testing.assert_array_equal(again.input, run.input)


def test_what_cannot_be_right_is_refused() -> None:
    run = example.step_run()
    with pytest.raises(InputError, match="has 160 samples, the position handed over has shape"):
        stepid.to_time_response(run, position=np.zeros(7))
    data = stepid.to_time_response(run)
    with pytest.raises(InputError, match="have no traces"):
        stepid.from_time_response(data, **LABELS, trace=0)
    uneven = control.TimeResponseData(np.arange(10.0) ** 2, np.zeros(10), inputs=np.zeros(10), issiso=True)
    with pytest.raises(InputError, match="uneven in time, and python-control steps evenly"):
        stepid.simulate_system(control.tf([1.0], [1.0, 1.0]), stepid.from_time_response(uneven, **LABELS))
    failed = control.TimeResponseData(
        run.time, run.position, inputs=run.input, issiso=True, success=False, message="step size too small"
    )
    with pytest.raises(InputError, match=r"simulation that failed.*step size too small"):
        stepid.from_time_response(failed, **LABELS)
