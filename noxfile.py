"""Sessions of a release: ``nox``, or one of them by ``nox -s NAME -- arguments of pytest``."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import nox

nox.options.sessions = ["lint", "tests", "oldest", "newest"]
nox.options.reuse_existing_virtualenvs = True
PROJECT = tomllib.loads((Path(__file__).parent / "pyproject.toml").read_text(encoding="utf-8"))
VERSIONS = re.findall(r"Python :: (3\.\d+)", "\n".join(PROJECT["project"]["classifiers"]))


def _install(session: nox.Session, *more: str) -> None:
    session.install("--upgrade", "pip>=25.1")  # knows dependency groups
    session.install("-e", ".[all]", "--group", "test", *more)


def lowest() -> list[str]:
    """Direct dependencies, those of the extras too, at the lowest versions that are allowed."""
    project = PROJECT["project"]
    every = [*project["dependencies"], *(one for extra in project["optional-dependencies"].values() for one in extra)]
    return [one.replace(">=", "==") for one in every if ">=" in one]


@nox.session(python=VERSIONS)
def tests(session: nox.Session) -> None:
    """The default tests on every Python."""
    _install(session)
    session.run("pytest", "-n", "auto", *session.posargs)


@nox.session(python=VERSIONS[0])
def oldest(session: nox.Session) -> None:
    """The default tests with the lowest versions of all direct dependencies, on the oldest Python."""
    _install(session, *lowest())
    session.run("pytest", "-n", "auto", *session.posargs)


@nox.session(python=VERSIONS[-1])
def newest(session: nox.Session) -> None:
    """The default tests with the newest versions of everything, on the newest Python."""
    _install(session, "--upgrade", "--upgrade-strategy", "eager")
    session.run("pytest", "-n", "auto", *session.posargs)


@nox.session(python=VERSIONS[0])
def coverage(session: nox.Session) -> None:
    """Branch coverage, compiled functions run as plain Python; hundreds of times slower, so name the tests."""
    _install(session)
    some = session.posargs or ["tests/simulation", "tests/effects"]
    plain = {"NUMBA_DISABLE_JIT": "1"}
    session.run("coverage", "run", "--branch", "--source", "stepid", "-m", "pytest", *some, env=plain)
    session.run("coverage", "report", "--show-missing", "--skip-covered")


@nox.session(python=VERSIONS[0])
def lint(session: nox.Session) -> None:
    """Style, types and import contracts."""
    _install(session)
    session.run("ruff", "check")
    session.run("ruff", "format", "--check")
    session.run("mypy")
    session.run("lint-imports")
