"""Start values from the weak form of the plant's equation: linear least squares, no derivative of data.

Multiplying m x″ + c x′ + k x + Σ a_j g_j(x, v) = K_f u by a bump φ and integrating by parts moves the derivatives onto
φ, so that ∫φ″x, ∫φ′x, ∫φx, ∫φu and ∫φg are plain sums over the record.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np

from stepid.core.base import Array
from stepid.effects.base import Effect, Moment, Motion, Regressor
from stepid.simulation.records import Records

_LONG = 200  # samples of a kernel that is applied by transforms
_VALLEYS = 10  # of a scan, that are tried
_SLOW = 0.05  # of the largest speed, below which dry friction may hold the cart soon
_RESTING = 0.25  # of a bump, that may be slower


class WeakSolution(NamedTuple):
    """Linear plant and force coefficients from the weak form, and what it leaves (N, relative to the plain plant).

    `displacement` is each run's first position from the spring's rest position, m.
    """

    shared: Array
    coefficients: Array
    left: float
    displacement: Array


@lru_cache(maxsize=32)
def _bump(width: int, sample_time: float) -> tuple[Array, Array, Array]:
    """φ = (1 − s²)⁴ and its first two time derivatives on `width` samples."""
    s = np.linspace(-1, 1, width)
    half = 0.5 * (width - 1) * sample_time
    q = 1 - s**2
    return q**4, -8 * s * q**3 / half, (-8 * q**3 + 48 * s**2 * q**2) / half**2


class WeakForm:
    """The plant's equation, tested by bumps of one width along every record.

    Parameters
    ----------
    records : Records
    width : float
        s, width of the bumps.
    fixed_mass : float or None
        kg, base mass to assume where the campaign does not determine it.
    speed : array, shape (S,), optional
        m/s, of the measured motion: only bumps along which it hardly rests count. What friction holds a cart at rest
        with, no equation of motion tells.
    """

    def __init__(self, records: Records, width: float, *, fixed_mass: float | None, speed: Array | None = None) -> None:
        self._records, self._fixed_mass = records, fixed_mass
        self._labels = len(records.bases), len(records.springs), len(records.dampers)
        self._bumps: list[tuple[int, int, float, Array]] = []
        a, b, c = self._labels
        runs = len(records.runs)
        blocks, sides, owners = [], [], []
        for r in range(runs):
            (h, x), (_, u) = records.evenly(r, records.position), records.evenly(r, records.volts)
            n = min(max(7, round(width / h)), x.size)
            phi, first, second = _bump(n, h)
            stride = max(1, n // 8)
            windows = self._windows(x - x[0], n, stride)
            moves = np.ones(len(windows), dtype=bool)
            if speed is not None:
                along = self._windows(records.evenly(r, np.abs(speed))[1], n, stride)
                moves = np.quantile(along, _RESTING, axis=1) > _SLOW * np.abs(speed).max()
            self._bumps.append((n, stride, h, moves))
            if records.runs[r].input_between == "held":  # its integral over a step goes with the step's middle
                u = 0.5 * (u + np.concatenate([[records.before[r]], u[:-1]]))
            block = np.zeros((windows.shape[0], a + b + c + 1 + runs))
            inertia = windows @ second * h
            block[:, records.base[r]] = inertia
            block[:, a + records.spring[r]] = windows @ phi * h
            block[:, a + b + records.damper[r]] = -(windows @ first) * h
            block[:, a + b + c] = -(self._windows(u, n, stride) @ phi) * h
            block[:, a + b + c + 1 + r] = phi.sum() * h
            blocks.append(block[moves])
            owners.append(np.full(len(blocks[-1]), r))
            sides.append(-records.added_mass[r] * inertia[moves])
        self._matrix, self._rhs, self._run = np.concatenate(blocks), np.concatenate(sides), np.concatenate(owners)
        if fixed_mass is not None:
            self._rhs = self._rhs - fixed_mass * self._matrix[:, :a].sum(axis=1)
            self._matrix = self._matrix[:, a:]

    @staticmethod
    def _windows(values: Array, n: int, stride: int) -> Array:
        return np.lib.stride_tricks.sliding_window_view(values, n, axis=-1)[..., ::stride, :]

    def test(self, forces: Sequence[Array]) -> Array:
        """∫φ g for samples of each of some g, one at least, shape (S,) each to (rows, k)."""
        parts = []
        for r, (n, stride, h, moves) in enumerate(self._bumps):
            even = np.array([self._records.evenly(r, force)[1] for force in forces])
            parts.append(np.einsum("kwn,n->wk", self._windows(even, n, stride), _bump(n, h)[0] * h)[moves])
        return np.concatenate(parts)

    def force_behind(self, change: Array, shared: Array) -> Array:
        """∫φ g for the force g that changes the motion of a linear plant by `change` [m], shape (S,) to (rows,)."""
        a, b, _ = self._labels
        r, parts = self._records, []
        for i, (n, stride, h, moves) in enumerate(self._bumps):
            phi, first, second = _bump(n, h)
            mass = shared[:a][r.base[i]] + r.added_mass[i]
            kernel = mass * second - shared[a + b + r.damper[i]] * first + shared[a + r.spring[i]] * phi
            parts.append((self._windows(r.evenly(i, change)[1], n, stride) @ kernel * h)[moves])
        return np.concatenate(parts)

    def solve(self, forces: tuple[Array, ...] = ()) -> WeakSolution | None:
        """Solve for the plant and the coefficients of added forces.

        Parameters
        ----------
        forces : tuple of arrays, shape (S,)
            Samples of g_j; the plant feels +a_j g_j.

        Returns
        -------
        WeakSolution or None
            None where the result is no stable plant.
        """
        matrix, rhs = self._matrix, self._rhs
        if forces:
            matrix = np.column_stack([matrix, -self.test(forces)])
        solution, beyond = _least_squares(matrix, rhs)
        left = float(np.sqrt(np.mean(beyond**2)))
        plant = self.plant(solution[: self._matrix.shape[1]])
        if plant is None:
            return None
        shared, displacement = plant
        mass = shared[: self._labels[0]][self._records.base] + self._records.added_mass
        # in units of force per kg-free row, so that solutions with other masses compare
        return WeakSolution(shared, solution[self._matrix.shape[1] :], left / float(np.mean(mass)), displacement)

    def plant(self, solution: Array) -> tuple[Array, Array] | None:
        """Shared parameters and each run's first position from rest [m] of a solution; None for no stable plant."""
        a, b, _ = self._labels
        runs = len(self._records.runs)
        shared, held = solution[: len(solution) - runs], solution[len(solution) - runs :]
        if self._fixed_mass is not None:
            shared = np.concatenate([np.full(a, self._fixed_mass), shared])
        if not self._records.driven.any():
            shared[-1] = 0.0  # no input, no gain
        mass = shared[:a][self._records.base] + self._records.added_mass
        if not (np.isfinite(shared).all() and (shared[a : a + b] > 0).all() and (mass > 0).all()):
            return None
        return shared, held / shared[a : a + b][self._records.spring]

    def plant_beside(self, tested: Array) -> tuple[Array, Array] | None:
        """The plant, as `plant` gives it, that is left with forces that are known, ∫φ g of shape (rows,)."""
        return self.plant(_least_squares(self._matrix, self._rhs + tested)[0])

    @cached_property
    def plain(self) -> tuple[Array, Array]:
        """Basis of the plain plant's columns, and what it leaves."""
        scale = np.linalg.norm(self._matrix, axis=0)
        q = np.linalg.qr(self._matrix[:, scale > 0] / scale[scale > 0])[0]
        return q, self._rhs - q @ (q.T @ self._rhs)

    def beyond(self, tested: Array) -> Array:
        """The part of tested forces, shape (rows,) or (rows, k), that the plain plant's columns cannot follow."""
        q = self.plain[0]
        out: Array = tested - q @ (q.T @ tested)
        return out

    def deepest(self, scan: Sequence[Regressor]) -> list[Regressor]:
        """Of a scan what to try: the deepest valleys of what is left, each a basin, in the scan's order."""
        found = self.valleys([regressor.forces for regressor in scan])[:_VALLEYS]
        return [scan[i] for i in sorted(found)]

    def valleys(self, scan: Sequence[tuple[Array, ...]]) -> list[int]:
        """Places in a scan of forces that leave less than their neighbors do, what leaves least first."""
        if not scan:
            return []
        plain = self.plain[1]
        tested = self.beyond(self.test([force for forces in scan for force in forces]))
        parts = np.split(tested, np.cumsum([len(forces) for forces in scan])[:-1], axis=1)
        left = np.array([np.linalg.norm(plain - a @ np.linalg.lstsq(a, plain, rcond=1e-9)[0]) for a in parts])
        before, after = np.append(np.inf, left[:-1]), np.append(left[1:], np.inf)
        return sorted(map(int, np.flatnonzero((left <= before) & (left < after))), key=lambda i: float(left[i]))

    def left_by_run(self, forces: list[Array]) -> float:
        """Share of what the plain plant leaves that is left with forces of other strength in every run."""
        left = self.plain[1]
        own = self._run == np.arange(len(self._records.runs))[:, None]
        added = np.column_stack([np.where(mine, tested, 0.0) for tested in self.test(forces).T for mine in own])
        added = self.beyond(added)
        after = left - added @ np.linalg.lstsq(added, left, rcond=1e-9)[0]
        return float((after @ after) / (left @ left))


