"""CPU time of one simulated sample at equal accuracy: a plain compiled loop, the best of scipy, stepid's kernel.

    python benchmarks/kernel_speed.py [--only NAME] [--repeats N] [--copies N]

Ten plants, 2000 samples at the paper's sample time, a step up or back every 250. Everybody gets the coarsest setting
that leaves an RMS error of at most 0.001 count (226600 counts/m) against tight, event-located integration. The methods
take turns; the least CPU time of a turn counts, in microseconds a trajectory-sample.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")

import argparse
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "tests"), str(ROOT / "benchmarks")]

import loop  # noqa: E402
import solve_events  # noqa: E402
from hidden.accuracy_cases import ALONE, COUNTS, PERIOD, reference  # noqa: E402
from stepid.effects import resolve  # noqa: E402
from stepid.simulation import kernel  # noqa: E402
from stepid.simulation.work import structure  # noqa: E402

ALLOWED = 1e-3  # counts, RMS
SAMPLES = 2000
PLANT = {"mass": 1.5, "stiffness": 216.0, "damping": 6.0, "gain": 7.8}
NAMES = (
    "linear",
    "cubic_stiffness",
    "coulomb_friction",
    "stribeck_friction",
    "presliding_hysteresis",
    "flexible_coupling",
    "actuator_lag + cubic_stiffness",
    "cogging",
    "free_play",
    "end_stop",
)
Simulate = Callable[[int], np.ndarray]  # positions of so many copies, shape (copies, samples)


@dataclass(frozen=True)
class Row:
    name: str
    effects: Mapping[str, Mapping[str, float]]
    inputs: np.ndarray
    exact: np.ndarray

    def error(self, x: np.ndarray) -> float:
        return float(np.sqrt(np.mean((x - self.exact) ** 2))) * COUNTS


def make_row(name: str) -> Row:
    effects = {} if name == "linear" else {n: ALONE[n] for n in name.split(" + ")}
    inputs = np.where(np.arange(SAMPLES) // 250 % 2 == 0, 0.5, 0.0)
    inputs[:5] = 0.0
    return Row(name, effects, inputs, reference((effects, {**PLANT, "sample_time": PERIOD, "inputs": inputs})))


def stepid_kernel(row: Row) -> tuple[Simulate, float]:
    """stepid's own kernel with the loosest tolerance that suffices, and that tolerance as a share of the travel."""
    effects = resolve(list(row.effects))
    n_states = structure(effects)[0].states
    plant = [PLANT[n] for n in ("mass", "stiffness", "damping", "gain")]
    plant += [row.effects[e.name][q.name] for e in effects for q in e.parameters]
    time, volts, zero = PERIOD * np.arange(SAMPLES), row.inputs[:, None].copy(), np.zeros(1)
    travel = PLANT["gain"] * float(row.inputs.max()) / PLANT["stiffness"]
    affine = all((e.linear or e.affine) and not e.n_extra for e in effects)
    leaps = 2 if all(e.linear for e in effects) else int(affine)

    def simulator(share: float) -> Simulate:
        def simulate(copies: int) -> np.ndarray:
            reading, states = np.empty(copies * SAMPLES), np.empty((0, copies * SAMPLES))
            kernel.simulate(
                structure(effects),
                np.tile(plant, (copies, 1)),
                np.zeros((copies, n_states)),
                np.zeros(copies, np.intp),
                np.array([0, SAMPLES]),
                time,
                volts,
                zero,
                zero > 0,
                share * travel,
                travel,
                leaps,
                10_000,
                SAMPLES * np.arange(copies),
                reading,
                states,
            )
            return reading.reshape(copies, SAMPLES)

        return simulate

    for share in 10.0 ** -np.arange(4.0, 10.1, 0.25):
        if row.error(simulator(float(share))(1)[0]) <= ALLOWED:
            return simulator(float(share)), float(share)
    raise RuntimeError(f"{row.name}: the kernel does not reach {ALLOWED} counts")


