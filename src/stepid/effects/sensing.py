"""What the reading adds to the true position."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from stepid.effects.base import Effect, Parameter, Scales, Values


class SensorDrift(Effect):
    """The reading drifts at a constant rate."""

    name = "sensor_drift"
    parameters = (Parameter("rate", "m/s", -np.inf),)
    law = "reading + rate·t"
    formula = r"y = x + r t"
    symbols = ("r",)
    seen = "settled part slopes"
    advice = "let the sensor warm up; check for a slipping encoder wheel"
    own_units: ClassVar[tuple[str, ...] | None] = ()
    linear: ClassVar[bool] = True

    def starts(self, scales: Scales) -> Sequence[tuple[float, ...]]:
        return [(0.0,)]

    @staticmethod
    def reading(p: Values, time: float) -> float:
        return p[0] * time
