"""With several workers one process compiles the kernel, while they run the tests that do not simulate."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import pytest

_FIRST = ("io", "package", "benchmarks", "identification", "core")  # folders whose tests hardly simulate
_MARK = "STEPID_TESTS_COMPILING"  # a file that is there as long as the process compiles
_MOST = 150.0  # s, to wait for it
_PROGRAM = """
import pathlib, sys
try:
    import stepid
    from stepid.datasets import lab_campaign
    stepid.diagnose(lab_campaign())
finally:
    pathlib.Path(sys.argv[1]).unlink(missing_ok=True)
"""


def start(config: pytest.Config) -> None:
    """Compile in a process of its own, where there are several workers."""
    several = (getattr(config.option, "numprocesses", None) or 0) > 1
    if several and not config.option.collectonly and not hasattr(config, "workerinput"):
        handle, mark = tempfile.mkstemp(prefix="stepid-compiling-")
        os.close(handle)
        os.environ[_MARK] = mark
        process = subprocess.Popen([sys.executable, "-W", "ignore", "-c", _PROGRAM, mark])
        config.add_cleanup(lambda: _stop(process, mark))


def _stop(process: subprocess.Popen[bytes], mark: str) -> None:
    process.kill()
    process.wait()
    Path(mark).unlink(missing_ok=True)


def wait_for_it(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Let a worker wait when it first simulates, and begin with the tests that do not."""
    if hasattr(config, "workerinput") and os.environ.get(_MARK):
        from stepid.simulation.simulator import Simulator

        simulates = Simulator._run

        def waits(self: Simulator, *args: Any) -> None:
            until = time.monotonic() + _MOST
            while Path(os.environ[_MARK]).exists() and time.monotonic() < until:
                time.sleep(0.1)
            Simulator._run = simulates  # type: ignore[method-assign]
            simulates(self, *args)

        Simulator._run = waits  # type: ignore[method-assign]
        here = Path(__file__).parent
        items.sort(key=lambda item: not any(item.path.is_relative_to(here / name) for name in _FIRST))
