"""Sessions of a release: ``nox``, or one of them by ``nox -s NAME -- arguments of pytest``."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import nox

nox.options.sessions = ["lint", "tests", "oldest", "newest", "docs", "build"]
nox.options.reuse_existing_virtualenvs = True
PROJECT = tomllib.loads((Path(__file__).parent / "pyproject.toml").read_text(encoding="utf-8"))
VERSIONS = re.findall(r"Python :: (3\.\d+)", "\n".join(PROJECT["project"]["classifiers"]))

COVERAGE = """[run]
branch = True
source = stepid
parallel = True
patch = subprocess
[report]
omit = */.cache/*
"""


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
    """Branch coverage: of all tests compiled, of those of laws and kernel with compiled functions as plain Python.

    Plain Python is hundreds of times slower. Tests that are named run as plain Python only. What the tests start as a
    command counts, too; the laws that are written out for numba do not.
    """
    _install(session)
    settings = Path(session.create_tmp()) / "coverage.ini"
    settings.write_text(COVERAGE)
    told = f"--rcfile={settings}"
    measured = ("coverage", "run", told, "-m", "pytest", "-p", "no:cacheprovider")
    session.run("coverage", "erase", told)
    if not session.posargs:
        session.run(*measured)
    plain = session.posargs or ["tests/simulation", "tests/effects"]
    session.run(*measured, *plain, env={"NUMBA_DISABLE_JIT": "1"})
    session.run("coverage", "combine", told)
    session.run("coverage", "report", told, "--show-missing", "--skip-covered")


@nox.session(python=VERSIONS[0])
def mutants(session: nox.Session) -> None:
    """Mutation testing of identification, fitting, evidence and verdict: COUNT, SEED and part of a path; hours."""
    _install(session)
    session.run("python", "benchmarks/mutants.py", *(session.posargs or ["600", "14"]))


@nox.session(python=VERSIONS[0])
def attack(session: nox.Session) -> None:
    """Mutated files, mutated campaigns, wrong types, hostile files: nothing but stepid's own errors may come out."""
    _install(session)
    session.run("python", "benchmarks/fuzz_readers.py", *(session.posargs or ["500000"]))
    session.run("python", "benchmarks/fuzz_identify.py", "5000")
    session.run("python", "benchmarks/wrong_types.py", "30000")
    session.run("pytest", "-m", "", "tests/io/test_safe_read.py")


@nox.session(python=VERSIONS[0])
def lint(session: nox.Session) -> None:
    """Style, types and import contracts."""
    _install(session)
    session.run("ruff", "check")
    session.run("ruff", "format", "--check")
    session.run("mypy")
    session.run("lint-imports")


@nox.session(python=VERSIONS[0])
def docs(session: nox.Session) -> None:
    """The site, with every notebook run; a warning is an error."""
    session.install("--upgrade", "pip>=25.1")
    session.install("-e", ".[all]", "--group", "docs")
    session.run("sphinx-build", "-n", "-W", "--keep-going", "docs", str(Path(session.create_tmp()) / "site"))


@nox.session(python=VERSIONS[0])
def build(session: nox.Session) -> None:
    """The source distribution and the wheel: what a package index will say of them, and the wheel installed."""
    session.install("--upgrade", "pip>=25.1")
    session.install("--group", "release")
    dist = Path(session.create_tmp()) / "dist"
    for old in dist.glob("*"):
        old.unlink()
    session.run("python", "-m", "build", "--outdir", str(dist))
    session.run("twine", "check", "--strict", *map(str, dist.glob("*")))
    (wheel,) = dist.glob("*.whl")
    session.install("--force-reinstall", f"stepid[all] @ {wheel.resolve().as_uri()}")
    session.run("stepid", "--version")
    session.run("stepid", "paper", silent=True)  # its data came along
