"""A value with its standard uncertainty and unit, rounded by the uncertainty when printed."""

from __future__ import annotations

import math
from collections.abc import Mapping

from pydantic import model_validator

from stepid.core.base import Finite, Model, NonNegative


def format_value(value: float, uncertainty: float | None) -> str:
    """Write ``value ± uncertainty``, rounded so that the uncertainty keeps two significant digits.

    Parameters
    ----------
    value, uncertainty : float
        In the same unit. Without an uncertainty (None or 0) the value is given to five digits.

    Returns
    -------
    str
        For example ``"216.2 ± 1.4"``.
    """
    if uncertainty is None or not uncertainty > 0 or not math.isfinite(uncertainty):
        return f"{value:.5g}"
    digits = 1 - math.floor(math.log10(uncertainty))
    if round(uncertainty, digits) >= 10 ** (2 - digits):  # 0.0996 rounds up to three digits
        digits -= 1
    if -1 <= digits <= 9:
        places = max(digits, 0)
        return f"{value:.{places}f} ± {uncertainty:.{places}f}"
    scale = math.floor(math.log10(max(abs(value), uncertainty)))
    places = max(digits + scale, 0)
    return f"({value / 10**scale:.{places}f} ± {uncertainty / 10**scale:.{places}f})e{scale}"


def outward(words: str, value: float) -> str:
    """Write the end of an interval that is ``"at least"`` or ``"at most"`` so much, to two digits that hold no less."""
    if value == 0:
        return "0"
    scale = 10.0 ** (1 - math.floor(math.log10(abs(value))))
    rounded = math.ceil if words == "at most" else math.floor
    return f"{rounded(round(value * scale, 9)) / scale:.5g}"  # 0.29 times 100 is not quite 29


def one_end(words: str, value: float) -> str:
    """Write ``"at least"`` or ``"at most"`` and the end of an interval; see `outward`."""
    return f"{words} {outward(words, value)}"


_SHORT = 0.1  # m, s or rad


def prefixed(value: float, uncertainty: float | None, unit: str) -> tuple[float, float | None, str]:
    """Return a short length, time or angle in mm, ms or mrad: ``(0.5, 0.01, "mm")``; others as they are."""
    if unit not in ("m", "s", "rad") or not 0 < max(abs(value), uncertainty or 0.0) < _SHORT:
        return value, uncertainty, unit
    return 1e3 * value, None if uncertainty is None else 1e3 * uncertainty, f"m{unit}"


class Estimate(Model):
    """An estimated quantity.

    Parameters
    ----------
    value : float
        In `unit`.
    uncertainty : float or None
        Standard uncertainty (one standard deviation), same unit; None where the data do not determine the value.
    unit : str
        SI unit, empty for a pure number.
    parts : mapping
        What the uncertainty is made of, same unit: ``"noise"``, ``"weights"`` (the known added masses), ``"runs"``
        (what differs from run to run), ``"scale"`` (counts per meter). Their squares add up to its square. Empty where
        that is not known.
    limits : (float or None, float or None) or None
        Ends of the 95 % interval where it is not 1.96 standard uncertainties to either side, same unit. None is an end
        that the data leave open: the quantity is at least, or at most, the other.
    """

    value: Finite
    uncertainty: NonNegative | None = None
    unit: str = ""
    parts: Mapping[str, NonNegative] = {}
    limits: tuple[Finite | None, Finite | None] | None = None

    @model_validator(mode="after")
    def _has_an_end(self) -> Estimate:
        if self.limits == (None, None):
            raise ValueError("limits need one end at least: give None where both are open")
        return self

    @property
    def interval(self) -> tuple[float, float] | None:
        """The 95 % interval: `limits`, else value ± 1.96 standard uncertainties; None where an end is open."""
        if self.limits is not None:
            low, high = self.limits
            return None if low is None or high is None else (low, high)
        if self.uncertainty is None:
            return None
        return self.value - 1.96 * self.uncertainty, self.value + 1.96 * self.uncertainty

    @property
    def shown(self) -> tuple[str, str]:
        """The value ± its standard uncertainty, and the unit that both are in: mm and ms for what is short."""
        if self.one_sided:
            words, end = self.one_sided
            value, _, unit = prefixed(end, None, self.unit)
            return one_end(words, value), unit
        value, uncertainty, unit = prefixed(self.value, self.uncertainty, self.unit)
        return format_value(value, uncertainty) + " (undetermined)" * (uncertainty is None), unit

    @property
    def one_sided(self) -> tuple[str, float] | None:
        """``"at least"`` or ``"at most"`` and the end of the 95 % interval where the data leave the other end open."""
        low, high = self.limits or (None, None)
        if low is not None and high is None:
            return "at least", low
        return ("at most", high) if high is not None and low is None else None

    def __str__(self) -> str:
        if self.one_sided:
            return " ".join(self.shown).rstrip()
        value, uncertainty, unit = prefixed(self.value, self.uncertainty, self.unit)
        return f"{format_value(value, uncertainty)} {unit}".rstrip() + " (undetermined)" * (uncertainty is None)
