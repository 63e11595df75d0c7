"""What a plan says: every design with what it would determine, and the advice."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

from stepid.core.base import Model, NonNegative, Positive
from stepid.core.frames import make_frame
from stepid.core.quantities import InputUnit, Motion
from stepid.core.takes import described
from stepid.errors import InputError
from stepid.lab.design.arguments import white_variance
from stepid.lab.design.candidate import Design
from stepid.lab.design.separation import NEEDED, VISIBLE
from stepid.lab.design.text import as_html, as_text, one_line
from stepid.simulation.model import EffectModel, PlantModel

if TYPE_CHECKING:
    from stepid.core.frames import DataFrame
    from stepid.lab.design.check import PlanCheck
    from stepid.plot.trade import Drawn


class Plan(Model):
    """What the runs that one could make would determine of a guessed plant.

    Parameters
    ----------
    plant : PlantModel
        The guess, with the effects that are fitted, too.
    noise : float
        m, standard deviation of the sensor's noise.
    noise_time : float
        s, its correlation time; 0 is white.
    weight_uncertainty : float
        kg, of one 0.5 kg weight.
    wanted : mapping
        Parameter to the largest relative standard uncertainty.
    pair : tuple of EffectModel
        The effects to be told apart, at the sizes that were assumed; empty without.
    designs : tuple of Design
        All that were compared.
    advised : int
        Index of the advice among them.
    motion, input_unit : str
        Of the campaign, see `stepid.Campaign`.
    """

    plant: PlantModel
    noise: Positive
    noise_time: NonNegative = 0.0
    weight_uncertainty: NonNegative
    wanted: Mapping[str, Positive]
    pair: tuple[EffectModel, ...] = ()
    designs: tuple[Design, ...]
    advised: int
    motion: Motion = "translation"
    input_unit: InputUnit = "V"

    @property
    def advice(self) -> Design:
        """The design with the fewest runs that gives what is wanted, or comes nearest."""
        return self.designs[self.advised]

    @property
    def suffices(self) -> bool:
        """Whether the advice gives all that is wanted."""
        return self.shortfall(self.advice) <= 1

    @property
    def values(self) -> dict[str, float]:
        """The guessed value of each parameter that is wanted to some precision, SI units."""
        linear = {"base_mass": self.plant.base_mass, "stiffness": self.plant.stiffness, "damping": self.plant.damping}
        out = {"force_gain": self.plant.force_gain}
        for name, by_label in linear.items():
            ((label, value),) = by_label.items()
            out[name if name == "base_mass" else f"{name}[{label}]"] = value
        out |= {f"{e.name}.{q}": value for e in self.plant.effects for q, value in e.values.items()}
        return out

    def variance(self, sample_time: float) -> float:
        """Variance of the white noise that would tell as much at a sample time [s], m²."""
        return white_variance(self.noise, self.noise_time, sample_time)

    def relative(self, design: Design, name: str) -> float:
        """Predicted standard uncertainty of a parameter over its guessed value; infinite where not determined."""
        spread, value = design.uncertainty[name], self.values[name]
        return math.inf if spread is None or value == 0 else spread / abs(value)

    def shortfall(self, design: Design) -> float:
        """How many times too uncertain the design leaves what it does worst; 1 or less suffices."""
        worst = max((self.relative(design, name) / limit for name, limit in self.wanted.items()), default=0.0)
        if self.pair:
            seen = [(design.misfit or 1.0) ** 2 - 1, VISIBLE**2 - 1]
            chi = [design.separation if design.separation is not None else NEEDED, NEEDED]
            worst = max(worst, *(math.sqrt(need / has) if has > 0 else math.inf for has, need in (seen, chi)))
        return worst

    def best(self, runs: int) -> Design:
        """The design with that many runs that comes nearest to what is wanted.

        Raises
        ------
        stepid.errors.InputError
            If none has so many.
        """
        able = [d for d in self.designs if d.runs == runs]
        if not able:
            counts = ", ".join(map(str, sorted({d.runs for d in self.designs})))
            raise InputError(f"runs is {described(runs)}: no design has so many", f"Give one of {counts}.")
        return min(able, key=self.shortfall)

    def check(self, count: int = 100, *, seed: int = 0) -> PlanCheck:
        """Carry out the advice in simulation, fit each campaign, and compare the scatter with the prediction.

        Parameters
        ----------
        count : int
            Campaigns, 10 or more.
        seed : int
            Of noise and weights.

        Returns
        -------
        PlanCheck
        """
        from stepid.lab.design.check import check

        return check(self, count=count, seed=seed)

    def plot(self, *, axes: Drawn | None = None) -> Drawn:
        """Draw the trade: what each design determines against its number of runs, and the advice.

        Parameters
        ----------
        axes : mapping of str to matplotlib.axes.Axes, optional
            By parameter (and ``"separation"``); a new figure if not given.

        Returns
        -------
        dict
            Parameter to axes.
        """
        from stepid.lab.design.picture import draw

        return draw(self, axes)

    def summary(self) -> str:
        """Return the advice in words, with a table of the best design for each number of runs."""
        return as_text(self)

    def to_dataframe(self) -> DataFrame:
        """Return a pandas DataFrame, one row a design, its uncertainties in columns of their own."""
        rows = [_row(design) for design in self.designs]
        return make_frame({name: [row[name] for row in rows] for name in rows[0]})

    def __repr__(self) -> str:
        return one_line(self)

    def __str__(self) -> str:
        return self.summary()

    def _repr_html_(self) -> str:
        return as_html(self)


def _row(design: Design) -> dict[str, object]:
    out: dict[str, object] = {
        "runs": design.runs,
        "added_masses": design.added_masses,
        "levels": design.levels,
        "back": design.back,
        "sample_time": design.sample_time,
        "duration": design.duration,
        "separation": design.separation,
        "misfit": design.misfit,
    }
    return out | {f"uncertainty.{name}": value for name, value in design.uncertainty.items()}
