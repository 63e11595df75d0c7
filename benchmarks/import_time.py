"""Time `import stepid` against `import numpy, pydantic`, each in fresh interpreters, side by side.

Run with ``python benchmarks/import_time.py``. The target is a ratio of at most 0.35/0.15 = 2.33.
"""

from __future__ import annotations

import subprocess
import sys
import time

TARGET = 0.35 / 0.15
REPEATS = 9
STATEMENTS = {
    "bare interpreter": "pass",
    "import numpy, pydantic": "import numpy, pydantic",
    "import stepid": "import stepid",
    "import stepid, first model": "import stepid; stepid.Campaign",
    "import stepid, every name": "import stepid; [getattr(stepid, n) for n in stepid.__all__]",
}


def seconds(statement: str) -> float:
    """Wall time of one fresh interpreter that runs the statement."""
    start = time.perf_counter()
    subprocess.run([sys.executable, "-c", statement], check=True)
    return time.perf_counter() - start


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


if __name__ == "__main__":
    main()
