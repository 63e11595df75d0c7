"""Start values of the linear plant from the weak form of its equation: linear least squares, no derivative of data.

Multiplying m x″ + c x′ + k x = K_f u by a bump φ and integrating by parts moves the derivatives onto φ, so that
∫φ″x, ∫φ′x, ∫φx and ∫φu are plain sums over the record.
"""

from __future__ import annotations

import numpy as np

from stepid._base import Array
from stepid.engine.records import Records


def _bump(width: int, sample_time: float) -> tuple[Array, Array, Array]:
    """φ = (1 − s²)⁴ and its first two time derivatives on `width` samples."""
    s = np.linspace(-1, 1, width)
    half = 0.5 * (width - 1) * sample_time
    q = 1 - s**2
    return q**4, -8 * s * q**3 / half, (-8 * q**3 + 48 * s**2 * q**2) / half**2


def weak_start(records: Records, width: float, *, fixed_mass: float | None) -> Array | None:
    """Shared parameters of the linear plant from windows of one width.

    Parameters
    ----------
    records : Records
    width : float
        s, width of the windows.
    fixed_mass : float or None
        kg, base mass to assume where the campaign does not determine it.

    Returns
    -------
    array, shape (P,), or None
        Base masses, stiffnesses, dampings, force gain; None where the windows do not determine them or the result is
        not a stable plant.
    """
    a, b, c = len(records.bases), len(records.springs), len(records.dampers)
    columns = a + b + c + 1 + len(records.runs)
    rows, sides = [], []
    for r, piece in enumerate(records.pieces()):
        h = float(records.sample_time[r])
        n = max(7, round(width / h))
        x, u = records.position[piece], records.volts[piece]
        if x.size < n + 4:
            continue
        phi, first, second = _bump(n, h)
        stride = max(1, n // 8)
        x0 = x - x[0]
        # the input is held: its integral over a step goes with the step's middle
        held = 0.5 * (u + np.concatenate([[records.before[r]], u[:-1]]))
        windows = np.lib.stride_tricks.sliding_window_view(x0, n)[::stride]
        forces = np.lib.stride_tricks.sliding_window_view(held, n)[::stride]
        block = np.zeros((windows.shape[0], columns))
        inertia = windows @ second * h
        block[:, records.base[r]] = inertia
        block[:, a + records.spring[r]] = windows @ phi * h
        block[:, a + b + records.damper[r]] = -(windows @ first) * h
        block[:, a + b + c] = -(forces @ phi) * h
        block[:, a + b + c + 1 + r] = phi.sum() * h
        rows.append(block)
        sides.append(-records.added_mass[r] * inertia)
    if not rows:
        return None
    matrix, rhs = np.concatenate(rows), np.concatenate(sides)
    if fixed_mass is not None:
        rhs = rhs - fixed_mass * matrix[:, :a].sum(axis=1)
        matrix = matrix[:, a:]
    if not np.any(records.volts) and not np.any(records.before):
        matrix[:, -1 - len(records.runs)] = 0.0
    scale = np.linalg.norm(matrix, axis=0)
    scale[scale == 0] = 1.0
    solution = np.linalg.lstsq(matrix / scale, rhs, rcond=1e-9)[0] / scale
    shared = solution[: len(solution) - len(records.runs)]
    if fixed_mass is not None:
        shared = np.concatenate([np.full(a, fixed_mass), shared])
    mass = shared[:a][records.base] + records.added_mass
    if not (np.isfinite(shared).all() and (shared[a : a + b] > 0).all() and (mass > 0).all()):
        return None
    return shared
