"""Tables whose columns are not what they are read as: units, travel, an input that nobody named."""

import numpy as np
import pytest

import stepid
from closed_form import Plant, make_run
from exports import write
from stepid import Experiment, StepInput, read_table
from stepid.core.units import check_speed
from stepid.errors import InputError
from table_text import CM, T, U, text

PLANT = Plant(base_mass=0.954, stiffness=216.2, damping=14.0)


@pytest.mark.parametrize(("name", "scale"), [("position_mm", "0.001"), ("x [cm]", "0.01"), ("travel (um)", "1e-06")])
def test_a_column_that_says_it_is_not_in_meters(tmp_path, name, scale):
    """Else masses and stiffness look right and every length is a thousand times too large."""
    file = tmp_path / "run.csv"
    rows = [f"{0.01 * i:.2f},{np.sin(0.1 * i):.6f},1" for i in range(40)]
    file.write_text("\n".join([f"t,{name},u", *rows]))
    with pytest.raises(InputError, match=rf"by its name.*position_scale = {scale}"):
        read_table(file, time="t", position=name, input="u", name="run", added_mass=0.0, spring="s", damper="d")
    run = read_table(
        file,
        time="t",
        position=name,
        position_scale=float(scale),
        input="u",
        name="run",
        added_mass=0.0,
        spring="s",
        damper="d",
    )
    assert run.position[1] == pytest.approx(float(scale) * np.sin(0.1), abs=1e-6 * float(scale))


def test_all_scales_that_names_belie_are_named_at_once(tmp_path):
    file = write(tmp_path / "run.csv", text(1000 * T, CM, U, mark=",", head="t_ms,x_cm,u"))
    with pytest.raises(InputError) as caught:
        read_table(file, time="t_ms", position="x_cm", input="u")
    for said in ("'x_cm' is in cm by its name, but position_scale is 1; ", "'t_ms' is in ms by its name"):
        assert said in caught.value.cause
    assert "position_scale = 0.01 (meters" in caught.value.remedy
    assert "time_scale = 0.001 (seconds per unit)." in caught.value.remedy


@pytest.mark.parametrize(
    ("name", "scale", "factor", "message"),
    [
        ("x", 1000.0, 1.0, r"with position_scale = 1000 the positions span 5.45e\+03 m, which is no plant's travel"),
        ("counts", 226600.0, 560.0, r"the positions span \d.*1 / counts_per_meter for counts"),
        ("x", 1e-9, 1e-3, r"with position_scale = 1e-09 the positions span 5.45e-12 m"),
        ("x_mm", 1000.0, 10.0, r"'x_mm' is in mm by its name, but position_scale is 1000. Give position_scale = 0.001"),
        ("x_mm", -1.0, 10.0, r"'x_mm' is in mm by its name, but position_scale is -1"),
    ],
)
def test_a_scale_the_wrong_way_round_is_named(tmp_path, name, scale, factor, message):
    file = write(tmp_path / "run.csv", text(T, CM * factor, U, mark=",", head=f"t,{name},u"))
    with pytest.raises(InputError, match=message):
        read_table(file, time="t", position=name, input="u", position_scale=scale)


@pytest.mark.parametrize("use", [stepid.identify, stepid.fit, stepid.diagnose])
def test_millimeters_taken_for_meters(use):
    """Under a neutral name nothing else shows them: a cart that swings 25 m, 3 times a second."""
    runs = [make_run(PLANT, added, name=f"{added:g} kg") for added in (0.0, 0.5)]
    wrong = [run.model_copy(update={"position": 1e3 * run.position}) for run in runs]
    with pytest.raises(InputError, match=r"run '0 kg': its positions move at 1\d\d m/s, which is no plant's speed"):
        use(stepid.Campaign(name="mm", experiments=wrong))


