"""A step of the paper's plant for the hidden simulator."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from exact_plants import PERIOD
from hidden import Run


def paper_run(**changes: object) -> Run:
    inputs = np.zeros(400)
    inputs[5:200] = 0.5
    run = Run(mass=1.45, stiffness=216.0, damping=6.0, gain=7.8, sample_time=PERIOD, inputs=inputs, phase=0.7)
    return replace(run, **changes)  # type: ignore[arg-type]
