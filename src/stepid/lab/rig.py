"""The imagined rig behind a blind campaign: its plant, its runs, its encoder and its noise."""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple, Self

import numpy as np
from pydantic import Field, model_validator

from stepid.core.base import Array, Finite, Label, Model, NonNegative, Positive
from stepid.core.experiment import Experiment
from stepid.core.takes import number, taken
from stepid.identification.second_order import overshoot_of_plant

_FEWEST = 20  # samples before and after the step back


class RunPlan(Model):
    """One run: weights on the cart and the voltage of the step.

    Parameters
    ----------
    name : str
    added_mass : float
        kg.
    level : float
        V, either sign, not zero.
    """

    name: Label
    added_mass: NonNegative
    level: Finite

    @model_validator(mode="after")
    def _steps(self) -> Self:
        if self.level == 0:
            raise ValueError("a step of 0 V moves nothing; give a voltage of either sign")
        return self


RUNS = (
    RunPlan(name="run 1", added_mass=0.0, level=0.5),
    RunPlan(name="run 2", added_mass=0.5, level=-0.5),
    RunPlan(name="run 3", added_mass=1.5, level=0.4),
    RunPlan(name="run 4", added_mass=2.0, level=0.3),
)


class Rig(Model):
    """A rig: the plant's usual values, how much groups differ, what is recorded and how noisy it is.

    All groups make the same runs, whatever is hidden. The defaults are of the size of the plant in Burchett's Table 2;
    four masses, three step sizes, both directions and a step back let as many effects as possible be told apart.

    Parameters
    ----------
    base_mass, stiffness, damping, force_gain : float
        kg, N/m, N·s/m, N/V: middle of what the groups' plants have.
    spread : float
        Largest relative deviation of a group's plant from the middle, below 0.5.
    runs : tuple of RunPlan
        At least two different added masses.
    spring, damper, base : str
        Labels.
    sample_time : float
        s.
    counts_per_meter : float
        Of the encoder; every reading is a whole count.
    before, hold, after : float
        s, at rest before the step, under the step, and after the step back.
    noise : float
        m, standard deviation of the reading's noise, rounding to counts not included.
    drive_noise : float
        V, standard deviation of the amplifier's noise, new at every sample and not recorded (process noise). It moves
        the cart slowly, which no model of the plant explains; by default by less than the encoder's count.
    """

    base_mass: Positive = 0.95
    stiffness: Positive = 216.0
    damping: Positive = 12.0
    force_gain: Positive = 7.8
    spread: Annotated[float, Field(ge=0, lt=0.5)] = 0.15
    runs: tuple[RunPlan, ...] = RUNS
    spring: Label = "medium"
    damper: Label = "1/2 turn"
    base: Label = "cart"
    sample_time: Positive = 0.0088542
    counts_per_meter: Positive = 226600.0
    before: NonNegative = 0.1
    hold: Positive = 3.0
    after: NonNegative = 3.0
    noise: NonNegative = 10e-6
    drive_noise: NonNegative = 2e-5

    @model_validator(mode="after")
    def _useful(self) -> Self:
        if len({run.name for run in self.runs}) < len(self.runs):
            raise ValueError("runs: a name is used twice; give each run its own")
        if len({run.added_mass for run in self.runs}) < 2:
            raise ValueError("runs: need two different added masses, else nobody can know the mass")
        if self.hold < _FEWEST * self.sample_time:
            raise ValueError(f"hold: must last {_FEWEST} samples at least")
        return self

    @property
    def labels(self) -> tuple[str, str, str, str]:
        """Names of the linear parameters, as in `stepid.fit`."""
        return ("base_mass", f"stiffness[{self.spring}]", f"damping[{self.damper}]", "force_gain")

    def inputs(self, level: float) -> Array:
        """Input of a run, V, shape (n,): zero, the step, zero again."""
        taken("Rig.inputs", "level", level, number("a level in V"))
        begin = round(self.before / self.sample_time)
        end = begin + round(self.hold / self.sample_time)
        volts = np.zeros(end + round(self.after / self.sample_time))
        volts[begin:end] = level
        return volts

    def experiment(self, plan: RunPlan, *, position: Array, input: Array) -> Experiment:
        """Make the record of one run.

        Parameters
        ----------
        plan : RunPlan
        position, input : array, shape (n,)
            m and V.

        Returns
        -------
        Experiment
        """
        return Experiment(
            name=plan.name,
            time=self.sample_time * np.arange(position.size, dtype=np.float64),
            position=position,
            input=input,
            added_mass=plan.added_mass,
            spring=self.spring,
            damper=self.damper,
            base=self.base,
            counts_per_meter=self.counts_per_meter,
        )


class Plant(NamedTuple):
    """One group's linear plant: kg, N/m, N·s/m, N/V."""

    mass: float
    stiffness: float
    damping: float
    gain: float


class Scale(NamedTuple):
    """Magnitudes by which effects are sized.

    `reach` [m] is the static displacement of the largest step, `peak` [m] the farthest overshoot with its sign, `rate`
    [rad/s] the natural frequency of the empty cart, `heavy` [kg] the mean moving mass.
    """

    plant: Plant
    reach: float
    peak: float
    rate: float
    volts: float
    heavy: float
    duration: float
    sample_time: float


def draw_plant(rig: Rig, stream: np.random.Generator) -> Plant:
    """Draw a group's plant: each value within the rig's spread."""
    middle = (rig.base_mass, rig.stiffness, rig.damping, rig.force_gain)
    return Plant(*(float(value * (1 + rig.spread * stream.uniform(-1, 1))) for value in middle))


def scale_of(rig: Rig, plant: Plant) -> Scale:
    """Magnitudes of the motion that a rig's runs give to a plant."""
    volts = max(abs(run.level) for run in rig.runs)
    swings = [overshoot_of_plant(plant.mass + run.added_mass, plant.stiffness, plant.damping) for run in rig.runs]
    peaks = [plant.gain * run.level / plant.stiffness * (1 + m) for run, m in zip(rig.runs, swings, strict=True)]
    return Scale(
        plant=plant,
        reach=plant.gain * volts / plant.stiffness,
        peak=max(peaks, key=abs),
        rate=math.sqrt(plant.stiffness / plant.mass),
        volts=volts,
        heavy=plant.mass + sum(run.added_mass for run in rig.runs) / len(rig.runs),
        duration=rig.before + rig.hold + rig.after,
        sample_time=rig.sample_time,
    )
