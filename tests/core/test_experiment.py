"""The models of what was measured: frozen, exact, equal after a trip through JSON."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stepid import Campaign, Experiment, MassOffset, StepInput
from stepid.errors import InputError, StepidError

N = 10
T = 0.005 * np.arange(N)


def experiment(**fields):
    standard = {
        "name": "case 5",
        "time": T,
        "position": 0.01 * np.arange(N),
        "input": np.full(N, 0.5),
        "added_mass": 0.5,
        "spring": "medium",
        "damper": "1/2 turn",
    }
    return Experiment(**{**standard, **fields})


def test_an_experiment_holds_what_it_was_given():
    run = experiment(counts_per_meter=-226600, input_before=0.1, base="cart and damper")
    np.testing.assert_array_equal(run.time, T)
    assert run.resolution == 1 / 226600
    assert run.sample_time == pytest.approx(0.005)
    assert run.model_copy(update={"time": 2 * T}).sample_time == pytest.approx(0.01)  # computed anew
    assert run.model_copy().sample_time == run.sample_time
    assert (run.base, run.input_before, run.counts_per_meter) == ("cart and damper", 0.1, -226600.0)
    assert experiment().resolution == pytest.approx(0.01)  # that all of its readings lie on
    assert experiment(position=np.sqrt(np.arange(10.0))).resolution is None
    assert experiment().base == "cart"


def test_experiments_are_frozen_to_the_last_number():
    source = np.zeros(N)
    run = experiment(position=source)
    source[0] = 1.0
    assert run.position[0] == 0.0
    with pytest.raises(ValueError, match="read-only"):
        run.position[0] = 1.0
    with pytest.raises(ValueError, match="frozen"):
        run.name = "other"


def test_release_means_no_input_at_all():
    assert experiment(input=np.zeros(N)).is_release
    assert not experiment(input=np.zeros(N), input_before=0.5).is_release
    assert not experiment().is_release


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"name": ""}, "name"),
        ({"name": 5}, "name"),
        ({"time": T[:7], "position": T[:7], "input": T[:7]}, "has 7 samples; a step response needs at least 8"),
        ({"position": T[:9]}, r"differ in length \(10, 9, 10\)"),
        ({"position": np.where(T > 0.02, np.nan, 0.0)}, "position: 5 value.* not finite, the first at index 5"),
        ({"position": np.full(N, np.inf)}, "position: 10 value"),
        ({"input": StepInput(level=0.5)}, r"input: needs numbers, got a StepInput; .* its method values\(time\)"),
        ({"position": ["a"] * N}, "position: needs numbers"),
        ({"position": np.full(N, True)}, "position: needs numbers, got bool"),
        ({"position": np.ones(N) * 1j}, "position: needs numbers, got complex"),
        ({"position": np.zeros((N, 1))}, r"position: needs 1 dimension, got shape \(10, 1\)"),
        ({"position": [[1.0], [1.0, 2.0]]}, "position: not an array"),
        ({"time": T[::-1]}, "time does not increase"),
        ({"time": np.zeros(N)}, "time does not increase"),
        ({"time": np.where(T > 0.02, T - 0.02, T)}, "time does not increase: sample 5 is at 0.005 s after 0.02 s"),
        ({"time": np.round(T, 2)}, r"sample 1 is at 0 s after 0 s; are the times rounded\? Give more digits, or count"),
        ({"time": (np.arange(N) - 4.5) * 3e307}, "time"),
        ({"time": np.where(T > 0.02, 1.5e308, -1.5e308) * (1 + T)}, "time does not increase|not finite"),
        ({"added_mass": -0.5}, "added_mass: .*greater than or equal to 0"),
        ({"added_mass": np.inf}, "added_mass"),
        ({"added_mass": "0.5"}, "added_mass"),
        ({"added_mass": True}, "added_mass"),
        ({"spring": ""}, "spring"),
        ({"damper": None}, "damper"),
        ({"counts_per_meter": 0.0}, "counts_per_meter is zero"),
        ({"counts_per_meter": np.nan}, "counts_per_meter"),
        ({"input_before": np.nan}, "input_before"),
        ({"input_between": "straight"}, "input_between"),
        ({"starts": "moving"}, "starts"),
        ({"mass": 1.0}, "mass: Extra"),
    ],
)
def test_experiments_that_cannot_be(fields, message):
    with pytest.raises(InputError, match=message) as caught:
        experiment(**fields)
    assert isinstance(caught.value, StepidError)
    assert isinstance(caught.value, ValueError)
    if isinstance(fields.get("name", "case 5"), str):
        assert fields.get("name", "case 5") in caught.value.cause


def test_frames_become_experiments():
    pandas = pytest.importorskip("pandas")
    frame = pandas.DataFrame({"t": T, "x": 0.01 * np.arange(N), "input": np.full(N, 0.5), "note": ["a"] * N})
    labels = {"name": "case 5", "added_mass": 0.5, "spring": "medium", "damper": "1/2 turn"}
    assert Experiment.from_dataframe(frame, time="t", position="x", **labels) == experiment()
    whole = Experiment.from_dataframe(
        frame, time="t", position="x", **labels, counts_per_meter=-560.0, input_before=0.1, base="cart and damper"
    )
    assert whole == experiment(counts_per_meter=-560.0, input_before=0.1, base="cart and damper")
    with pytest.raises(InputError, match=r"no column 'time' for time. Name the column with time=…; there are: t, x"):
        Experiment.from_dataframe(frame, position="x", **labels)
    with pytest.raises(InputError, match="position: needs numbers"):
        Experiment.from_dataframe(frame, time="t", position="note", **labels)
    columns = {"time": T, "position": 0.01 * np.arange(N), "input": np.full(N, 0.5)}
    assert Experiment.from_dataframe(columns, **labels) == experiment()
    with pytest.raises(InputError, match="no column 'x' for position"):
        Experiment.from_dataframe(columns, position="x", **labels)


def campaign(*masses, bases=None, **fields):
    bases = bases or ["cart"] * len(masses)
    runs = (
        experiment(name=f"run {i}", added_mass=m, base=b) for i, (m, b) in enumerate(zip(masses, bases, strict=True))
    )
    return Campaign(name="spring 2005", experiments=tuple(runs), **fields)


def test_mass_offsets_of_the_paper():
    offsets = campaign(0.0, 0.5, 1.5, 2.0).mass_offsets
    assert [(o.from_run, o.to_run, o.difference) for o in offsets] == [
        ("run 0", "run 1", 0.5),
        ("run 1", "run 2", 1.0),
        ("run 2", "run 3", 0.5),
    ]
    np.testing.assert_allclose([o.uncertainty for o in offsets], [0.005, 0.005 * np.sqrt(2), 0.005])


def test_mass_offsets_join_runs_by_mass_and_base():
    offsets = campaign(1.5, 0.5, 0.0, 0.5, bases=["a", "a", "b", "a"], weight_uncertainty=0.002).mass_offsets
    assert [(o.from_run, o.to_run, o.difference) for o in offsets] == [("run 1", "run 3", 0.0), ("run 3", "run 0", 1.0)]
    assert offsets[0].uncertainty == 0.0
    assert offsets[1].uncertainty == pytest.approx(0.002 * np.sqrt(2))


def test_campaigns_that_cannot_be():
    with pytest.raises(InputError, match=r"Campaign 'c': holds no experiment"):
        Campaign(name="c", experiments=())
    with pytest.raises(InputError, match="'case 5' is used by more than one run"):
        Campaign(name="c", experiments=(experiment(), experiment()))
    with pytest.raises(InputError, match="weight_uncertainty"):
        campaign(0.0, 0.5, weight_uncertainty=0.0)
    with pytest.raises(InputError, match=r"has no run 'run 9'. Its runs are 'run 0', 'run 1'"):
        campaign(0.0, 0.5)["run 9"]
    assert campaign(0.0, 0.5)["run 1"].added_mass == 0.5


def test_step_inputs():
    assert list(StepInput(level=0.5).values(T)) == [0.5] * N
    assert list(StepInput(level=-0.5, start=0.012, end=0.02).values(T, before=0.1)[:6]) == [
        0.1,
        0.1,
        -0.5,
        -0.5,
        0.1,
        0.1,
    ]
    with pytest.raises(InputError, match="level"):
        StepInput(level=np.nan)
    with pytest.raises(InputError, match="outside the record"):
        StepInput(level=0.5, start=1e300).values(T)


floats = st.floats(allow_nan=False, allow_infinity=False)


@given(
    position=st.lists(floats, min_size=8, max_size=20),
    start=st.floats(-1e3, 1e3),
    period=st.floats(1e-3, 1e3),
    volts=floats,
    scale=st.none() | floats.filter(bool),
    mass=st.floats(0, 1e9),
    label=st.text(min_size=1, max_size=8),
)
@settings(max_examples=60, deadline=None)
def test_json_round_trip(position, start, period, volts, scale, mass, label):
    n = len(position)
    run = experiment(
        name=label,
        time=start + period * np.arange(n),
        position=position,
        input=np.full(n, volts),
        input_before=volts,
        added_mass=mass,
        spring=label,
        counts_per_meter=scale,
    )
    again = Experiment.model_validate_json(run.model_dump_json())
    assert again == run
    assert hash(again) == hash(run)
    assert Experiment.model_validate(run.model_dump()) == run
    whole = Campaign(name=label, experiments=(run,))
    assert Campaign.model_validate_json(whole.model_dump_json()) == whole


@given(floats, floats, st.floats(0, 1e300))
@settings(max_examples=30, deadline=None)
def test_json_round_trip_of_small_models(one, two, spread):
    offset = MassOffset(from_run="a", to_run="b", difference=one, uncertainty=spread)
    assert MassOffset.model_validate_json(offset.model_dump_json()) == offset
    step = StepInput(level=one, start=two, end=None)
    assert StepInput.model_validate_json(step.model_dump_json()) == step


def test_equality_sees_every_field():
    run = experiment()
    others = {
        "name": "x", "time": T + 1, "position": T, "input": T, "added_mass": 1.0, "spring": "x", "damper": "x",
        "counts_per_meter": 1.0, "input_before": 1.0, "base": "x",
        "input_between": "lines", "starts": "motion",
    }  # fmt: skip
    assert others.keys() == Experiment.model_fields.keys()
    for field, value in others.items():
        assert experiment(**{field: value}) != run, field
    assert run != "case 5"


def test_values_are_given_by_name():
    with pytest.raises(TypeError, match=r"Campaign takes its values by name: Campaign\(name=…, experiments=…\)$"):
        Campaign("spring 2005", (experiment(),))
    with pytest.raises(
        TypeError, match=r"Experiment\(name=…, time=…, position=…, input=…, added_mass=…, spring=…, dam"
    ):
        Experiment("case 5", T, T, T)


def test_a_list_of_runs_is_a_campaign():
    runs = [experiment(name="a"), experiment(name="b")]
    campaign = Campaign(name="c", experiments=runs)
    assert campaign.experiments == tuple(runs)
    assert campaign == Campaign.model_validate_json(campaign.model_dump_json())
    with pytest.raises(InputError, match="experiments"):
        Campaign(name="c", experiments=runs[0])


def test_what_is_equal_has_one_hash():
    fields = {"time": 0.1 * np.arange(20), "position": np.arange(20), "added_mass": 0.0, "spring": "s", "damper": "d"}
    zero, minus = (Experiment(name="x", input=z * np.ones(20), **fields) for z in (0.0, -0.0))
    assert zero == minus
    assert hash(zero) == hash(minus)
