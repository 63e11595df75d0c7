"""Files from strangers: what is no regular file, too large or outside of a manifest's folder is refused at once."""

import os
import socket
import subprocess
import sys

import pytest

from exports import export_bytes, write
from stepid import cli, lab, read_campaign, read_ecp, read_table
from stepid.errors import InputError
from stepid.io import safe_read
from stepid.io.textfile import read_bytes

MANIFEST = """\
counts_per_meter = 56000
name = "a stranger's"
[[experiment]]
name = "case 4"
file = {file}
added_mass = 0
spring = "medium"
damper = "plug"
"""


@pytest.fixture
def folder(tmp_path):
    inner = tmp_path / "lab"
    inner.mkdir()
    for where in (tmp_path, inner):
        write(where / "case4.txt", export_bytes(n=40))
    os.symlink(tmp_path / "case4.txt", inner / "link.txt")
    os.symlink(inner / "case4.txt", inner / "inner.txt")
    os.symlink(tmp_path, inner / "up")
    return inner


def manifest(folder, file):
    write(folder / "campaign.toml", MANIFEST.format(file=repr(str(file))))
    return folder / "campaign.toml"


@pytest.mark.parametrize(
    ("file", "words"),
    [
        ("../case4.txt", "leads out of the manifest's folder"),
        ("sub/../case4.txt", "leads out of the manifest's folder"),
        ("link.txt", "is a link out of"),
        ("up/case4.txt", "is a link out of"),
    ],
)
def test_a_manifest_stays_in_its_folder(folder, file, words):
    (folder / "sub").mkdir()
    where = manifest(folder, file)
    with pytest.raises(InputError, match=rf"{words}.*beside the manifest.*--allow-outside.*allow_outside=True"):
        read_campaign(where)
    assert read_campaign(where, allow_outside=True)["case 4"].time.size == 40


def test_a_manifest_names_no_absolute_path(folder):
    where = manifest(folder, folder / "case4.txt")
    with pytest.raises(InputError, match=r"run 'case 4': the file .* is an absolute path"):
        read_campaign(where)
    assert read_campaign(where, allow_outside=True)
    with pytest.raises(InputError, match=r"allow_outside is 1. Give True or False"):
        read_campaign(where, allow_outside=1)


def test_links_within_the_folder_and_to_it_are_followed(folder, tmp_path):
    manifest(folder, "inner.txt")
    os.symlink(folder, tmp_path / "elsewhere")
    assert read_campaign(tmp_path / "elsewhere") == read_campaign(folder)


@pytest.mark.parametrize("command", ["identify", "diagnose"])
def test_the_command_line_allows_it_too(folder, capsys, command):
    where = manifest(folder, "../case4.txt")
    assert cli.run([command, str(where)]) == 2
    assert "leads out" in capsys.readouterr().err
    assert cli.run([command, str(where), "--allow-outside"]) == 2  # one run is too few, but it was read
    assert "leads out" not in capsys.readouterr().err


def test_devices_pipes_and_sockets_are_no_files(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    os.mkfifo("pipe.txt")
    os.symlink("/dev/zero", "zero.txt")
    served = socket.socket(socket.AF_UNIX)
    served.bind("socket.txt")
    for name, kind in (("pipe.txt", "a pipe"), ("zero.txt", "a device"), ("socket.txt", "a socket")):
        for read in (
            lambda p: read_ecp(p, counts_per_meter=1.0),
            lambda p: read_table(p, position=0),
            read_campaign,
            lab.read_submission,
            lambda p: lab.open_answers(p, passphrase="correct horse"),
        ):
            with pytest.raises(InputError, match=f"{name}: is {kind}, not a file. Copy"):
                read(name)
    served.close()


def test_sizes_have_limits_and_remedies(tmp_path, monkeypatch):
    file = tmp_path / "a.csv"
    with file.open("wb") as sparse:
        sparse.write(b"t,x\n")
        sparse.truncate(20_000_000_000)
    with pytest.raises(InputError, match=r"holds 20,000 MB; files of up to 500 MB are read here. Split a table"):
        read_table(file, position=1)
    with pytest.raises(InputError, match=r"files of up to 1 MB are read here. Check that it is the file"):
        read_campaign(file)
    file.write_bytes(b"1," * 600_000)
    with pytest.raises(InputError, match=r"a line is longer than 1,000,000 characters.*one row a sample"):
        read_table(file, position=1)
    monkeypatch.setattr(safe_read, "_PIECE", 10)
    monkeypatch.setattr(safe_read, "LONGEST_LINE", 25)
    for content in (b"x" * 25 + b"\n" + b"y" * 25, b"x\r" * 100, b"\n" * 100):
        file.write_bytes(content)
        assert read_bytes(file) == content
    for content in (b"x" * 26, b"x" * 8 + b"\n" + b"y" * 26):
        file.write_bytes(content)
        with pytest.raises(InputError, match="line is longer"):
            read_bytes(file)


def test_a_file_that_says_it_is_empty_is_read_to_the_limit():
    if not os.path.exists("/proc/self/status"):
        pytest.skip("no file system of the kernel")
    from pathlib import Path

    assert read_bytes(Path("/proc/self/status"))
    with pytest.raises(InputError, match="holds more than 0 MB"):
        read_bytes(Path("/proc/self/status"), largest=10)


@pytest.mark.parametrize(
    "text",
    [
        "a" + ".a" * 5000 + " = 1\n",
        "[" + "a" + ".a" * 20 + "]\n",
        "".join(f"k{i}{'.a' * 200} = 1\n" for i in range(400)),
    ],
)
def test_keys_of_very_many_parts_are_refused(tmp_path, text):
    with pytest.raises(InputError, match=r"line \d+: holds \d+ points"):
        read_campaign(write(tmp_path / "campaign.toml", text))


@pytest.mark.slow
def test_hostile_files_take_neither_time_nor_memory(tmp_path):
    file = tmp_path / "line.csv"
    with file.open("wb") as long:
        for _ in range(300):
            long.write(b"1," * 500_000)
    code = (
        "import resource, time, stepid; stepid.read_table; from stepid.errors import InputError\n"
        "before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss; began = time.perf_counter()\n"
        f"try: stepid.read_table({str(file)!r}, position=0)\n"
        "except InputError: print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before,"
        " time.perf_counter() - began)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    memory, seconds = map(float, done.stdout.split())
    assert memory * (1 if sys.platform == "darwin" else 1024) < 100e6
    assert seconds < 1
