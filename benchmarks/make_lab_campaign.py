"""Make the made-up lab campaign that comes with stepid: Table 1 of the paper, with Coulomb friction hidden in it.

    python benchmarks/make_lab_campaign.py [--out FOLDER]

The simulator is the one of the tests (tests/hidden), which shares no code with the package. Without --out the package's
own data are made again; the result is the same every time.
"""

from __future__ import annotations

import argparse
import shutil
import sys
from pathlib import Path

import numpy as np

import stepid

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests"))

from hidden import Run, reference  # noqa: E402

PERIOD, SCALE, VOLTS, GAIN = 0.0088542, 226600.0, 0.5, 7.8
STIFFNESS = {"light": 175.0, "medium": 216.0, "stiff": 450.0}
DAMPING = {"1/2 turn": 12.0, "4 turns": 22.0, "none": 4.6, "plug removed": 5.0}
BASE = {"cart": 0.95, "cart, no damper": 0.83}  # the moving half of the damper weighs 120 g
FRICTION, NOISE = 0.3, 20e-6
CASES = (
    ("case 1", 1.0, "1/2 turn", "medium", "cart"),
    ("case 2", 1.0, "4 turns", "medium", "cart"),
    ("case 3", 1.0, "none", "medium", "cart, no damper"),
    ("case 3b", 1.0, "plug removed", "medium", "cart"),
    ("case 4", 0.0, "1/2 turn", "medium", "cart"),
    ("case 5", 0.5, "1/2 turn", "medium", "cart"),
    ("case 6", 1.5, "1/2 turn", "medium", "cart"),
    ("case 7", 2.0, "1/2 turn", "medium", "cart"),
    ("case 8", 1.0, "1/2 turn", "stiff", "cart"),
    ("case 9", 1.0, "1/2 turn", "light", "cart"),
)


def make() -> stepid.Campaign:
    """Simulate, add noise, count."""
    rng = np.random.default_rng(2005)
    experiments = []
    for name, added, damper, spring, base in CASES:
        first, size = int(rng.integers(2, 9)), int(rng.integers(640, 678))
        volts = np.zeros(size)
        volts[first : size // 2] = VOLTS
        band = FRICTION / STIFFNESS[spring]
        run = Run(
            mass=BASE[base] + added,
            stiffness=STIFFNESS[spring],
            damping=DAMPING[damper],
            gain=GAIN,
            sample_time=PERIOD,
            inputs=volts,
            effects={"coulomb_friction": {"level": FRICTION}},
            position=float(rng.uniform(-0.8, 0.8)) * band,  # friction lets it rest anywhere in the band
        )
        # the encoder is zeroed where the cart happens to rest
        reading = reference(run) - run.start + NOISE * rng.standard_normal(size)
        experiments.append(
            stepid.Experiment(
                name=name,
                time=PERIOD * np.arange(size),
                position=np.round(reading * SCALE) / SCALE,
                input=volts,
                added_mass=added,
                spring=spring,
                damper=damper,
                base=base,
                counts_per_meter=SCALE,
            )
        )
    return stepid.Campaign(name="made-up lab, Table 1", experiments=tuple(experiments))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=ROOT / "src" / "stepid" / "datasets" / "lab")
    folder = parser.parse_args().out
    if folder == parser.get_default("out"):
        shutil.rmtree(folder, ignore_errors=True)  # our own data, made again below
    print(stepid.write_campaign(make(), folder))
    truth = stepid.datasets.LabTruth(
        base_mass=BASE,
        stiffness=STIFFNESS,
        damping=DAMPING,
        force_gain=GAIN,
        effects=("coulomb_friction",),
        parameters={"coulomb_friction.level": FRICTION},
        noise_rms=float(np.hypot(NOISE, 1 / SCALE / np.sqrt(12))),
    )
    (folder / "truth.json").write_text(truth.model_dump_json(indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