def plain_loop(row: Row) -> tuple[Simulate, int]:
    """The loop with the fewest substeps that suffice."""
    plant = loop.row(**PLANT, effects=row.effects)

    def simulator(parts: int) -> Simulate:
        def simulate(copies: int) -> np.ndarray:
            out = np.empty((copies, SAMPLES))
            loop.run_rows(np.tile(plant, (copies, 1)), row.inputs, PERIOD, parts, 0.0, 0.0, out)
            return out

        return simulate

    low, high = 0, 1
    while row.error(simulator(high)(1)[0]) > ALLOWED:
        low, high = high, 2 * high
        if high > 4096:
            raise RuntimeError(f"{row.name}: the loop does not reach {ALLOWED} counts")
    while high - low > 1:
        middle = (low + high) // 2
        enough = row.error(simulator(middle)(1)[0]) <= ALLOWED
        low, high = (low, middle) if enough else (middle, high)
    return simulator(high), high


def _seconds(simulate: Simulate) -> float:
    start = time.process_time()
    simulate(1)
    return time.process_time() - start


def best_of_scipy(row: Row) -> tuple[Simulate, str]:
    """The fastest method, each at the loosest tolerance that suffices."""
    plant, times = solve_events.Plant(**PLANT, effects=row.effects), PERIOD * np.arange(SAMPLES)
    found: list[tuple[float, str, Simulate]] = []
    for method in solve_events.METHODS:
        for rtol in 10.0 ** -np.arange(3.0, 12.1, 0.5):

            def simulate(copies: int, method: str = method, rtol: float = float(rtol)) -> np.ndarray:
                return solve_events.simulate(plant, times, row.inputs, method, rtol)[None]

            try:
                enough = row.error(simulate(1)[0]) <= ALLOWED
            except RuntimeError:  # a step too small: the next tolerance
                continue
            if enough:
                found.append((min(_seconds(simulate) for _ in range(3)), f"{method} {rtol:.0e}", simulate))
                break
    _, name, simulate = min(found, key=lambda f: f[0])
    return simulate, name


def compare(row: Row, repeats: int, copies: int) -> list[str]:
    simulate, parts = plain_loop(row)
    scipy_best, method = best_of_scipy(row)
    work: dict[str, tuple[Simulate, int, int]] = {  # simulator, copies, calls a turn
        "loop, one": (simulate, 1, 20),
        "loop, many": (simulate, copies, 1),
        "scipy": (scipy_best, 1, 1),
    }
    own_kernel, share = stepid_kernel(row)
    work |= {"stepid, one": (own_kernel, 1, 20), "stepid, many": (own_kernel, copies, 1)}
    off = f"{row.error(own_kernel(1)[0]):.1e}"
    least = dict.fromkeys(work, float("inf"))
    for _ in range(repeats):
        for name, (call, some, times) in work.items():
            start = time.process_time()
            for _ in range(times):
                call(some)
            least[name] = min(least[name], (time.process_time() - start) / times / some / SAMPLES * 1e6)
    told = [f"{least[n]:.3g}" for n in ("loop, one", "loop, many", "scipy")]
    own = [f"{least[n]:.3g}" for n in ("stepid, one", "stepid, many")]
    ratios = [f"{least[f'stepid, {n}'] / least[f'loop, {n}']:.2f}" for n in ("one", "many")]
    faster = f"{least['scipy'] / least['stepid, many']:.0f}"
    return [row.name, str(parts), *told, method, *own, f"{share:.0e}", off, *ratios, faster]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", help="one row")
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--copies", type=int, default=1000)
    args = parser.parse_args()
    head = ["µs a sample", "loop's parts", "loop, one", f"loop, {args.copies}", "best of scipy", "which", "stepid, one"]
    head += [f"stepid, {args.copies}", "tolerance", "its error, counts", "over loop, one", f"over loop, {args.copies}"]
    head += ["times faster than scipy"]
    print(f"| {' | '.join(head)} |\n|{' --- |' * len(head)}")
    for name in NAMES:
        if not args.only or args.only in name:
            print(f"| {' | '.join(compare(make_row(name), args.repeats, args.copies))} |", flush=True)


if __name__ == "__main__":
    main()
