"""Ten thousand random corruptions of good files: whatever happens, only the library's own errors come out."""

import random

import numpy as np
import pytest

from exports import columns_of, export_bytes, motion, rows_of, write
from stepid import StepInput, read_campaign, read_ecp, read_table
from stepid.errors import StepidError

SCALE = 56000.0
N = 40  # rows: short, so that damage to brackets and header is as likely as to numbers
WORDS = [
    b"NaN", b"-inf", b"1e999", b"1e308", b"-1e-320", b"99999999999999999999", b"-", b".", b"e", b"0x1f", b"1_000",
    b"1,5", b"\xff", b"\xc3\xa9", b"\xe2\x88\x92", b"\0", b"[", b"]", b"];", b"%", b"#", b"=", b'"', b"'", b"\\u0000",
    b"\r", b"\n", b"\r\n", b"\t", b"\x0b", b"\xe2\x80\xa8", b"  ", b"Sample", b"Encoder 99999999999999999999 Pos",
    b"Time", b"nan", b"true", b"1979-05-27", b"[[experiment]]", b"{", b"}", b"-5", b"0", b"0.0", b'"case4.txt"',
    b'"../"', b"\xef\xbb\xbf", b"\xd9\xa3", b"1" * 400, b"1" * 5000, b"[" * 3000,
]  # fmt: skip


def corrupt(raw, rng):
    """Apply one to three random acts of damage."""
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        raw = rng.choice(ACTS)(raw, rng)
    return raw


def flip(raw, rng):
    i = rng.randrange(len(raw) or 1)
    return raw[:i] + bytes([rng.randrange(256)]) + raw[i + 1 :]


def cut(raw, rng):
    i, n = rng.randrange(len(raw) + 1), rng.choice((1, 2, 10, 100, 1000))
    return raw[:i] + raw[i + n :]


def truncate(raw, rng):
    return raw[: rng.randrange(len(raw) + 1)]


def behead(raw, rng):
    return raw[rng.randrange(len(raw) + 1) :]


def insert(raw, rng):
    i = rng.randrange(len(raw) + 1)
    return raw[:i] + rng.choice(WORDS) + raw[i:]


def replace_token(raw, rng):
    tokens = raw.split(b" ")
    tokens[rng.randrange(len(tokens))] = rng.choice(WORDS)
    return b" ".join(tokens)


def replace_digit(raw, rng):
    places = [i for i, byte in enumerate(raw) if 48 <= byte < 58]
    if not places:
        return raw
    i = rng.choice(places)
    return raw[:i] + rng.choice(b"0123456789.-e ,").to_bytes(1, "big") + raw[i + 1 :]


def lines_of(raw, rng, change):
    lines = raw.split(b"\n")
    change(lines, rng.randrange(len(lines)), rng.randrange(len(lines)))
    return b"\n".join(lines)


def drop_line(raw, rng):
    return lines_of(raw, rng, lambda lines, i, _: lines.pop(i))


def double_line(raw, rng):
    return lines_of(raw, rng, lambda lines, i, j: lines.insert(j, lines[i]))


def swap_lines(raw, rng):
    return lines_of(raw, rng, lambda lines, i, j: lines.__setitem__(slice(None), swapped(lines, i, j)))


def swapped(lines, i, j):
    lines = list(lines)
    lines[i], lines[j] = lines[j], lines[i]
    return lines


def noise(raw, rng):
    i = rng.randrange(len(raw) + 1)
    return raw[:i] + rng.randbytes(rng.randrange(1, 40)) + raw[i:]


ACTS = (
    flip, cut, truncate, behead, insert, insert, replace_token, replace_token, replace_digit, replace_digit,
    drop_line, double_line, swap_lines, noise,
)  # fmt: skip

