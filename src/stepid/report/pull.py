"""How far a missing effect pulls each number: the peak method and the linear fit beside the final model."""

from __future__ import annotations

from collections.abc import Mapping
from math import hypot
from statistics import fmean, stdev

from stepid.core.estimate import Estimate, format_value
from stepid.core.quantities import in_own_quantities
from stepid.core.tables import text_table
from stepid.diagnosis.result import Diagnosis
from stepid.diagnosis.wording import effect_names
from stepid.identification.parameters import IdentifiedParameters


@in_own_quantities
def hand_method_table(diagnosis: Diagnosis, identified: IdentifiedParameters) -> str:
    """Write what the stacked system found beside the joint fits, linear and with the missing effect.

    Parameters
    ----------
    diagnosis : Diagnosis
        From `stepid.diagnose`.
    identified : IdentifiedParameters
        From `stepid.identify`, of the same campaign.

    Returns
    -------
    str
        A table: value ± standard uncertainty by three routes, and how far from the last the first two are, in per cent.
        The force gain of the peak method is the mean of K·k of its runs, their scatter its uncertainty.
    """
    header, rows = hand_method_rows(diagnosis, identified)
    parts = []
    if diagnosis.effects:
        parts.append(
            f"How far {effect_names(diagnosis.effects)} pulls each number where the model lacks it, beside the "
            "joint fit that has it:"
        )
    parts.append(text_table(header, rows))
    if identified.excluded:
        parts.append(
            "\n".join(f"left out by the peak method: {name}: {why}" for name, why in identified.excluded.items())
        )
    return "\n\n".join(parts)


def hand_method_rows(
    diagnosis: Diagnosis, identified: IdentifiedParameters
) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Header and rows of that table."""
    several = len(diagnosis.model.base_mass) > 1
    scale = diagnosis.data.scale_uncertainty if diagnosis.data is not None else 0.0
    by_hand = _by_hand(identified, several=several, scale=scale)
    rows = []
    for name, final in diagnosis.parameters.items():
        hand, linear = by_hand.get(name), diagnosis.linear_parameters.get(name)
        if hand is None and (linear is None or not diagnosis.effects):
            continue
        cells = [_cell(hand), _cell(linear)]
        off = [_percent(_off(hand, final))]
        if diagnosis.effects:
            cells.append(_cell(final))
            off.append(_percent(_off(linear, final)))
        rows.append((name, *cells, final.unit, *off))
    added = ("with the effect", "unit", "by peaks", "linear fit") if diagnosis.effects else ("unit", "by peaks")
    return ("parameter", "by peaks (Eq. 10)", "joint fit, linear", *added), rows


def _by_hand(found: IdentifiedParameters, *, several: bool, scale: float = 0.0) -> dict[str, Estimate]:
    """The peak method's numbers under the joint fit's names; `scale` is the positions' relative uncertainty."""
    u = found.uncertainty
    out: dict[str, Estimate] = {}

    def take(what: str, values: Mapping[str, float], spread: Mapping[str, float], unit: str) -> None:
        for label, value in values.items():
            name = what if what == "base_mass" and not several else f"{what}[{label}]"
            out[name] = Estimate(value=value, uncertainty=spread.get(label), unit=unit)

    take("base_mass", found.base_mass, u.base_mass, "kg")
    take("stiffness", found.stiffness, u.stiffness, "N/m")
    take("damping", found.pooled_damping, u.pooled_damping, "N·s/m")
    known = {name: gain for name, gain in found.static_gain.items() if name in found.masses}
    if known:
        out["force_gain"] = _gain(found, known, scale)
    return out


def _gain(found: IdentifiedParameters, static: Mapping[str, float], scale: float) -> Estimate:
    """Force gain of static gains [m/V] by run: uncertain by their scatter and, as all are, by stiffness and scale."""
    gains = [gain * found.run_stiffness(name) for name, gain in static.items()]
    spread = found.uncertainty.stiffness
    common = fmean(abs(gain) * spread.get(found.springs[name], 0.0) for name, gain in static.items())
    shared = scale * fmean(map(abs, gains))
    scatter = hypot(stdev(gains), common, shared) if len(gains) > 1 else None
    return Estimate(value=fmean(gains), uncertainty=scatter, unit="N/V")


def _cell(estimate: Estimate | None) -> str:
    if estimate is None:
        return "–"
    return format_value(estimate.value, estimate.uncertainty)


def _percent(off: float | None) -> str:
    if off is None:
        return "–"
    return f"{off:+.1f} %".replace("-", "−") if round(off, 1) else "0.0 %"


def _off(estimate: Estimate | None, final: Estimate) -> float | None:
    """How far an estimate lies from the final one, in per cent of it; None where either is nothing."""
    if estimate is None or final.value == 0:
        return None
    return 100 * (estimate.value / final.value - 1)


def linear_pull(diagnosis: Diagnosis) -> list[tuple[str, float, float]]:
    """Parameter, how far the linear fit is off the final model, and half of its 95 % interval; both in per cent."""
    rows = []
    for name, final in diagnosis.parameters.items():
        linear = diagnosis.linear_parameters.get(name)
        off = _off(linear, final)
        if linear is not None and off is not None:
            rows.append((name, off, 196 * (linear.uncertainty or 0.0) / abs(final.value)))
    return rows
