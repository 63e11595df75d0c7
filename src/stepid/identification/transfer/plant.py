"""One run's plant as numbers: the same laws that the simulator compiles, called as they are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stepid.core.base import Array
from stepid.core.experiment import Campaign, Experiment
from stepid.effects import Effect, resolve
from stepid.effects.base import Moment
from stepid.errors import InputError
from stepid.simulation.layout import own_state_names
from stepid.simulation.model import PlantModel, RunState
from stepid.simulation.records import lay_out
from stepid.simulation.simulate import pack
from stepid.simulation.simulator import Simulator

_LINEAR = ("mass", "stiffness", "damping", "force_gain")


@dataclass(frozen=True)
class Plant:
    """A plant model for one run.

    `parameters` maps the names that python-control's `params` use to values; `start` (d,) is the state at the first
    sample at which the cart is free.
    """

    effects: tuple[Effect, ...]
    parameters: dict[str, float]
    start: Array

    @property
    def states(self) -> list[str]:
        """Names of the states: displacement and velocity, then the effects' own."""
        return ["displacement", "velocity", *own_state_names(self.effects)]

    def _values(self, effect: Effect, parameters: dict[str, float]) -> tuple[float, ...]:
        return tuple(parameters[f"{effect.name}.{q.name}"] for q in (*effect.parameters, *effect.run_parameters))

    def rates(self, parameters: dict[str, float], state: Array, *, time: float, volts: float) -> Array:
        """Rates of all states, shape (d,)."""
        mass, stiffness, damping, gain = (parameters[name] for name in _LINEAR)
        x, v = float(state[0]), float(state[1])
        out = np.zeros(len(state))
        force, driven, at = -stiffness * x - damping * v, volts, {}
        own = 2
        for e in self.effects:
            at[e.name], own = own, own + e.n_extra + e.n_memory
        for e in sorted(self.effects, key=lambda e: e.drive_order):
            first, middle = at[e.name], at[e.name] + e.n_extra
            drives = type(e).drive is not Effect.drive
            m = Moment(
                x, v, -1.0 if v < 0 else 1.0, time, mass, stiffness, damping, driven if drives else volts,
                (), tuple(state[first:middle].tolist()), tuple(state[middle : middle + e.n_memory].tolist()),
            )  # fmt: skip
            p = self._values(e, parameters)
            m = m._replace(sides=tuple(-1.0 if s < 0 else 1.0 for s in e.switches(p, m)))
            force += e.force(p, m) - m.sign * e.friction(p, m)
            driven = e.drive(p, m) if drives else driven
            out[first:middle] = e.rates(p, m)
            if e.n_memory:
                out[middle : middle + e.n_memory] = v * np.array(e.memory_slopes(p, m))
        out[:2] = v, (force + gain * driven) / mass
        return out

    def reading(self, parameters: dict[str, float], state: Array, *, time: float) -> float:
        """What the sensor reads, m: the displacement, the rest position and what the effects add."""
        added = sum(e.reading(self._values(e, parameters), time) for e in self.effects)
        return float(state[0]) + parameters["rest"] + added


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
    shared, local = pack(model, records, effects)
    sim = Simulator(records, effects)
    names = [f"{e.name}.{q.name}" for e in effects for q in (*e.parameters, *e.run_parameters)]
    values = sim.layout.plants(shared[None], local[None])[0, 0]
    parameters = dict(zip([*_LINEAR, *names], map(float, values), strict=True))
    parameters["rest"] = model.runs.get(run.name, RunState()).rest
    return Plant(effects, parameters, sim.start(shared, local)[:, 0])
