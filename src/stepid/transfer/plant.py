"""One run's plant as numbers: the same law and tables that the simulator uses, on one lane."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stepid.core.base import Array
from stepid.core.experiment import Campaign, Experiment
from stepid.effects import Effect, resolve
from stepid.errors import InputError
from stepid.simulation.law import DAMPING, GAIN, MASS, STIFFNESS, TIME, VOLTS, Law
from stepid.simulation.model import PlantModel, RunState
from stepid.simulation.records import lay_out
from stepid.simulation.simulate import own_states, pack
from stepid.simulation.tables import Point, Tables

_ROWS = {"mass": MASS, "stiffness": STIFFNESS, "damping": DAMPING, "force_gain": GAIN}


@dataclass(frozen=True)
class Plant:
    """A plant model for one run.

    `law` knows the equations; `parameters` maps the names that python-control's `params` use to values; `start` (d,) is
    the state at the first sample at which the cart is free.
    """

    law: Law
    parameters: dict[str, float]
    rows: dict[str, int]
    start: Array

    @property
    def states(self) -> list[str]:
        """Names of the states: displacement and velocity, then the effects' own."""
        return ["displacement", "velocity", *own_states(self.law.effects)]

    def table(self, parameters: dict[str, float], *, time: float, volts: float) -> Array:
        """Lane table of one lane, shape (n_rows, 1)."""
        out = np.zeros((self.law.n_rows, 1))
        for name, row in self.rows.items():
            out[row] = parameters[name]
        out[TIME], out[VOLTS] = time, volts
        return out

    def rates(self, table: Array, state: Array) -> Array:
        """Rates of all states, shape (d,)."""
        law, z = self.law, np.asarray(state, dtype=np.float64)[:, None]
        sign = np.where(z[1] < 0, -1.0, 1.0) if law.reverses else np.ones(1)
        sides = np.where(law.switches(table, z, 0.0) < 0, -1.0, 1.0)
        out = np.empty((law.n_states, 1))
        law.rates(table, z, sign, 0.0, sides, out)
        for place in law.places:
            if place.effect.n_memory:
                m = law.motion(table, place, z, sign, 0.0, sides)
                out[place.memory] = z[1] * np.array(place.effect.memory_slopes(law.values(table, place), m))
        return out[:, 0]

    def reading(self, table: Array, parameters: dict[str, float], state: Array) -> float:
        """What the sensor reads, m: the displacement, the rest position and what the effects add."""
        total = float(state[0]) + parameters["rest"]
        for place in self.law.places:
            if type(place.effect).reading is not Effect.reading:
                total += float(np.sum(place.effect.reading(self.law.values(table, place), table[TIME])))
        return total


def plant_of(model: PlantModel, run: Experiment | str, *, catalogue: tuple[Effect, ...]) -> Plant:
    """Read one run's plant off a model.

    Raises
    ------
    stepid.errors.InputError
        If `run` is a name only, the model lacks one of its labels, or an effect is not in the catalogue.
    """
    if not isinstance(run, Experiment):
        raise InputError(
            f"a plant model does not know the labels and the added mass of run {run!r}",
            f"Hand over the run itself: campaign[{run!r}].",
        )
    effects = resolve([e.name for e in model.effects], catalogue=catalogue)
    records = lay_out(Campaign(name=run.name, experiments=(run,)))
    tables = Tables(records, effects)
    shared, local = pack(model, records, effects)
    point = Point(shared[None], local[None])
    column = tables.run_table(point)[:, 0, 0]
    rows = dict(_ROWS)
    for place in tables.law.places:
        named = (*place.effect.parameters, *place.effect.run_parameters)
        rows |= {f"{place.effect.name}.{q.name}": place.values.start + i for i, q in enumerate(named)}
    parameters = {name: float(column[row]) for name, row in rows.items()}
    parameters["rest"] = model.runs.get(run.name, RunState()).rest
    return Plant(tables.law, parameters, rows, tables.initial(point)[:, 0, 0])
