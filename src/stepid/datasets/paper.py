"""The paper's four runs, recovered from its Table 2."""

from __future__ import annotations

import math

from stepid.core.base import Model
from stepid.core.mass_offset import WEIGHT_UNCERTAINTY, MassOffset, chained
from stepid.identification.characteristics_model import Characteristics, CharacteristicsUncertainty

SAMPLE_TIME = 0.0088542  # s, of the ECP plant's usual export
STEP = 0.5  # V, "0.5 volt for all cases"

# case, added mass [kg], peak time [s], damping ratio, overshoot, static gain [cm/V] as printed
_RUNS = (
    ("case 4", 0.0, 0.23903, 0.48781, 0.17281, 3.618),
    ("case 5", 0.5, 0.28301, 0.38532, 0.26934, 3.633),
    ("case 6", 1.5, 0.35403, 0.33598, 0.32607, 3.698),
    ("case 7", 2.0, 0.39003, 0.31812, 0.34849, 3.876),
)


class PaperData(Model):
    """The measured numbers behind Table 2.

    Parameters
    ----------
    characteristics : tuple of Characteristics
        Cases 4 to 7, spring "medium", damper "1/2 turn".
    mass_offsets : tuple of MassOffset
        Eq. 9: 0.5, 1.0 and 0.5 kg.
    """

    characteristics: tuple[Characteristics, ...]
    mass_offsets: tuple[MassOffset, ...]


def burchett() -> PaperData:
    """Return cases 4 to 7 of Burchett's paper, ready for `stepid.assemble`.

    Returns
    -------
    PaperData
        `characteristics` carry u(t_p) = T/√12 with T = 8.8542 ms, because the peak was picked at a sample, and the
        spread that this leaves in the overshoot.

    Notes
    -----
    The paper prints only what it identified. Its masses, stiffness and damping constants satisfy the least-squares
    conditions of the corrected Eq. 10, so the peak times and damping ratios behind them can be recovered: nine
    equations for eight numbers. Static gains are Table 2's, in m/V (the printed ones are in cm/V).
    """
    runs = tuple(_characteristics(*values) for values in _RUNS)
    offsets = chained([(run.name, run.base, run.added_mass or 0.0) for run in runs], WEIGHT_UNCERTAINTY)
    return PaperData(characteristics=runs, mass_offsets=offsets)


def _characteristics(
    name: str, added_mass: float, peak_time: float, ratio: float, overshoot: float, gain: float
) -> Characteristics:
    natural = math.pi / peak_time / math.sqrt(1 - ratio**2)
    # the maximum of a parabola, read at a sample within ±T/2 of it, is low by ½|ÿ|δ², where ÿ = y_ss ω_n² M_p:
    # root mean square T²/(8√5) of ω_n² M_p
    lost = natural**2 * overshoot * SAMPLE_TIME**2 / (8 * math.sqrt(5))
    return Characteristics(
        name=name,
        damped_frequency=math.pi / peak_time,
        damping_ratio=ratio,
        natural_frequency=natural,
        peak_time=peak_time,
        overshoot=overshoot,
        steady_state=gain / 100 * STEP,
        static_gain=gain / 100,
        uncertainty=CharacteristicsUncertainty(peak_time=SAMPLE_TIME / math.sqrt(12), overshoot=lost),
        spring="medium",
        damper="1/2 turn",
        added_mass=added_mass,
        step=STEP,
    )
