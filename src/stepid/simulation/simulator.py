"""All records of a campaign simulated for given plants, with the derivatives that a fit needs."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from stepid.core.base import Array, Index
from stepid.effects.base import Effect
from stepid.simulation.homogeneity import Homogeneity
from stepid.simulation.layout import ParameterLayout
from stepid.simulation.magnitudes import exponents, magnitudes
from stepid.simulation.records import Records

Mask = npt.NDArray[np.bool_]

FINE = 1e-8  # of the typical displacement, error of one step: RMS errors below a thousandth of a count on a 2 cm swing
COARSE = 1e-6  # the same while searching
SEEN = 40  # steps a sample, `HASTY` times (COARSE / FINE)^(1/5): a mode that needs more is too fast to show in them
HASTY = 15  # the same while searching: what ends a fit needs a tenth of it, 4 where friction falls within 10 µm/s
PATIENT = 20_000  # the same where one plant is to be simulated, whatever it takes
_STILL = 1e-9  # m, a record that moves less does not move
_TRAVEL = 1e-3  # m, where nothing says how far a plant goes: no input, no displacement
STEEPEST = 1e120  # a derivative whose square would overflow
_DIFFERENCE = 1e-5  # relative step of a forward difference


@dataclass(frozen=True, eq=False)
class Solved:
    """A simulated campaign.

    `states` (2, S) are position from rest [m] and velocity [m/s], `reading` (S,) what the sensor says [m];
    `derivatives` (P, S) and (Q, S) are its derivatives by the global and the per-run parameters, zero by those that are
    not wanted, simulated when they are first asked for.
    """

    states: Array
    reading: Array
    derive: Callable[[], tuple[Array, Array]] | None = None

    @cached_property
    def derivatives(self) -> tuple[Array, Array]:
        """Derivatives of the reading by the global and the per-run parameters."""
        assert self.derive is not None
        return self.derive()


class Simulator:
    """Simulates all records of a campaign for one structure of plant.

    Derivatives are forward differences of copies of the plant: measured beside tangents and closed forms, they cost one
    simulation a parameter and know nothing of the law, so that they hold for every effect, one from outside too. A
    parameter of some runs costs those runs only; what follows from other derivatives costs nothing, see
    `stepid.simulation.homogeneity`.

    Parameters
    ----------
    records : Records
    effects : tuple of Effect
    tolerance : float
        Error of one step, as a share of the typical displacement.
    workers : int
        Threads.
    patience : int, optional
        See `stepid.simulation.kernel.simulate`; by default as the tolerance asks for.

    `taken` are the kernel's steps so far: work that no clock measures.
    """

    def __init__(
        self,
        records: Records,
        effects: tuple[Effect, ...],
        tolerance: float = FINE,
        *,
        workers: int = 1,
        patience: int | None = None,
    ) -> None:
        from stepid.simulation.work import check_size, leaps

        check_size(effects)
        self.records, self.effects, self.tolerance = records, effects, tolerance
        self.workers = workers
        self.patience = patience or (SEEN if tolerance < COARSE else HASTY)
        self.layout = ParameterLayout(records, effects)
        self.linear = all(e.linear for e in effects)
        self._leaps = leaps(effects)
        self.taken = 0
        self.scale = max(records.extent, _STILL)
        self.moves = self.scale > _STILL  # whether anything does in the records
        self._powers = exponents(tuple(q for e in effects for q in e.parameters))
        self._stepped: tuple[bytes, Array] | None = None
        self._planned: tuple[bytes, tuple[Index, Index, Index]] | None = None
        self._tiled: tuple[int, Index, Index] | None = None

    # ---- magnitudes -----------------------------------------------------------------------------------------------

    def steps(self, shared: Array) -> Array:
        """Finite-difference steps of global and per-run parameters, shape (P + Q,): the last call's are kept."""
        key, of = shared.tobytes(), self.layout
        if self._stepped is None or self._stepped[0] != key:
            typical, local = self.typical(shared), np.full(of.n_run, _DIFFERENCE)
            local[:2] = _DIFFERENCE * self.scale, 10 * _DIFFERENCE * self.scale
            local[of.own_states] = _DIFFERENCE * self.scale
            local[of.deviation("added_mass")] *= typical[of.base_mass.start]
            self._stepped = key, np.concatenate([_DIFFERENCE * np.maximum(np.abs(shared), 1e-2 * typical), local])
        return self._stepped[1]

    @cached_property
    def _homogeneity(self) -> Homogeneity:
        return Homogeneity(self.layout, self.scale)

    def typical(self, shared: Array) -> Array:
        """Magnitudes by which the global parameters are judged."""
        of = self.layout
        mass, stiffness = np.abs(shared[of.base_mass]).max(), np.abs(shared[of.stiffness]).max()
        out = np.maximum(np.abs(shared), 1e-12)
        if len(self._powers):
            own = magnitudes(
                self._powers, mass=mass, stiffness=stiffness, gain=float(shared[of.force_gain]), travel=self.scale
            )
            out[of.linear.stop :] = np.maximum(out[of.linear.stop :], own)  # at zero, too, there is a slope to find
        out[of.base_mass] = max(mass, 0.1 * self.records.mass_scale)
        out[of.damping] = np.sqrt(mass * stiffness)
        return out

    # ---- the kernel -----------------------------------------------------------------------------------------------

    def _run(self, values: Array, start: Array, run: Index, offset: Index, reading: Array, states: Array) -> None:
        """Simulate replicas: plants `values` (L, ·), beginning as `start` (L, ·) says, on runs `run` (L,)."""
        from stepid.simulation import kernel
        from stepid.simulation.work import structure

        r = self.records
        leaps = self._leaps if r.coefficients.shape[1] == 1 else 0
        values, start = np.ascontiguousarray(values), np.ascontiguousarray(start)
        scale = self.scale
        if not self.moves:  # records without motion, of a plant that is to be simulated only
            mass, stiffness, gain = values[:, 0], np.abs(values[:, 1]), values[:, 3]
            swing = np.abs(start[:, 0]) + np.abs(start[:, 1]) * np.sqrt(mass / stiffness)
            answer = np.abs(gain * np.abs(np.append(r.volts, r.before)).max()) / stiffness
            scale = float((answer + swing).max()) or _TRAVEL

        def some(replicas: slice) -> int:
            work = structure(self.effects)
            kernel.simulate(
                work, values[replicas], start[replicas], run[replicas],
                r.bounds, r.time, r.coefficients, r.before, r.moving,
                self.tolerance * scale, scale, leaps, self.patience, offset[replicas], reading, states,
            )  # fmt: skip
            return int(work["taken"][0])

        if self.workers == 1 or len(run) <= 1:
            self.taken += some(slice(None))
            return
        ends = np.linspace(0, len(run), min(self.workers, len(run)) + 1).astype(int)
        with ThreadPoolExecutor(self.workers) as pool:
            self.taken += sum(pool.map(some, [slice(a, b) for a, b in pairwise(ends)]))

    def readings(self, shared: Array, local: Array) -> Array:
        """Readings of C plants, m, shape (C, S), for parameters (C, P) and (C, Q, R); NaN after a runaway."""
        return self._every(shared, local, 0)[0]

    def _every(self, shared: Array, local: Array, n_states: int) -> tuple[Array, Array]:
        r, copies = self.records, len(shared)
        values, late = self.layout.plants(shared, local), self._late(local)
        run, offset = self._laid(copies)
        seen = n_states if late is None else max(n_states, 2)
        reading, states = np.empty(copies * r.size), np.empty((seen, copies * r.size))
        self._run(values.reshape(-1, values.shape[-1]), self._starts(local), run, offset, reading, states)
        if late is not None:
            self._shift(late.ravel(), run, offset, reading, states)
            states = states[:n_states]
        return reading.reshape(copies, r.size), states.reshape(n_states, copies, r.size)

    def _laid(self, copies: int) -> tuple[Index, Index]:
        """Run of each replica of so many plants on every run, and where its samples begin: the last call's are kept."""
        if self._tiled is None or self._tiled[0] != copies:
            r = self.records
            run = np.tile(np.arange(len(r.runs)), copies)
            self._tiled = copies, run, (np.arange(copies)[:, None] * r.size + r.first).ravel()
        return self._tiled[1:]

    def _late(self, local: Array) -> Array | None:
        """Start times of driven runs [s], shape (C, R); None where all are zero."""
        late = local[:, self.layout.deviation("start_time")]
        return np.where(self.records.moving, 0.0, late) if late.any() else None

    def _shift(
        self, late: Array, run: Index, offset: Index, reading: Array, states: Array, *, slope: bool = False
    ) -> None:
        from stepid.simulation.shift import shift

        r = self.records
        shift(late, run, offset, r.bounds, r.time, states[0], states[1], slope, reading)

    def _starts(self, local: Array) -> Array:
        """Displacement, velocity and own states at the start of every replica, shape (C·R, states)."""
        rows = np.concatenate([local[:, :2], local[:, self.layout.own_states]], axis=1)
        return np.ascontiguousarray(rows.swapaxes(1, 2).reshape(-1, rows.shape[1]))

    def solve(self, shared: Array, local: Array) -> Solved | None:
        """Simulate all records for one plant.

        Parameters
        ----------
        shared : array, shape (P,)
        local : array, shape (Q, R)

        Returns
        -------
        Solved or None
            None where the plant runs away.
        """
        reading, states = self._every(shared[None], local[None], 2)
        return Solved(states[:, 0], reading[0]) if np.isfinite(reading).all() else None

    def start(self, shared: Array, local: Array) -> Array:
        """State in which each record begins, shape (states, R)."""
        out: Array = self._every(shared[None], local[None], self.layout.n_states)[1][:, 0, self.records.first]
        return out

    def derivatives(
        self, shared: Array, local: Array, reading: Array, wanted: Mask, active: Mask, states: Array | None = None
    ) -> tuple[Array, Array]:
        """Derivatives of the reading by parameters, shapes (P, S) and (Q, S), zero by those that are not wanted.

        Parameters
        ----------
        shared : array, shape (P,)
        local : array, shape (Q, R)
        reading : array, shape (S,)
            m, of that plant.
        wanted : array of bool, shape (P,)
        active : array of bool, shape (Q, R)
        states : array, shape (2, S), optional
            m and m/s, position and velocity of that plant, where known: start times ask for them.
        """
        from stepid.simulation.slopes import follow, slopes

        r, of = self.records, self.layout
        row, copies, run = self._replicas(wanted, active)
        following = self._homogeneity.following(shared, local, wanted, active, flow=states is not None)
        simulated = ~following.spared[row[copies], run]
        copies, run = copies[simulated], run[simulated]
        steps = self.steps(shared)[row]
        moved = [np.repeat(a[None], row.size, axis=0) for a in (shared, local)]
        here = np.arange(row.size)
        first = int(np.sum(row < of.n_global))
        moved[0][here[:first], row[:first]] += steps[:first]
        moved[1][here[first:], row[first:] - of.n_global] += steps[first:, None]
        out = np.zeros((of.n_global + of.n_run, r.size))
        late, offset = self._late(moved[1]), row[copies] * r.size + r.first[run]
        apart = np.empty((0, 0) if late is None else (2, out.size))
        self._run(
            of.plants(*moved)[copies, run], self._starts(moved[1])[copies * len(r.runs) + run], run,
            offset, out.ravel(), apart,
        )  # fmt: skip
        if late is not None:
            self._shift(late[copies, run], run, offset, out.ravel(), apart)
        with np.errstate(all="ignore"):  # plain Python would warn of a runaway
            slopes(out.ravel(), reading, steps[copies], run, offset, r.bounds)
            velocity = reading if states is None else states[1]
            follow(out, reading, velocity, r.time, r.bounds, following.row, following.weight)
        started = active[of.deviation("start_time")] & ~r.moving
        if started.any():
            if states is None:
                states = self._every(shared[None], local[None], 2)[1][:, 0]
            run = np.flatnonzero(started)
            late = local[of.deviation("start_time"), run]
            self._shift(late, run, r.first[run], out[of.n_global + of.deviation("start_time")], states, slope=True)
        return out[: of.n_global], out[of.n_global :]

    def _replicas(self, wanted: Mask, active: Mask) -> tuple[Index, Index, Index]:
        """Parameters to move, and which run has to be simulated for which of them: the last call's are kept."""
        key = wanted.tobytes() + active.tobytes()
        if self._planned is None or self._planned[0] != key:
            of = self.layout
            touched = [(int(p), of.touched(int(p))) for p in np.flatnonzero(wanted)]
            simulated = np.array(active.any(axis=1))
            simulated[of.deviation("start_time")] = False  # a shift of what is known
            touched += [(of.n_global + int(q), np.flatnonzero(active[q])) for q in np.flatnonzero(simulated)]
            row = np.array([p for p, _ in touched], dtype=np.intp)
            run = np.concatenate([np.zeros(0, dtype=np.intp), *(runs for _, runs in touched)])
            copies = np.repeat(np.arange(row.size), [runs.size for _, runs in touched])
            self._planned = key, (row, copies, run)
        return self._planned[1]
