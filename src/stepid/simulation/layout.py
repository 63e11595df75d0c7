"""Where each parameter of a campaign's plants stands in an array: views by name in place of index arithmetic."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from stepid.core.base import Array, Index
from stepid.effects.base import Effect, Parameter
from stepid.simulation.records import Records

DEVIATIONS: tuple[Parameter, ...] = (
    Parameter("start_time", "s", -np.inf),
    Parameter("gain", "", -np.inf),
    Parameter("damping", "", -np.inf),
    Parameter("friction", "", -np.inf),
    Parameter("stiffness", "", -np.inf),
    Parameter("added_mass", "kg", -np.inf),
)
"""By how much a run differs from the plant: later by, relative change of force gain, damping, dry friction (what an
effect holds the cart with, in N) and stiffness, mass beside what its record says."""
STARTS: tuple[Parameter, ...] = (Parameter("start_offset", "m", -np.inf), Parameter("start_velocity", "m/s", -np.inf))
"""What else a run may differ by: where a cart that is to begin at rest begins, from the spring's rest position."""
LEAST_MASS = 1e-3  # of the largest difference of added masses, or of 1 kg if that is less


@dataclass(frozen=True)
class ParameterLayout:
    """The global parameters of a campaign, shape (P,), and those of each run, shape (Q, R).

    Global: base mass of every base label [kg], stiffness of every spring label [N/m], damping of every damper label
    [N·s/m], force gain [N/V], then each effect's parameters. Per run: displacement [m] and velocity [m/s] at the first
    sample, the effects' run parameters, the effects' own states at the first sample, `DEVIATIONS`.
    """

    records: Records
    effects: tuple[Effect, ...]

    @cached_property
    def base_mass(self) -> slice:
        """Base masses among the global parameters."""
        return slice(0, len(self.records.bases))

    @cached_property
    def stiffness(self) -> slice:
        """Stiffnesses among the global parameters."""
        return slice(self.base_mass.stop, self.base_mass.stop + len(self.records.springs))

    @cached_property
    def damping(self) -> slice:
        """Damping constants among the global parameters."""
        return slice(self.stiffness.stop, self.stiffness.stop + len(self.records.dampers))

    @cached_property
    def force_gain(self) -> int:
        """Place of the force gain among the global parameters."""
        return int(self.damping.stop)

    @cached_property
    def linear(self) -> slice:
        """Parameters of the linear plant among the global ones."""
        return slice(0, self.force_gain + 1)

    @cached_property
    def values(self) -> tuple[slice, ...]:
        """Each effect's parameters among the global ones."""
        out, at = [], self.linear.stop
        for e in self.effects:
            out.append(slice(at, at + len(e.parameters)))
            at += len(e.parameters)
        return tuple(out)

    @cached_property
    def run_values(self) -> tuple[slice, ...]:
        """Each effect's run parameters among those of a run."""
        out, at = [], 2
        for e in self.effects:
            out.append(slice(at, at + len(e.run_parameters)))
            at += len(e.run_parameters)
        return tuple(out)

    @cached_property
    def own_states(self) -> slice:
        """The effects' own states at the first sample among the parameters of a run."""
        first = 2 + sum(len(e.run_parameters) for e in self.effects)
        return slice(first, first + sum(e.n_extra + e.n_memory for e in self.effects))

    @cached_property
    def effect_states(self) -> tuple[slice, ...]:
        """Each effect's own ones of `own_states`."""
        out, at = [], self.own_states.start
        for e in self.effects:
            out.append(slice(at, at + e.n_extra + e.n_memory))
            at = out[-1].stop
        return tuple(out)

    @cached_property
    def deviations(self) -> slice:
        """`DEVIATIONS` among the parameters of a run."""
        return slice(self.own_states.stop, self.own_states.stop + len(DEVIATIONS))

    @cached_property
    def n_states(self) -> int:
        """Number of states of a run: displacement, velocity and the effects' own."""
        return 2 + int(self.own_states.stop - self.own_states.start)

    def deviation(self, name: str) -> int:
        """Row of one of `DEVIATIONS` or `STARTS` among the parameters of a run."""
        return _STARTS.index(name) if name in _STARTS else int(self.deviations.start) + _NAMES.index(name)

    @cached_property
    def n_global(self) -> int:
        """Number of global parameters."""
        return int(self.linear.stop) + sum(len(e.parameters) for e in self.effects)

    @cached_property
    def n_run(self) -> int:
        """Number of parameters of a run."""
        return int(self.deviations.stop)

    def touched(self, parameter: int) -> Index:
        """Runs that a global parameter enters."""
        r = self.records
        for place, labels in ((self.base_mass, r.base), (self.stiffness, r.spring), (self.damping, r.damper)):
            if place.start <= parameter < place.stop:
                return np.flatnonzero(labels == parameter - place.start)
        return np.arange(len(r.runs))

    def mass(self, shared: Array) -> Array:
        """Moving mass of each run, kg, shape (..., R), for global parameters (..., P)."""
        out: Array = shared[..., self.base_mass][..., self.records.base] + self.records.added_mass
        return out

    def rates(self, shared: Array) -> Array:
        """Natural frequency of each run, rad/s, shape (R,), for global parameters (P,)."""
        out: Array = np.sqrt(np.maximum(shared[self.stiffness][self.records.spring], 0.0) / self.mass(shared))
        return out

    def plants(self, shared: Array, local: Array) -> Array:
        """Values of C plants on every run, as the kernel takes them: shape (C, R, values)."""
        places, own = self._columns
        out: Array = np.take(shared, places, axis=1)
        out[..., 0] += self.records.added_mass
        for column, row in own:
            out[..., column] = local[:, row]
        if local[:, self.deviations].any():
            self._deviate(out, local)
        return out

    @cached_property
    def _columns(self) -> tuple[Index, tuple[tuple[int, int], ...]]:
        """Which global parameter each value of each run is, shape (R, values), and which values are a run's own."""
        r = self.records
        plain = np.full(len(r.runs), self.force_gain)
        columns = [r.base, self.stiffness.start + r.spring, self.damping.start + r.damper, plain]
        own: list[tuple[int, int]] = []
        for values, rows in zip(self.values, self.run_values, strict=True):
            columns += [np.full(len(r.runs), at) for at in range(values.start, values.stop)]
            own += [(len(columns) + i, row) for i, row in enumerate(range(rows.start, rows.stop))]
            columns += [plain] * (rows.stop - rows.start)
        return np.stack(columns, axis=1), tuple(own)

    def _deviate(self, plants: Array, local: Array) -> None:
        """Change plants, as `plants` gives them, by what is different in each run."""
        plants[..., 0] = np.maximum(
            plants[..., 0] + local[:, self.deviation("added_mass")], LEAST_MASS * self.records.mass_scale
        )
        changes = [("stiffness", 1), ("damping", 2), ("gain", 3)]
        at = 4
        for effect in self.effects:
            if effect.dry:
                changes += [("friction", at + i) for i, q in enumerate(effect.parameters) if q.force]
            at += len(effect.parameters) + len(effect.run_parameters)
        for name, column in changes:
            plants[..., column] *= 1.0 + local[:, self.deviation(name)]


_NAMES, _STARTS = [q.name for q in DEVIATIONS], [q.name for q in STARTS]


def own_state_names(effects: tuple[Effect, ...]) -> list[str]:
    """Names of the effects' own states, in the order of `ParameterLayout.own_states`: effect and number."""
    return [f"{e.name}.{i + 1}" for e in effects for i in range(e.n_extra + e.n_memory)]
