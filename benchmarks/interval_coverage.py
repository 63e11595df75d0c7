"""How often the 95 % intervals of `stepid.fit` hold the truth, and how often wrong models are warned of.

    python benchmarks/interval_coverage.py LINES [--count N] [--cells WORD ...] [--without WORD ...] [--table]

Each campaign draws its plant, its effect's size, its weights (5 g each of 0.5 kg, one error in all runs that
carry it) and its noise anew: four runs of a step up and one back, sample time 8.854 ms but where a cell says otherwise.
Simulated by the hidden simulator of the tests. Every campaign is a line of the file LINES; what stands there is not run
again, so that a run may be ended and started again. A cell is run where all the words given are in its name.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")

import argparse
import json
import sys
import time
import zlib
from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.signal import lfilter

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

import stepid
from closed_form import Plant, draw_plant
from hidden.fast import fast
from hidden.plant import Run

SAMPLE_TIME = 8.854e-3  # s
COUNT = 1 / 226600  # m
WEIGHTS = (0, 1, 3, 4)  # of 0.5 kg, in each run
SPREAD = 0.005  # kg
TRAVEL = 0.018  # m
TOGETHER = 25  # campaigns that are simulated at once
KINDS = ("linear", "coulomb", "cubic", "lag")
NAMES = {"coulomb": "coulomb_friction", "cubic": "cubic_stiffness", "lag": "actuator_lag"}


class Cell(NamedTuple):
    """Kind of plant, noise [m], counts or not, sample time [s], correlation time [s]; fitted without its effect."""

    kind: str
    noise: float
    counts: bool = False
    sample_time: float = SAMPLE_TIME
    correlation: float = 0.0
    wrong: bool = False

    @property
    def name(self) -> str:
        parts = [self.kind, f"{1e6 * self.noise:g} µm"]
        parts += ["counts"] * self.counts
        parts += [f"T {1e3 * self.sample_time:.3g} ms"] * (self.sample_time != SAMPLE_TIME or self.correlation > 0)
        parts += [f"AR {1e3 * self.correlation:g} ms"] * (self.correlation > 0)
        return ", ".join([*parts, *["wrong"] * self.wrong])


CELLS = (
    *(Cell(kind, n, counts) for kind in KINDS for n in (5e-6, 20e-6, 50e-6, 200e-6) for counts in (False, True)),
    *(Cell(kind, 0.0, True) for kind in KINDS),
    *(
        Cell(kind, 20e-6, False, t, tau)
        for kind in KINDS
        for t in (0.9e-3, 4.4e-3, 8.9e-3)
        for tau in (1e-3, 3e-3, 10e-3)
    ),
    *(Cell(kind, 20e-6, wrong=True) for kind in ("linear", "coulomb", "cubic")),
)


def effects_of(kind: str, plant: Plant, rng: np.random.Generator) -> dict[str, dict[str, float]]:
    """The hidden effect: 2 to 10 % of the force, 6 to 35 % of the spring's force, 5 to 30 ms."""
    force = plant.stiffness * TRAVEL
    if kind == "coulomb":
        return {"coulomb_friction": {"level": float(rng.uniform(0.02, 0.1)) * force}}
    if kind == "cubic":
        return {"cubic_stiffness": {"coefficient": float(rng.uniform(0.06, 0.35)) * plant.stiffness / TRAVEL**2}}
    return {"actuator_lag": {"time_constant": float(rng.uniform(5e-3, 30e-3))}} if kind == "lag" else {}


def noise_of(cell: Cell, size: int, rng: np.random.Generator) -> np.ndarray:
    white = rng.standard_normal(size)
    if not cell.correlation:
        return cell.noise * white
    a = np.exp(-cell.sample_time / cell.correlation)
    root = np.sqrt(1 - a * a)
    white[0] /= root
    return np.asarray(cell.noise * lfilter([root], [1, -a], white))


