"""Draw the pictures of the README and the docs. Run with ``python docs/make_pictures.py``."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl

import stepid

STATIC = Path(__file__).parent / "_static"


def main() -> None:
    mpl.use("Agg")
    campaign = stepid.datasets.lab_campaign()
    verified = stepid.verify(stepid.identify(campaign), campaign)
    four = stepid.Verification(runs=tuple(verified[f"case {i}"] for i in (4, 5, 6, 7)))
    stepid.plot.save(stepid.plot.verification_grid(four, columns=2)[0, 0], STATIC / "verification.png")
    stepid.plot.save(stepid.plot.verification(verified["case 7"])[0], STATIC / "case-7.png")
    stepid.plot.save(stepid.plot.diagnosis(stepid.diagnose(campaign))["gap"], STATIC / "diagnosis.png")
    plan = stepid.plan(
        {"base_mass": 0.95, "stiffness": 216.0, "damping": 12.0, "force_gain": 7.8},
        noise=200e-6,
        masses=(0.0, 1.0, 2.0),
        sample_times=(0.005, 0.01),
        runs=(2, 4, 6, 8),
        wanted={"base_mass": 0.008, "stiffness": 0.006, "damping": 0.006},
        separate=("actuator_dead_zone", "coulomb_friction"),
    )
    stepid.plot.save(plan.plot()["base_mass"], STATIC / "plan.png")


if __name__ == "__main__":
    main()
