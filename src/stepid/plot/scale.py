"""Scales that read well: how far curves reach, in which unit of length, and plain numbers on a logarithmic axis."""

from __future__ import annotations

from collections.abc import Iterable

from matplotlib.axis import Axis
from matplotlib.ticker import LogLocator, NullFormatter

from stepid.core.base import Array


def reach_of(curves: Iterable[Array]) -> float:
    """Largest distance from zero of any curve, m; 1 µm where there is none, for a scale must end somewhere."""
    return max((float(abs(curve).max()) for curve in curves if curve.size), default=0.0) or 1e-6


def length_unit(reach: float) -> tuple[float, str]:
    """Factor from meters and name of the unit in which lengths up to `reach` read well."""
    return (1e3, "mm") if reach >= 1e-3 else (1e6, "µm")


def plain_logarithm(axis: Axis, *, marks: tuple[float, ...] = (1.0, 2.0, 5.0)) -> None:
    """Mark a logarithmic axis at `marks` times the powers of ten, in plain numbers."""
    axis.set_major_locator(LogLocator(subs=marks))
    axis.set_major_formatter("{x:g}")
    axis.set_minor_formatter(NullFormatter())
