"""The command line among other programs: completion, help, colors, exit status."""

from __future__ import annotations

import os
import pty
import shutil
import signal
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest
from typer.main import get_command

import diagnosis_example as example
import stepid
from stepid.cli import app, run

STEPID = [sys.executable, "-m", "stepid"]
COMMANDS = sorted(get_command(app).commands)  # type: ignore[attr-defined]
PLAIN = {key: value for key, value in os.environ.items() if key not in {"NO_COLOR", "FORCE_COLOR", "PY_COLORS"}}


def ask(variables: dict[str, str], *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [*STEPID, *arguments], env=PLAIN | variables, capture_output=True, text=True, check=False, timeout=60
    )


def on_terminal(arguments: list[str], variables: dict[str, str], program: Sequence[str] = STEPID) -> str:
    """What the command writes where both its streams are a terminal."""
    leader, follower = pty.openpty()
    environment = PLAIN | {"TERM": "xterm-256color", "COLUMNS": "200"} | variables
    child = subprocess.Popen([*program, *arguments], env=environment, stdout=follower, stderr=follower)
    os.close(follower)
    chunks = []
    while True:
        try:
            chunk = os.read(leader, 65536)
        except OSError:  # how Linux says that the other end is closed
            break
        if not chunk:
            break
        chunks.append(chunk)
    os.close(leader)
    child.wait(timeout=60)
    return b"".join(chunks).decode()


# ---- completion -------------------------------------------------------------------------------------------------

WORDS = {
    "bash": lambda line: {"_STEPID_COMPLETE": "complete_bash", "COMP_WORDS": line, "COMP_CWORD": str(line.count(" "))},
    "zsh": lambda line: {"_STEPID_COMPLETE": "complete_zsh", "_TYPER_COMPLETE_ARGS": line},
    "fish": lambda line: {
        "_STEPID_COMPLETE": "complete_fish",
        "_TYPER_COMPLETE_FISH_ACTION": "get-args",
        "_TYPER_COMPLETE_ARGS": line,
    },
}


@pytest.mark.parametrize("shell", WORDS)
def test_commands_and_options_are_completed(shell: str) -> None:
    commands = ask(WORDS[shell]("stepid di")).stdout
    assert "diagnose" in commands
    assert "paper" not in commands
    options = ask(WORDS[shell]("stepid diagnose --")).stdout
    assert all(option in options for option in ("--out", "--json", "--help"))


@pytest.mark.parametrize("shell", WORDS)
def test_the_completion_script_is_shown(shell: str) -> None:
    done = ask({"_TYPER_COMPLETE_TEST_DISABLE_SHELL_DETECTION": "1"}, "--show-completion", shell)
    assert done.returncode == 0
    assert "_STEPID_COMPLETE" in done.stdout
    assert f"complete_{shell}" in done.stdout or "_TYPER_COMPLETE_ARGS" in done.stdout