def _least_squares(matrix: Array, rhs: Array) -> tuple[Array, Array]:
    """Solution by columns scaled to one, and what it leaves."""
    scale = np.linalg.norm(matrix, axis=0)
    scale[scale == 0] = 1.0
    scaled = matrix / scale
    solution = np.linalg.lstsq(scaled, rhs, rcond=1e-9)[0]
    return solution / scale, rhs - scaled @ solution


def measured_motion(records: Records, linear: Array, floor: float, period: float) -> Motion:
    """Position from rest and velocity as measured, smoothed just enough for the noise.

    Parameters
    ----------
    records : Records
    linear : array, shape (P,)
        A linear plant, for the masses, stiffnesses and dampings.
    floor : float
        m, noise.
    period : float
        s, of the strongest oscillation.
    """
    x, v = np.empty(records.size), np.empty(records.size)
    held = linear[-1] * records.before / linear[len(records.bases) :][records.spring]  # where an input holds a cart
    for r, piece in enumerate(records.pieces()):
        h, y = records.evenly(r, records.position)
        speed = np.ptp(y) / max(period, 4 * h)
        half = 2
        while half * h < period / 10 and floor / (h * half**1.5) > 0.01 * speed:
            half += 1
        window = min(2 * half + 1, y.size - 1 + y.size % 2)
        degree = min(3, window - 2)
        smooth, slope = _smoothed(y, window, degree)
        rest = np.median(y[-max(8, y.size // 6) :]) if records.moving[r] else smooth[0] - held[r]
        x[piece] = records.at_samples(r, smooth - rest)
        v[piece] = records.at_samples(r, slope / h)
    return motion_along(records, linear, x, v)


@lru_cache(maxsize=32)
def _polynomials(window: int, degree: int) -> tuple[Array, Array]:
    """Powers of the place in a window, shape (window, degree + 1), and the fit of their coefficients to its samples."""
    half = window // 2
    powers: Array = np.vander(np.arange(-half, half + 1) / half, degree + 1, increasing=True)
    fitted: Array = np.linalg.pinv(powers).astype(np.float64)
    return powers, fitted


def _convolved(y: Array, kernel: Array) -> Array:
    """The valid part of a convolution, by transforms where the kernel is long."""
    if kernel.size < _LONG:
        return np.convolve(y, kernel, "valid")
    size = 1 << (y.size - 1).bit_length()  # what wraps around is not in the valid part
    whole = np.fft.irfft(np.fft.rfft(y - y[0], size) * np.fft.rfft(kernel, size), size)
    out: Array = whole[kernel.size - 1 : y.size] + y[0] * kernel.sum()
    return out


def _smoothed(y: Array, window: int, degree: int) -> tuple[Array, Array]:
    """Value and change a sample of the polynomial fitted around each sample (Savitzky and Golay, 1964), shape (n,).

    The first and last half window are read off the polynomials of the first and last whole one.
    """
    half = window // 2
    powers, fitted = _polynomials(window, degree)
    slopes = np.zeros_like(powers)
    slopes[:, 1:] = powers[:, :-1] * np.arange(1, degree + 1) / half
    first, last = fitted @ y[:window], fitted @ y[-window:]
    out = []
    for read in (powers, slopes):
        inner = _convolved(y, (read[half] @ fitted)[::-1])
        out.append(np.concatenate([read[:half] @ first, inner, read[half + 1 :] @ last]))
    return out[0], out[1]


def motion_along(records: Records, linear: Array, x: Array, v: Array) -> Motion:
    """What effects see on a path of positions from rest and velocities, shape (S,) each, of a linear plant."""
    a, b = len(records.bases), len(records.springs)
    run = records.run
    return Motion(
        x,
        v,
        np.where(v < 0, -1.0, 1.0),
        records.time,
        (linear[:a][records.base] + records.added_mass)[run],
        linear[a : a + b][records.spring][run],
        linear[a + b : -1][records.damper][run],
        records.volts,
    )


def force_along(effect: Effect, values: tuple[float, ...], motion: Motion) -> Array:
    """Force of an effect without own states along a motion, dry friction included, N, shape (S,)."""
    out = np.empty(motion.x.size)
    for i, at in enumerate(zip(*(field.tolist() for field in motion), strict=True)):
        m = Moment(*at)
        m = m._replace(sides=tuple(-1.0 if s < 0 else 1.0 for s in effect.switches(values, m)))
        out[i] = effect.force(values, m) - m.sign * effect.friction(values, m)
    return out
