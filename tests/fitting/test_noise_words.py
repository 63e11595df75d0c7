"""How noise that is not white is told."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from stepid.fitting import hum, noise_color


@pytest.mark.parametrize(
    ("rate", "frequency", "told"),
    [(100.0, 40.0, "60 Hz"), (80.0, 30.0, "50 Hz"), (100.0, 38.0, ""), (500.0, 60.0, ""), (100.0, 20.0, "")],
)
def test_samples_too_slow_for_the_mains_show_its_hum_elsewhere(rate: float, frequency: float, told: str) -> None:
    records: Any = SimpleNamespace(sample_time=np.full(3, 1 / rate))
    said = hum._of_mains(records, frequency, 0.2)
    assert (told in said) if told else said == ""


def test_noise_without_a_time_of_its_own_is_told_as_that() -> None:
    sizes = {"white": 1e-6, "colored": 44.1e-6, "effective_samples": 9.0}
    slow = noise_color.NoiseColor(kind="1/f", correlation_time=10.0, **sizes)
    assert slow.words == "The noise of the readings is colored: 44.1 µm of it are 1/f noise, which wanders."
    fast = noise_color.NoiseColor(kind="ar1", correlation_time=4e-3, **sizes)
    assert fast.words.endswith("correlated over 4 ms.")
