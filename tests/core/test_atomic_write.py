"""A folder of results through kills: every file whole, one generation after the next run, nothing left over."""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import suppress
from itertools import count
from pathlib import Path

import pytest

from stepid.core import journal
from stepid.core.atomic_write import staged, tidied
from stepid.errors import InputError

NAMES = ("a.json", "b.txt", "c.png", "d.html")
SIZES = (50, 5_000, 20_000, 90_000)


@pytest.fixture(autouse=True)
def no_waiting_for_the_disk(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "fsync", lambda handle: None)


def content(name: str, generation: int) -> bytes:
    """Bytes that say which file of which generation they are, from first to last."""
    line = f"{name} of generation {generation}\n".encode()
    return line * (SIZES[NAMES.index(name)] // len(line))


def write(out: Path, generation: int) -> None:
    with staged(out) as folder:
        for name in NAMES:
            (folder / name).write_bytes(content(name, generation))


def generations(out: Path) -> dict[str, int]:
    """The generation of each file; fails where one is not whole."""
    found = {}
    for name in NAMES:
        if (out / name).exists():
            whole = (out / name).read_bytes()
            found[name] = int(whole.split(b"\n", 1)[0].rsplit(b" ", 1)[1])
            assert whole == content(name, found[name])
    return found


class Killed(BaseException):
    """What ends a process in these tests; nothing on the disk changes after it."""


def killed_after(steps: int, out: Path) -> bool:
    """Write generation 2, and stop for good before step `steps` on the disk; whether it came so far."""
    left = count(steps, -1)

    def dying(function: Callable[..., object]) -> Callable[..., object]:
        def inner(*args: object, **keys: object) -> object:
            if next(left) <= 0:
                raise Killed
            return function(*args, **keys)

        return inner

    with pytest.MonkeyPatch.context() as patch:
        for name in ("mkdir", "replace", "link", "fsync", "unlink", "rmdir"):
            patch.setattr(os, name, dying(getattr(os, name)))
        try:
            write(out, 2)
        except InputError:
            return False
        except Killed:
            return True
        return False


@pytest.mark.parametrize("before", [False, True], ids=["new", "replacing"])
def test_a_kill_at_any_step(tmp_path: Path, before: bool) -> None:
    seen = set()
    for steps in count():
        out = tmp_path / f"{before}-{steps}"
        if before:
            write(out, 1)
        if not killed_after(steps, out):
            break
        generations(out)  # every file is whole even now
        tidied(out)
        found = generations(out)
        assert len(set(found.values())) <= 1
        assert len(found) in {0, len(NAMES)}
        seen |= set(found.values())
        if out.exists():
            assert {path.name for path in out.iterdir()} == set(found)
        write(out, 3)
        assert generations(out) == dict.fromkeys(NAMES, 3)
        assert {path.name for path in out.iterdir()} == set(NAMES)
    assert steps > 20
    assert seen == ({1, 2} if before else {2})


def test_a_kill_at_any_step_of_taking_back(tmp_path: Path) -> None:
    for steps in count():
        out = tmp_path / str(steps)
        write(out, 1)
        (out / "b.txt").unlink()
        (out / "c.png").unlink()
        (out / "c.png").mkdir()  # cannot be replaced by a file
        killed = killed_after(steps, out)
        (out / "c.png" / "mine").touch()
        with suppress(InputError):  # what was begun cannot be completed, and is taken back
            tidied(out)
        tidied(out)
        assert (out / "c.png" / "mine").exists()
        assert generations_beside_folder(out) == {"a.json": 1, "d.html": 1}
        assert not list(out.glob(".*"))
        if not killed:
            break
    assert steps > 20


def generations_beside_folder(out: Path) -> dict[str, int]:
    (out / "c.png").rename(out / "aside")
    found = generations(out)
    (out / "aside").rename(out / "c.png")
    return found


def test_a_living_writer_is_left_alone(tmp_path: Path) -> None:
    with staged(tmp_path) as folder:
        (folder / "a.json").write_bytes(content("a.json", 5))
        write(tmp_path, 4)
        tidied(tmp_path)
    assert generations(tmp_path) == {"a.json": 5, "b.txt": 4, "c.png": 4, "d.html": 4}


def test_folders_of_others_are_left_alone(tmp_path: Path) -> None:
    other = tmp_path / f"{journal.PREFIX}mine"
    other.mkdir()
    (other / "thesis.tex").touch()
    (tmp_path / f"{journal.PREFIX}link").symlink_to(other)
    write(tmp_path, 1)
    assert (other / "thesis.tex").exists()
    assert (tmp_path / f"{journal.PREFIX}link").is_symlink()


def test_a_file_system_without_links_keeps_copies(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise PermissionError("no links here")

    monkeypatch.setattr(os, "link", refuse)
    write(tmp_path, 1)
    write(tmp_path, 2)
    assert generations(tmp_path) == dict.fromkeys(NAMES, 2)