def test_speed_is_that_of_the_plant_and_not_of_its_readings():
    """A heavy rig's swing of meters, a coarse sensor at 100 kHz and lost readings are no reason to refuse."""
    rng = np.random.default_rng(1)
    time = 1e-5 * np.arange(4000)
    rig = 5.0 * (1 - np.cos(20.0 * time)) + 1e-3 * rng.standard_normal(time.size)
    rig[[500, 1700]] = 0.0, 90.0
    check_speed(rig, 1e-5, "the rig's positions")
    with pytest.raises(InputError, match=r"the rig's positions move at .* Positions are in meters, time in seconds"):
        check_speed(rig, 1e-6, "the rig's positions")


@pytest.mark.parametrize(
    "name",
    ["u", "U", "u [V]", "input", "input_V", "voltage_V", "Voltage", "volts", "Control Effort", "motor (V)", "drive_mV"],
)
def test_an_input_that_is_not_named_is_no_release(tmp_path, name):
    """Else a step that was read without its input passes for a free release, and the drive is never identified."""
    file = write(tmp_path / "run.csv", text(T, CM, U, mark=",", head=f"t,x,{name}"))
    with pytest.raises(InputError) as caught:
        read_table(file, time="t", position="x", position_scale=0.01)
    assert f"run.csv: no input is named, so this would be a free release, but the column {name!r}" in caught.value.cause
    assert f"Give input = {name!r}" in caught.value.remedy
    assert read_table(file, time=0, position=1, input=2, position_scale=0.01).input[-1] == U[-1]
    assert read_table(file, time=0, position=1, input=StepInput(level=0.0), position_scale=0.01).is_release


@pytest.mark.parametrize(
    "name", ["acceleration", "unit", "update", "force_N", "V_x", "encoder 2", "Commanded Pos", "x_um"]
)
def test_other_columns_leave_a_release_a_release(tmp_path, name):
    file = write(tmp_path / "run.csv", text(T, CM, U, mark=",", head=f"t,x,{name}"))
    assert read_table(file, time="t", position="x", position_scale=0.01).is_release


def test_an_input_column_of_zeros_is_a_release(tmp_path):
    file = write(tmp_path / "run.csv", text(T, CM, 0 * U, mark=",", head="t,x,u"))
    assert read_table(file, time="t", position="x", position_scale=0.01).is_release


@pytest.mark.parametrize(
    ("names", "message"),
    [
        ("time_ms,x,u", r"'time_ms' is in ms by its name, but time_scale is 1. Give time_scale = 0.001"),
        ("t [µs],x,u", r"'t \[µs\]' is in µs by its name.*time_scale = 1e-06"),
        ("t,x,drive (mV)", r"'drive \(mV\)' is in mV by its name.*input_scale = 0.001"),
    ],
)
def test_a_time_or_input_that_says_it_is_not_in_si_units(tmp_path, names, message):
    time, position, volts = names.split(",")
    file = write(tmp_path / "run.csv", text(T, CM, U, mark=",", head=names))
    with pytest.raises(InputError, match=message):
        read_table(file, time=time, position=position, input=volts)
    milli = {"time_scale": 1e-3, "input_scale": 1e-3}
    assert read_table(file, time=time, position=position, input=volts, **milli).time.size == 100


@pytest.mark.parametrize(
    ("column", "role", "factor"),
    [("x_mm", "position", "0.001"), ("millis", "time", "0.001"), ("drive [mV]", "input", "0.001")],
)
def test_a_frames_column_that_says_it_is_not_in_si_units(column, role, factor):
    columns = {"time": "t", "position": "x", "input": "u"} | {role: column}
    frame = dict(zip(columns.values(), (T, CM, U), strict=True))
    labels = {"name": "a", "added_mass": 0.0, "spring": "s", "damper": "d"}
    with pytest.raises(
        InputError, match=rf"run 'a': .* by its name, but {role}_scale is 1. Give {role}_scale = {factor}"
    ):
        Experiment.from_dataframe(frame, **columns, **labels)
    scaled = Experiment.from_dataframe(frame, **columns, **labels, **{f"{role}_scale": float(factor)})
    frame["si"] = float(factor) * frame[column]
    run = Experiment.from_dataframe(frame, **(columns | {role: "si"}), **labels)
    np.testing.assert_array_equal(getattr(run, role), frame["si"])
    assert scaled == run
