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


if __name__ == "__main__":
    main()
