"""Candidate designs: which runs, sampled how fast, and the records that they would give."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from typing import NamedTuple, Self

import numpy as np
from pydantic import model_validator

from stepid.core.base import Finite, Model, NonNegative, Positive
from stepid.core.experiment import Campaign, Experiment
from stepid.simulation.model import PlantModel, parameter_unit

BEFORE = 8  # samples at rest before the step
LEAST = 40  # samples of a record


class Step(NamedTuple):
    """One run: kg added, V of the step, s between samples, and whether it steps back to 0 V halfway."""

    added_mass: float
    level: float
    sample_time: float
    back: bool


class Design(Model):
    """A set of runs that one could make, with what it would determine.

    Parameters
    ----------
    added_masses : tuple of float
        kg, one a run.
    levels : tuple of float
        V, height of each run's step.
    back : bool
        The input steps back to 0 V halfway through each record.
    sample_time, duration : float
        s, of each record.
    uncertainty : mapping
        Predicted standard uncertainty of each parameter, named as in `stepid.fit`; None where it is not determined.
    from_noise, from_weights : mapping
        Its two parts: what the sensor's noise and what the weights' uncertainty makes.
    separation : float or None
        Expected χ² of the wrong effect of the pair that is to be told apart, beyond that of the right one; the smaller
        of both ways round.
    misfit : float or None
        What a plant without either is expected to leave, over the noise; the smaller of both.
    """

    added_masses: tuple[NonNegative, ...]
    levels: tuple[Finite, ...]
    back: bool
    sample_time: Positive
    duration: Positive
    uncertainty: Mapping[str, NonNegative | None] = {}
    from_noise: Mapping[str, NonNegative | None] = {}
    from_weights: Mapping[str, NonNegative | None] = {}
    separation: NonNegative | None = None
    misfit: NonNegative | None = None

    def _unit(self, field: str, key: str = "") -> str:
        parted = field in ("uncertainty", "from_noise", "from_weights")
        return parameter_unit(key) if parted else super()._unit(field, key)

    @model_validator(mode="after")
    def _pairs(self) -> Self:
        if len(self.added_masses) != len(self.levels) or not self.levels:
            raise ValueError("added_masses and levels: give one of each for every run")
        return self

    @property
    def runs(self) -> int:
        """Number of runs."""
        return len(self.levels)

    @property
    def samples(self) -> int:
        """Number of samples in all."""
        return self.runs * round(self.duration / self.sample_time)

    @property
    def steps(self) -> list[Step]:
        """The runs one by one."""
        pairs = zip(self.added_masses, self.levels, strict=True)
        return [Step(mass, level, self.sample_time, self.back) for mass, level in pairs]

    def campaign(
        self, plant: PlantModel, *, positions: Sequence[object] | None = None, weight_uncertainty: float = 0.005
    ) -> Campaign:
        """Make the design's campaign, with the labels of a plant.

        Parameters
        ----------
        plant : PlantModel
            With one label each of base, spring and damper.
        positions : sequence of array, optional
            m, the readings of each run; zeros by default.
        weight_uncertainty : float
            kg, as of `stepid.Campaign`.

        Returns
        -------
        Campaign
        """
        runs = [record(step, plant, self.duration, f"run {i}") for i, step in enumerate(self.steps, 1)]
        if positions is not None:
            runs = [Experiment(**(e.model_dump() | {"position": x})) for e, x in zip(runs, positions, strict=True)]
        return Campaign(name="planned", experiments=tuple(runs), weight_uncertainty=weight_uncertainty)

    def __repr__(self) -> str:
        back = ", and back" if self.back else ""
        return f"Design({self.runs} runs{back}, every {self.sample_time * 1e3:.3g} ms)"


def record(step: Step, plant: PlantModel, duration: float, name: str) -> Experiment:
    """Make the record of one run without positions."""
    count = round(duration / step.sample_time)
    volts = np.full(count, step.level)
    volts[:BEFORE] = 0.0
    if step.back:
        volts[BEFORE + (count - BEFORE) // 2 :] = 0.0
    (base,), (spring,), (damper,) = plant.base_mass, plant.stiffness, plant.damping
    return Experiment(
        name=name,
        time=step.sample_time * np.arange(count, dtype=np.float64),
        position=np.zeros(count),
        input=volts,
        added_mass=step.added_mass,
        spring=spring,
        damper=damper,
        base=base,
        starts="rest",
    )


def enumerate_designs(
    masses: Sequence[float],
    levels: Sequence[float],
    sample_times: Sequence[float],
    runs: Sequence[int],
    duration: float,
) -> list[Design]:
    """All combinations: masses at both ends or spread, one level or two of them, with and without a step back."""
    patterns: list[tuple[float, ...]] = [(level,) for level in levels]
    patterns += [(one, two) for i, one in enumerate(levels) for two in levels[i + 1 :]]
    found: dict[tuple[object, ...], Design] = {}
    for count, pattern, back, sample_time in product(runs, patterns, (False, True), sample_times):
        for weights in _weights(sorted(masses), count):
            turn = len(set(weights))
            # after each turn through the masses the levels move on by one, so that each mass gets every level
            given = tuple(pattern[(i + i // turn) % len(pattern)] for i in range(count))
            key = (tuple(sorted(zip(weights, given, strict=True))), back, sample_time)
            found.setdefault(
                key,
                Design(added_masses=weights, levels=given, back=back, sample_time=sample_time, duration=duration),
            )
    return list(found.values())


def _weights(masses: list[float], count: int) -> Iterator[tuple[float, ...]]:
    yield tuple(masses[0] if i % 2 == 0 else masses[-1] for i in range(count))
    if count > 2 and len(masses) > 2:
        turn = min(count, len(masses))
        places = np.linspace(0, len(masses) - 1, turn).round().astype(int)
        yield tuple(masses[places[i % turn]] for i in range(count))