class Drawn(NamedTuple):
    """A campaign to be simulated: the runs, its truth, and what draws the noise."""

    runs: list[Run]
    truth: dict[str, float]
    rng: np.random.Generator


def drawn(cell: Cell, number: int) -> Drawn:
    """Draw a campaign's plant, effect and weights."""
    rng = np.random.default_rng([zlib.crc32(cell.name.encode()), number])
    plant = draw_plant(rng)
    effects = effects_of(cell.kind, plant, rng)
    weights = 0.5 + SPREAD * rng.standard_normal(4)
    size = TRAVEL * plant.stiffness / plant.gain
    runs = []
    for carried in WEIGHTS:
        added = float(weights[:carried].sum())
        decay, frequency = plant.rates(added)
        half = round((5 / decay + 2 * np.pi / frequency) / cell.sample_time)
        volts = np.repeat([0.0, size, 0.0], [max(12, half // 20), half, half])
        mass = plant.base_mass + added
        runs.append(Run(mass, plant.stiffness, plant.damping, plant.gain, cell.sample_time, volts, effects))
    truth = {
        "base_mass": plant.base_mass,
        "stiffness[medium]": plant.stiffness,
        "damping[1/2 turn]": plant.damping,
        "force_gain": plant.gain,
    }
    truth |= {f"{e}.{p}": v for e, values in effects.items() for p, v in values.items()}
    return Drawn(runs, truth, rng)


def made(cell: Cell, numbers: Sequence[int]) -> list[tuple[stepid.Campaign, dict[str, float]]]:
    """Campaigns with their truths; simulated together, which takes a fraction of the time."""
    every = [drawn(cell, number) for number in numbers]
    positions = iter(fast([run for one in every for run in one.runs]))
    return [(measured(cell, one, [next(positions) for _ in one.runs]), one.truth) for one in every]


def measured(cell: Cell, of: Drawn, positions: list[np.ndarray]) -> stepid.Campaign:
    """Records with their noise, in counts where the cell says so."""
    experiments = []
    for i, (run, x) in enumerate(zip(of.runs, positions, strict=True)):
        read = x + noise_of(cell, x.size, of.rng)
        if cell.counts:
            read = np.rint(read / COUNT + of.rng.uniform(-0.5, 0.5)) * COUNT
        experiments.append(
            stepid.Experiment(
                name=f"case {4 + i}",
                time=cell.sample_time * np.arange(x.size),
                position=read,
                input=run.inputs,
                added_mass=0.5 * WEIGHTS[i],
                spring="medium",
                damper="1/2 turn",
                counts_per_meter=1 / COUNT if cell.counts else None,
            )
        )
    return stepid.Campaign(name="drawn", experiments=tuple(experiments), weight_uncertainty=SPREAD)


def one(cell: Cell, number: int, campaign: stepid.Campaign, truth: dict[str, float]) -> dict[str, Any]:
    """A line: error over standard uncertainty, and whether the interval holds the truth, of every quantity."""
    wanted = () if cell.wrong or cell.kind == "linear" else (NAMES[cell.kind],)
    start = time.process_time()
    out: dict[str, Any] = {"cell": cell.name, "number": number}
    try:
        found = stepid.fit(campaign, effects=wanted)
    except stepid.errors.StepidError as error:
        return out | {"error": str(error)}
    z: dict[str, float | None] = {}
    held: dict[str, bool | None] = {}
    for name, true in truth.items():
        e = found.parameters.get(name)
        if e is None:
            continue
        z[name] = (e.value - true) / e.uncertainty if e.uncertainty else None
        held[name] = None if e.interval is None else bool(e.interval[0] <= true <= e.interval[1])
    gain = static_gain(found)
    true = truth["force_gain"] / truth["stiffness[medium]"]
    z["static gain"] = (gain[0] - true) / gain[1] if gain else None
    held["static gain"] = None if gain is None else bool(abs(gain[0] - true) < 1.96 * gain[1])
    out |= {"z": z, "held": held, "times": found.rms / found.noise, "converged": found.converged}
    out |= {"warned": any("More than noise" in note for note in found.notes), "cpu": time.process_time() - start}
    if cell.wrong:
        out["identify"] = identified(campaign)
    return out


def static_gain(found: stepid.Fit) -> tuple[float, float] | None:
    """Force gain over stiffness, m/V, with its standard uncertainty."""
    g, k = found.parameters["force_gain"], found.parameters["stiffness[medium]"]
    if g.uncertainty is None or k.uncertainty is None:
        return None
    names = list(found.parameters)
    rho = float(found.correlation[names.index("force_gain"), names.index("stiffness[medium]")])
    one, two = g.uncertainty / g.value, k.uncertainty / k.value
    return g.value / k.value, g.value / k.value * float(np.sqrt(max(one**2 + two**2 - 2 * rho * one * two, 0.0)))


def identified(campaign: stepid.Campaign) -> bool | None:
    """Whether `identify` warns; None where it gives no answer."""
    try:
        return "stepid.diagnose" in stepid.identify(campaign).summary()
    except stepid.errors.StepidError:
        return None


def table(lines: list[dict[str, Any]]) -> None:
    """Print coverage by cell and quantity, in per cent; beside it how many campaigns, and what they cost."""
    by: dict[str, list[dict[str, Any]]] = defaultdict(list)
    for line in lines:
        by[line["cell"]].append(line)
    order = ("base_mass", "stiffness[medium]", "damping[1/2 turn]", "force_gain", "static gain")
    print(f"{'cell':<34}{'n':>5}  base    k     c  gain static  effect  open error warned identify   CPU")
    for cell in (c for c in CELLS if c.name in by):
        own = by[cell.name]
        good = [line for line in own if "held" in line]
        effects = [q for q in good[0]["held"] if "." in q] if good else []
        cells = [_share([line["held"][q] for line in good if q in line["held"]]) for q in (*order, *effects[:1])]
        lost = sum(None in line["held"].values() for line in good)
        said = [line["identify"] for line in good if line.get("identify") is not None]
        warned, cpu = sum(line["warned"] for line in good), np.median([line["cpu"] for line in good] or [0])
        print(
            f"{cell.name:<34}{len(own):>5} " + " ".join(f"{c:>5}" for c in cells) + " " * (6 * (6 - len(cells)))
            + f" {lost:>5} {len(own) - len(good):>5} {warned:>5} {sum(said):>4}/{len(said):<4} {cpu:.2f} s"
        )  # fmt: skip


def _share(held: list[bool | None]) -> str:
    known = [h for h in held if h is not None]
    return f"{100 * float(np.mean(known)):.1f}" if known else "–"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("lines", type=Path)
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--cells", nargs="*", default=())
    parser.add_argument("--without", nargs="*", default=(), help="words that no cell's name may hold")
    parser.add_argument("--table", action="store_true", help="print the table only")
    given = parser.parse_args()
    lines = [json.loads(t) for t in given.lines.read_text("utf-8").splitlines()] if given.lines.exists() else []
    done = {(line["cell"], line["number"]) for line in lines}
    chosen = [c for c in CELLS if all(w in c.name for w in given.cells) and not any(w in c.name for w in given.without)]
    if not given.table:
        with given.lines.open("a", encoding="utf-8") as out:
            for first in range(0, given.count, TOGETHER):
                for cell in chosen:
                    numbers = range(first, min(first + TOGETHER, given.count))
                    wanted = [n for n in numbers if (cell.name, n) not in done]
                    for number, (campaign, truth) in zip(wanted, made(cell, wanted) if wanted else (), strict=True):
                        lines.append(one(cell, number, campaign, truth))
                        out.write(json.dumps(lines[-1], ensure_ascii=False) + "\n")
                        out.flush()
    table([line for line in lines if line["cell"] in {c.name for c in chosen}])


if __name__ == "__main__":
    main()
