"""CPU time of `import stepid` against `import numpy, pydantic`, each in fresh interpreters, side by side.

Run with ``python benchmarks/import_time.py``. The target is a ratio of at most 0.35/0.15 = 2.33; numba and the kernel,
from their cache, may take 0.8 s more than numpy and the effects.
"""

from __future__ import annotations

import resource
import subprocess
import sys

TARGET = 0.35 / 0.15
KERNEL = 0.8  # s
REPEATS = 9
STATEMENTS = {
    "bare interpreter": "pass",
    "import numpy, pydantic": "import numpy, pydantic",
    "import stepid": "import stepid",
    "import stepid, first model": "import stepid; stepid.Campaign",
    "import the effects": "import numpy, stepid.effects",
    "numba and the kernel, too": "import numpy, stepid.effects; from stepid.simulation.warm_up import warm_up; "
    "warm_up(print)",
    "import stepid, every name": "import stepid; [getattr(stepid, n) for n in stepid.__all__]",
}


def seconds(statement: str) -> float:
    """CPU time of one fresh interpreter that runs the statement."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([sys.executable, "-c", statement], check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    # interleaved, so that a busy machine slows all of them alike; the best of each is reported
    rounds = [{name: seconds(code) for name, code in STATEMENTS.items()} for _ in range(REPEATS)]
    best = {name: min(r[name] for r in rounds) for name in STATEMENTS}
    bare = best["bare interpreter"]
    base = best["import numpy, pydantic"] - bare
    print(f"{'statement':30} {'seconds':>8} {'ratio':>6}")
    for name, value in best.items():
        print(f"{name:30} {value - bare:8.3f} {(value - bare) / base:6.2f}")
    print(f"target: import stepid at most {TARGET:.2f} times import numpy, pydantic")
    kernel = best["numba and the kernel, too"] - best["import the effects"]
    print(f"numba and the kernel, from their cache: {kernel:.2f} s (asked {KERNEL})")


if __name__ == "__main__":
    main()