X, U = motion(N)
TABLE = "t,x,u\n" + "".join(
    f"{0.005 * i!r},{float(x)!r},{float(u)!r}\n" for i, (x, u) in enumerate(zip(X, U, strict=True))
)
PLAIN = [" ".join(row.split()) for row in rows_of(columns_of("stc123", N))]
SCRIPT = "% Sample Time Commanded Pos Encoder 1 Pos Encoder 2 Pos Encoder 3 Pos\ndat = [\n" + "\n".join(PLAIN) + "\n]\n"
MANIFEST = """\
name = "spring 2005"
counts_per_meter = 56000
weight_uncertainty = 0.005

[[experiment]]
name = "case 4"
file = "case4.txt"
added_mass = 0
spring = "medium"
damper = "1/2 turn"
base = "cart"
encoder = 1
sample_time = 0.0088542

[[experiment]]
name = "case 5"
format = "table"
files = ["run.csv"]
time = "t"
position = "x"
position_scale = 0.01
step = { level = 0.5, start = 0.1 }
added_mass = 0.5
spring = "medium"
damper = "1/2 turn"
"""
STEP = StepInput(level=0.5, start=0.0088542)
KINDS = {
    "raw": ("a.txt", export_bytes(n=N), lambda p: read_ecp(p, counts_per_meter=SCALE)),
    "two encoders": (
        "a.txt",
        export_bytes("stc12u", n=N, newline="\n"),
        lambda p: read_ecp(p, counts_per_meter=-SCALE, encoder=2, sample_time=0.0088542),
    ),
    "script": ("a.m", SCRIPT.encode(), lambda p: read_ecp(p, counts_per_meter=SCALE, input=STEP)),
    "table": ("a.csv", TABLE.encode(), lambda p: read_table(p, time="t", position="x", input="u")),
    "manifest": ("campaign.toml", MANIFEST.encode(), read_campaign),
}


def bombard(tmp_path, kind, count, seed):
    """Corrupt and read `count` times; return how many were read in spite of the damage."""
    name, good, read = KINDS[kind]
    write(tmp_path / "case4.txt", export_bytes(n=N))
    write(tmp_path / "run.csv", TABLE)
    file = write(tmp_path / name, good)
    read(file)
    rng = random.Random(f"{kind} {seed}")
    survived = mute = 0
    for _ in range(count):
        raw = corrupt(good, rng)
        file.write_bytes(raw)
        try:
            read(file)
        except StepidError as error:
            mute += not (error.cause and error.remedy)
        else:
            survived += 1
    assert mute == 0
    return survived


@pytest.mark.parametrize("kind", KINDS)
def test_corruptions_raise_nothing_but_own_errors(tmp_path, kind):
    survived = bombard(tmp_path, kind, 300, seed=1)
    assert 0 < survived < 200  # some damage is harmless (blanks, comments); most of it must be noticed


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(2, 6))
def test_ten_thousand_corruptions(tmp_path, kind, seed):
    survived = bombard(tmp_path, kind, 500, seed)
    assert 0 < survived < 350


@pytest.mark.parametrize("kind", ["raw", "script"])
def test_rows_lost_doubled_or_moved_are_never_read_over(tmp_path, kind):
    """What still reads is one unbroken stretch of the original.

    A script that lost its first or last row is a whole, shorter record: nothing in such a file tells.
    """
    name, good, read = KINDS[kind]
    file = write(tmp_path / name, good)
    before = read(file)
    rng = random.Random(7)
    lengths = []
    for _ in range(300):
        file.write_bytes(rng.choice((drop_line, double_line, swap_lines))(good, rng))
        try:
            after = read(file)
        except StepidError:
            continue
        lengths.append(after.time.size)
        first = round(after.time[0] / before.sample_time)
        kept = slice(first, first + after.time.size)
        np.testing.assert_array_equal(after.position, before.position[kept])
        np.testing.assert_array_equal(after.input, before.input[kept])
        np.testing.assert_allclose(after.time, before.time[kept], atol=1e-3)
    assert N in lengths
    assert min(lengths) >= (N if kind == "raw" else N - 1)
