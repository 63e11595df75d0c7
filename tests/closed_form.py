"""Linear campaigns from the closed form of the step response: no code shared with stepid's readings.

The response of an underdamped plant to a held step is written down, not integrated:
y(t) = y_ss (1 − e^(−σt) (cos ω_d t + σ/ω_d sin ω_d t)), and steps superpose.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stepid.core.experiment import Campaign, Experiment

SAMPLE_TIME = 0.0088542  # s
WEIGHTS = (0.0, 0.5, 1.5, 2.0)  # kg, cases 4 to 7


@dataclass(frozen=True)
class Plant:
    """A linear plant: kg, N/m, N·s/m, N/V."""

    base_mass: float
    stiffness: float
    damping: float
    gain: float = 7.8

    def peak(self, added: float) -> tuple[float, float]:
        """True peak time, s, and overshoot."""
        decay, frequency = self.rates(added)
        return float(np.pi / frequency), float(np.exp(-decay * np.pi / frequency))

    def rates(self, added: float) -> tuple[float, float]:
        """Decay rate and damped frequency, 1/s, with so much mass added."""
        mass = self.base_mass + added
        decay = self.damping / (2 * mass)
        return decay, float(np.sqrt(self.stiffness / mass - decay**2))

    def damping_ratio(self, added: float) -> float:
        decay, frequency = self.rates(added)
        return decay / float(np.hypot(decay, frequency))

    def response(self, time: np.ndarray, added: float, steps: Sequence[tuple[float, float]]) -> np.ndarray:
        """Position, m, after steps given as (time, change of input in V)."""
        decay, frequency = self.rates(added)
        position = np.zeros_like(time)
        for start, size in steps:
            since = np.clip(time - start, 0, None)
            ring = np.cos(frequency * since) + decay / frequency * np.sin(frequency * since)
            position += self.gain / self.stiffness * size * (1 - np.exp(-decay * since) * ring)
        return position


def make_run(
    plant: Plant,
    added: float,
    *,
    name: str = "case 5",
    steps: Sequence[tuple[int, float]] = ((12, 0.5),),
    count: int = 500,
    noise: float = 0.0,
    rng: np.random.Generator | None = None,
    counts_per_meter: float | None = None,
    rest: float = 0.0,
    **labels: object,
) -> Experiment:
    """Make one record: steps are (sample, change of input in V)."""
    time = SAMPLE_TIME * np.arange(count)
    position = rest + plant.response(time, added, [(time[at], size) for at, size in steps])
    if noise:
        position = position + noise * (rng or np.random.default_rng(0)).standard_normal(count)
    if counts_per_meter is not None:
        position = np.round(position * counts_per_meter) / counts_per_meter
    drive = sum((np.where(np.arange(count) >= at, size, 0.0) for at, size in steps), np.zeros(count))
    fields = {"added_mass": added, "spring": "medium", "damper": "1/2 turn", **labels}
    return Experiment(name=name, time=time, position=position, input=drive, counts_per_meter=counts_per_meter, **fields)


def draw_plant(
    rng: np.random.Generator, *, lowest: float = 0.1, highest: float = 0.6, least_peak: float = 11.0
) -> Plant:
    """Draw a plant whose damping ratio lies within bounds in every run and whose earliest peak is late enough."""
    while True:
        plant = Plant(
            base_mass=float(rng.uniform(0.4, 2.0)),
            stiffness=float(np.exp(rng.uniform(np.log(100), np.log(900)))),
            damping=float(np.exp(rng.uniform(np.log(1.5), np.log(40)))),
        )
        with np.errstate(invalid="ignore"):
            ratios = [plant.damping_ratio(w) for w in WEIGHTS]
            first_peak = np.pi / plant.rates(0.0)[1] / SAMPLE_TIME
        if (
            np.all(np.isfinite(ratios))
            and lowest <= min(ratios)
            and max(ratios) <= highest
            and first_peak >= least_peak
        ):
            return plant


def make_campaign(
    plant: Plant,
    rng: np.random.Generator,
    *,
    travel: float = 0.018,
    noise: float = 0.0,
    weight_spread: float = 0.0,
    envelope: float = 1e-3,
    window: float = 1.5,
    lead: int = 12,
) -> Campaign:
    """Make a campaign of four runs, each one step of `travel` m.

    `envelope` is what the swing has decayed to `window` periods before the end of each record;
    `weight_spread` is the standard uncertainty of one 0.5 kg weight, drawn once for each weight.
    """
    weights = 0.5 + weight_spread * rng.standard_normal(4)
    size = travel * plant.stiffness / plant.gain
    runs = []
    for number, nominal in enumerate(WEIGHTS):
        added = float(np.sum(weights[: round(nominal / 0.5)]))
        decay, frequency = plant.rates(added)
        length = np.log(1 / envelope) / decay + window * 2 * np.pi / frequency
        count = lead + int(np.ceil(length / SAMPLE_TIME)) + 1
        time = SAMPLE_TIME * np.arange(count)
        start = time[lead]
        position = plant.response(time, added, [(start, size)])
        if noise:
            position = position + noise * rng.standard_normal(count)
        runs.append(
            Experiment(
                name=f"case {4 + number}",
                time=time,
                position=position,
                input=np.where(np.arange(count) >= lead, size, 0.0),
                added_mass=nominal,
                spring="medium",
                damper="1/2 turn",
            )
        )
    return Campaign(name="closed form", experiments=tuple(runs))
