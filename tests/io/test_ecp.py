"""ECP exports in every variant that labs pass on."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from exports import NAMES, PERIOD, columns_of, export_bytes, motion, rows_of, write
from stepid import StepInput, read_ecp
from stepid.errors import InputError

SCALE = 56000.0
X, U = motion()


def check(experiment, encoder_factor=1.0, n=300):
    assert experiment.time.size == n
    np.testing.assert_array_equal(experiment.position, np.rint(encoder_factor * X[:n]) / SCALE)
    np.testing.assert_array_equal(experiment.input, U[:n])
    assert experiment.sample_time == pytest.approx(PERIOD, abs=2e-7)
    assert experiment.sample_time != pytest.approx(0.009, abs=1e-4)


@pytest.mark.parametrize("newline", ["\r\n", "\n", "\r"])
@pytest.mark.parametrize("end", [True, False])
@pytest.mark.parametrize("mark", [b"", b"\xef\xbb\xbf"])
def test_raw_export(tmp_path, newline, end, mark):
    file = write(tmp_path / "case 5.txt", mark + export_bytes(newline=newline, end=end))
    experiment = read_ecp(file, counts_per_meter=SCALE, added_mass=0.5, spring="medium", damper="1/2 turn")
    check(experiment)
    assert experiment.name == "case 5"
    assert (experiment.added_mass, experiment.spring, experiment.damper) == (0.5, "medium", "1/2 turn")
    assert experiment.resolution == 1 / SCALE


@pytest.mark.parametrize("layout", ["stc1u", "stc12u", "st12u", "st1u", "stc123u"])
def test_columns_present_vary(tmp_path, layout):
    file = write(tmp_path / "a.txt", export_bytes(layout))
    check(read_ecp(file, counts_per_meter=SCALE))
    if "2" in layout:
        check(read_ecp(str(file), counts_per_meter=SCALE, encoder=2), 0.4)


def test_only_another_encoder_is_read(tmp_path):
    data = columns_of("stc1u")
    data = {"s": data["s"], "t": data["t"], "c": np.full(300, 6.0), "2": data["1"], "u": np.zeros(300)}
    file = write(tmp_path / "a.txt", export_bytes("stc2u", rows=rows_of(data)))
    experiment = read_ecp(file, counts_per_meter=SCALE, encoder=2)
    assert experiment.is_release
    with pytest.raises(InputError, match=r"no column 'Encoder 1 Pos'.*has Encoder 2 Pos"):
        read_ecp(file, counts_per_meter=SCALE)


def test_minus_zero_is_zero(tmp_path):
    content = export_bytes().replace(b"               0          0.0000", b"              -0         -0.0000")
    assert b"-0 " in content
    file = write(tmp_path / "a.txt", content)
    for scale in (SCALE, -SCALE):
        experiment = read_ecp(file, counts_per_meter=scale)
        assert np.count_nonzero(experiment.position == 0) >= 2
        assert not np.signbit(experiment.position[experiment.position == 0]).any()
        assert not np.signbit(experiment.input[0])


@pytest.mark.parametrize("period", [0.0088542, 0.00113, 0.0095032116, 0.02])
def test_sample_time_is_rebuilt_from_sample(tmp_path, period):
    file = write(tmp_path / "a.txt", export_bytes(n=677, period=period))
    experiment = read_ecp(file, counts_per_meter=SCALE)
    assert experiment.sample_time == pytest.approx(period, abs=2e-7)
    assert experiment.time[0] == 0
    given = read_ecp(file, counts_per_meter=SCALE, sample_time=period)
    np.testing.assert_array_equal(given.time, np.arange(677) * period)


def test_record_that_starts_late_keeps_its_clock(tmp_path):
    file = write(tmp_path / "a.txt", export_bytes(first_sample=1000))
    experiment = read_ecp(file, counts_per_meter=SCALE)
    assert experiment.time[0] == pytest.approx(1000 * PERIOD, abs=1e-3)


def test_clock_with_an_offset_is_kept_to_whole_samples(tmp_path):
    data = columns_of("stc1u")
    data["t"] = data["t"] + 2.0
    file = write(tmp_path / "a.txt", export_bytes(rows=rows_of(data)))
    assert read_ecp(file, counts_per_meter=SCALE).time[0] == pytest.approx(2.0, abs=PERIOD)


def test_short_records_need_the_sample_time(tmp_path):
    file = write(tmp_path / "a.txt", export_bytes(n=12))
    with pytest.raises(InputError, match=r"12 rows with Time rounded to 0.001 s .* ± .* ms.*sample_time"):
        read_ecp(file, counts_per_meter=SCALE)
    assert read_ecp(file, counts_per_meter=SCALE, sample_time=PERIOD).sample_time == pytest.approx(PERIOD)


def test_wrong_sample_time_is_told(tmp_path):
    file = write(tmp_path / "a.txt", export_bytes())
    with pytest.raises(InputError, match=r"given as 0.009 s, but its Time column says 0.00885"):
        read_ecp(file, counts_per_meter=SCALE, sample_time=0.009)


# the paper's figures


def paper_rows(n=300):
    return [" ".join(row.split()) for row in rows_of(columns_of("stc12", n))]


def figure_4(rows):
    return "C:\\MATLAB6p5\\toolbox\\local\\btb01hz.m\n[\n" + "\n".join(rows) + "\n]\n"


def figure_5(rows):
    names = "% " + " ".join(NAMES[letter] for letter in "stc123")
    return "/toolbox/local/btb01hz.m\n" + names + "\ndat = [\n" + "\n".join(rows) + "\n]\n"


FIVE = ("Sample", "Time", "Commanded Pos", "Encoder 1 Pos", "Encoder 2 Pos")
STEP = StepInput(level=0.5, start=PERIOD)


def test_figure_4_is_read_once_its_columns_are_stated(tmp_path):
    file = write(tmp_path / "btb01hz.m", figure_4(paper_rows()))
    with pytest.raises(InputError, match=r"no header says what its 5 columns are.*columns="):
        read_ecp(file, counts_per_meter=SCALE, input=STEP)
    check(read_ecp(file, counts_per_meter=SCALE, input=STEP, columns=FIVE))


def test_figure_5_is_asked_about(tmp_path):
    file = write(tmp_path / "btb01hz.m", figure_5(paper_rows()))
    with pytest.raises(InputError, match=r"names 6 columns .* over 5 numbers a row\. Which columns.*columns="):
        read_ecp(file, counts_per_meter=SCALE, input=STEP)
    check(read_ecp(file, counts_per_meter=SCALE, input=STEP, columns=FIVE))
    check(read_ecp(file, counts_per_meter=SCALE, input=STEP, columns=[c.lower() for c in FIVE], encoder=2), 0.4)


def test_paper_layout_with_a_true_header(tmp_path):
    rows = [" ".join(row.split()) for row in rows_of(columns_of("stc123"))]
    check(read_ecp(write(tmp_path / "a.m", figure_5(rows)), counts_per_meter=SCALE, input=STEP))
    behind = figure_5(rows).replace("dat = [", "").replace("% Sample", "dat = [ % Sample")
    check(read_ecp(write(tmp_path / "b.m", behind), counts_per_meter=SCALE, input=STEP))
    inside = figure_5(rows).replace("dat = [\n", "").replace("% Sample", "[ Sample")
    check(read_ecp(write(tmp_path / "c.m", inside), counts_per_meter=SCALE, input=STEP))
    remark = figure_5(rows).replace("dat = [", "dat = [ % all in [counts]")
    check(read_ecp(write(tmp_path / "e.m", remark), counts_per_meter=SCALE, input=STEP))
    script = figure_5(rows).replace("\n]", "\n];  % done\nplot(dat(:,2), dat(:,4))\n")
    check(read_ecp(write(tmp_path / "d.m", script), counts_per_meter=SCALE, input=STEP))


def test_no_effort_needs_the_input(tmp_path):
    file = write(tmp_path / "a.txt", export_bytes("stc123"))
    with pytest.raises(InputError, match=r"no Control Effort column.*input=StepInput\(level=0.5, start=0.0\)"):
        read_ecp(file, counts_per_meter=SCALE)
    check(read_ecp(file, counts_per_meter=SCALE, input=STEP))
    check(read_ecp(file, counts_per_meter=SCALE, input=U))
    check(read_ecp(file, counts_per_meter=SCALE, input=list(U)))
    back = read_ecp(file, counts_per_meter=SCALE, input=StepInput(level=0.5, start=0.009, end=1.0), input_before=-0.1)
    assert list(back.input[[0, 1, 112, 113, -1]]) == [-0.1, 0.5, 0.5, -0.1, -0.1]  # 1.0 s is sample 112.94


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (StepInput(level=0.5, start=99.0), "starts at 99 s, outside the record"),
        (StepInput(level=0.5, start=-1.0), "starts at -1 s, outside the record"),
        (StepInput(level=0.5, start=1.0, end=0.5), "not after its start"),
        ([0.5, 0.5], r"input has shape \(2,\)"),
        (["a"] * 300, "input has shape"),
        ([[1.0], [1.0, 2.0]], "not an array"),
        ([np.nan] * 300, "not finite"),
    ],
)
def test_input_that_cannot_be(tmp_path, given, message):
    file = write(tmp_path / "a.txt", export_bytes("stc123"))
    with pytest.raises(InputError, match=message):
        read_ecp(file, counts_per_meter=SCALE, input=given)


def test_input_must_agree_with_the_effort_column(tmp_path):
    file = write(tmp_path / "a.txt", export_bytes())
    check(read_ecp(file, counts_per_meter=SCALE, input=STEP))
    with pytest.raises(
        InputError, match=r"line 3: the StepInput given as input says 0.5 V, the Control Effort column 0"
    ):
        read_ecp(file, counts_per_meter=SCALE, input=StepInput(level=0.5, start=0.0))


# files without header, and the newer program


def headless(layout):
    return "[" + "\n".join(rows_of(columns_of(layout)))[1:] + "]\n"


@pytest.mark.parametrize("layout", ["stc1u", "stc12u", "stc123"])
def test_missing_header_is_told_from_the_content(tmp_path, layout):
    file = write(tmp_path / "a.txt", headless(layout))
    check(read_ecp(file, counts_per_meter=SCALE, input=STEP))


@pytest.mark.parametrize("layout", ["st12u", "stc2u", "st123", "st1u", "stc12"])
def test_missing_header_is_asked_about_otherwise(tmp_path, layout):
    file = write(tmp_path / "a.txt", headless(layout))
    with pytest.raises(InputError, match="no header says"):
        read_ecp(file, counts_per_meter=SCALE, encoder=int(layout[-2]) if layout[-1] == "u" else 1, input=STEP)
    stated = [NAMES[letter] for letter in layout]
    read = read_ecp(file, counts_per_meter=SCALE, encoder=2 if "2" in layout else 1, input=STEP, columns=stated)
    assert read.time.size == 300


def test_rows_without_brackets(tmp_path):
    rows = rows_of(columns_of("stc1u"))
    check(read_ecp(write(tmp_path / "a.txt", "\n".join(rows)), counts_per_meter=SCALE))
    check(
        read_ecp(
            write(tmp_path / "b.txt", "% " + "  ".join(NAMES[c] for c in "stc1u") + "\n" + "\n".join(rows)),
            counts_per_meter=SCALE,
        )
    )


def tabbed(per_volt):
    data = columns_of("st12u", n=400, period=0.00113, first_sample=1, wn=100.0)
    data["u"] = data["u"] * per_volt
    head = "\t".join(NAMES[letter] for letter in "st12u")
    rows = [
        "\t".join(f"{v:.12g}" for v in (s, round(t, 3), a, b, u)) for s, t, a, b, u in zip(*data.values(), strict=True)
    ]
    return head + "\n" + "\n".join(rows) + "\n", data


def test_newer_program(tmp_path):
    text, data = tabbed(4095 / 5)
    experiment = read_ecp(write(tmp_path / "a.txt", text), counts_per_meter=SCALE, encoder=2)
    np.testing.assert_allclose(experiment.input, data["u"] * 5 / 4095, rtol=1e-12)
    assert experiment.input.max() == pytest.approx(0.5)
    assert experiment.sample_time == pytest.approx(0.00113, abs=2e-6)
    assert experiment.time[0] == pytest.approx(0.00113, rel=1e-3)


def test_the_newer_program_s_uneven_stamps_are_taken_as_they_are(tmp_path):
    text, _ = tabbed(4095 / 5)
    head, *rows = text.splitlines()
    stamps = [0.001 * (n + 5 * (n // 50)) for n in range(1, len(rows) + 1)]  # it pauses now and then
    rows = [
        "\t".join([row.split("\t")[0], f"{t:.3f}", *row.split("\t")[2:]]) for row, t in zip(rows, stamps, strict=True)
    ]
    experiment = read_ecp(write(tmp_path / "a.txt", "\n".join([head, *rows]) + "\n"), counts_per_meter=SCALE)
    np.testing.assert_allclose(experiment.time, stamps, rtol=1e-12)


def test_doubtful_units_of_effort_are_asked_about(tmp_path):
    text, _ = tabbed(1.0)
    volts = write(tmp_path / "a.txt", text)
    with pytest.raises(InputError, match=r"DAC units.*stays below 0.5 as volts would.*effort_scale"):
        read_ecp(volts, counts_per_meter=SCALE)
    assert read_ecp(volts, counts_per_meter=SCALE, effort_scale=1).input.max() == 0.5
    dac = write(tmp_path / "b.txt", export_bytes(level=409.5, counts=5.0))
    with pytest.raises(InputError, match=r"reaches 409.5, too much for volts.*effort_scale"):
        read_ecp(dac, counts_per_meter=SCALE)
    assert read_ecp(dac, counts_per_meter=SCALE, effort_scale=5 / 4095).input.max() == pytest.approx(0.5)


# closed loop


def closed_loop(n=300, kp=2e-3):
    """A proportional loop around a plant of second order, stepped coarsely: enough to look like one."""
    x, v, rows = 0.0, 0.0, []
    for i in range(n):
        u = kp * (1000.0 - x)
        v += PERIOD * (225 * 4000 * u - 6 * v - 225 * x)
        x += PERIOD * v
        rows.append((i, i * PERIOD, 1000.0, round(x), round(0.5 * x), u))
    return dict(zip("stc12u", np.array(rows).T, strict=True))


@pytest.mark.parametrize("layout", ["stc1u", "stc12u", "stc2u", "stc12"])
def test_closed_loop_moves_are_refused(tmp_path, layout):
    data = closed_loop()
    file = write(tmp_path / "a.txt", export_bytes(layout, rows=rows_of({k: data[k] for k in layout})))
    encoder = 1 if "1" in layout else 2
    with pytest.raises(InputError, match=r"closed-loop move: Commanded Pos is a set-point \(from 1000 to 1000\)"):
        read_ecp(file, counts_per_meter=SCALE, encoder=encoder, input=None if "u" in layout else STEP)
    renamed = [NAMES[k] if k != "c" else "set-point" for k in layout]
    read = read_ecp(
        file, counts_per_meter=SCALE, encoder=encoder, input=None if "u" in layout else STEP, columns=renamed
    )
    assert read.time.size == 300


@given(st.floats(-1e6, 1e6).filter(lambda c: abs(c) > 1e-3))
@settings(max_examples=25, deadline=None)
def test_sign_of_the_scale_turns_the_record(tmp_path_factory, scale):
    file = write(tmp_path_factory.mktemp("sign") / "a.txt", export_bytes(n=60))
    plus = read_ecp(file, counts_per_meter=scale)
    minus = read_ecp(file, counts_per_meter=-scale)
    np.testing.assert_array_equal(plus.position, -minus.position)
    np.testing.assert_array_equal(plus.input, minus.input)
    assert plus.resolution == minus.resolution
    assert type(plus).model_validate_json(plus.model_dump_json()) == plus