@pytest.mark.skipif(shutil.which("bash") is None, reason="needs bash")
def test_bash_takes_the_script(tmp_path: Path) -> None:
    script = ask({"_TYPER_COMPLETE_TEST_DISABLE_SHELL_DETECTION": "1"}, "--show-completion", "bash").stdout
    command = tmp_path / "stepid"
    command.write_text(f'#!/bin/sh\nexec {sys.executable} -m stepid "$@"\n')
    command.chmod(0o755)
    asked = 'COMP_WORDS=(stepid id); COMP_CWORD=1; _stepid_completion stepid; printf "%s\\n" "${COMPREPLY[@]}"'
    done = subprocess.run(
        ["bash", "--norc", "-c", f"{script}\n{asked}"],
        env=PLAIN | {"PATH": f"{tmp_path}:{os.environ['PATH']}"},
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.split() == ["identify"]


def test_completion_and_help_load_nothing_that_takes_long() -> None:
    code = "import sys, stepid.cli; print(*{name.partition('.')[0] for name in sys.modules})"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert "typer" in loaded
    assert not {"numpy", "scipy", "pydantic", "control", "matplotlib", "pandas", "jinja2", "plotly"} & set(loaded)


def test_completion_can_be_installed() -> None:
    assert "--install-completion" in ask({}, "--help").stdout


# ---- help ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_shows_two_examples(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run([command, "--help"]) == 0
    lines = [line.strip() for line in capsys.readouterr().out.split("Examples:")[1].splitlines()]
    shown = [line for line in lines if line]
    assert len(shown) >= 2
    assert all(line.startswith(f"stepid {command}") for line in shown)


@pytest.mark.parametrize("command", ["identify", "diagnose"])
def test_the_manifest_in_the_help_is_one(
    command: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    assert run([command, "--help"]) == 0
    lines = [line.strip() for line in capsys.readouterr().out.splitlines()]
    start = lines.index('name = "my rig"')
    (tmp_path / "campaign.toml").write_text("\n".join(lines[start : lines.index("", start)]), encoding="utf-8")
    for i, name in enumerate(["case 4", "case 5"], start=1):
        record = stepid.datasets.lab_campaign()[name]
        rows = zip(record.time, 1e3 * record.position, record.input, strict=True)
        table = "time_s,position_mm,voltage_V\n" + "".join(f"{t:.6f},{x:.6f},{u}\n" for t, x, u in rows)
        (tmp_path / f"run{i}.csv").write_text(table, encoding="utf-8")
    assert run(["identify", str(tmp_path)]) == 0
    assert "stiffness [medium]" in capsys.readouterr().out


# ---- colors -------------------------------------------------------------------------------------------------------


def test_colors_are_on_at_a_terminal_and_off_with_no_color() -> None:
    bad = ["identify", "nowhere.toml"]
    colored = on_terminal(bad, {})
    assert "\x1b[31m" in colored
    plain = on_terminal(bad, {"NO_COLOR": "1"})
    assert "nowhere.toml" in plain
    assert "\x1b[" not in plain


def test_results_are_plain_in_a_pipe_and_with_no_color() -> None:
    piped = ask({"TERM": "xterm-256color"}, "paper")
    assert (piped.returncode, piped.stderr) == (0, "")
    assert "\x1b" not in piped.stdout
    plain = on_terminal(["paper"], {"NO_COLOR": "1"})
    assert "\x1b" not in plain
    assert plain.replace("\r\n", "\n") == piped.stdout


# ---- exit status --------------------------------------------------------------------------------------------------


def test_status_0_where_it_is_done() -> None:
    assert run(["--help"]) == run(["--version"]) == 0  # results end with it, too: the other tests of the command line


@pytest.mark.parametrize(
    "arguments",
    [
        ["nonsense"],
        ["identify"],
        ["identify", "--nonsense"],
        ["identify", "nowhere.toml"],
        ["diagnose", "nowhere.toml"],
    ],
    ids=" ".join,
)
def test_status_2_where_the_input_is_wrong(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert run(arguments) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err
    assert "Traceback" not in err


def test_status_130_where_it_is_interrupted(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    def interrupt(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(stepid, "diagnose", interrupt)
    stepid.write_campaign(example.campaign(), tmp_path / "lab")
    out = tmp_path / "out"
    assert run(["diagnose", str(tmp_path / "lab" / "campaign.toml"), "--out", str(out)]) == 130
    assert "Traceback" not in capsys.readouterr().err
    assert not out.exists()


def interruptible() -> None:
    """Hear the signal even where the tests run in the background of a shell, which ignores it there."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def test_a_signal_while_searching_ends_it_without_a_trace(tmp_path: Path) -> None:
    lab = Path(stepid.datasets.__file__).parent / "lab" / "campaign.toml"
    out = tmp_path / "out"
    asked = [*STEPID, "diagnose", str(lab), "--out", str(out)]
    with subprocess.Popen(
        asked, env=PLAIN, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=interruptible
    ) as child:
        assert child.stderr is not None
        for line in child.stderr:
            if "linear fit" in line:  # the first stage: the search is still to come
                break
        child.send_signal(signal.SIGINT)
        written, told = child.communicate(timeout=60)
    assert child.returncode == 130
    assert written == ""
    assert "Traceback" not in told
    assert not out.exists()


def test_no_arguments_shows_the_help() -> None:
    done = ask({})
    assert done.returncode == 2
    assert "Usage: stepid" in done.stdout + done.stderr


# ---- progress -----------------------------------------------------------------------------------------------------

TOLD = """
from stepid.cli.bar import showing
with showing(lines=True, bar=True) as tell:
    tell("diagnosing: linear fit")
    tell("diagnosing: free [play]", 3, 9)
    import time; time.sleep(0.3)
"""


def test_a_terminal_shows_a_bar_with_counts() -> None:
    shown = on_terminal([], {}, program=[sys.executable, "-c", TOLD])
    assert "3/12" in shown
    assert "━" in shown
    assert "free [play]" in shown


def test_a_pipe_gets_lines() -> None:
    piped = subprocess.run([sys.executable, "-c", TOLD], env=PLAIN, capture_output=True, text=True, check=True)
    assert piped.stderr == "diagnosing: linear fit\ndiagnosing: free [play]\n"
    assert piped.stdout == ""


def test_the_environment_switches_the_bar_off() -> None:
    shown = on_terminal([], {"STEPID_PROGRESS": "0"}, program=[sys.executable, "-c", TOLD])
    assert "━" not in shown
