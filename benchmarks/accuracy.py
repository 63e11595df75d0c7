"""Noise-free accuracy of the peak method: how far masses, k and c are from the truth of closed-form campaigns.

Run `python benchmarks/accuracy.py [campaigns]`. Damping ratio 0.1 to 0.6 in every run, first peak at least 11 samples
after the step, sample time 8.8542 ms. "envelope" is the swing left `window` periods before the end of each record:
the acceptance asks for 1e-3 or less; shorter records must stay within the uncertainty that they report.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from closed_form import WEIGHTS, draw_plant, make_campaign
from stepid.errors import NotSettledError
from stepid.identification.characteristics import characterize
from stepid.identification.peak import InterpolatedPeak, Peak, SampledPeak
from stepid.identification.solve import solve
from stepid.identification.stacked import assemble

LENGTHS = ((1e-3, 1.5), (1e-2, 1.0), (2e-2, 0.5), (4e-2, 0.25))


def measure(campaigns: int, *, peak: Peak, envelope: float, window: float) -> tuple[np.ndarray, np.ndarray, int]:
    """Relative errors (masses, k, c: worst run each), errors of characteristics over uncertainty, runs refused."""
    errors, scores, refused = [], [], 0
    for number in range(campaigns):
        rng = np.random.default_rng([20260, number])
        plant = draw_plant(rng)
        campaign = make_campaign(plant, rng, envelope=envelope, window=window)
        try:
            runs = [characterize(run, peak=peak) for run in campaign.experiments]
        except NotSettledError:
            refused += 1
            continue
        for run, added in zip(runs, WEIGHTS, strict=True):
            time, overshoot = plant.peak(added)
            u = run.uncertainty
            scores.append(
                [
                    (run.peak_time - time) / u.peak_time,
                    (run.overshoot - overshoot) / u.overshoot,
                    (run.steady_state - 0.018) / u.steady_state,
                ]
            )
        found = solve(assemble(runs, campaign.mass_offsets))
        mass = max(abs(found.masses[run.name] / (plant.base_mass + run.added_mass) - 1) for run in campaign.experiments)
        damping = max(abs(value / plant.damping - 1) for value in found.damping.values())
        errors.append([mass, abs(found.stiffness["medium"] / plant.stiffness - 1), damping])
    return np.array(errors), np.array(scores), refused


if __name__ == "__main__":
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 200
    print(
        f"{count} campaigns each; worst (median) relative error; largest error of t_p, M_p, y_ss over its uncertainty"
    )
    print(f"{'peak':<18}{'envelope':>9}{'window':>7}{'masses':>19}{'k':>19}{'c':>19}{'largest z':>18}{'refused':>9}")
    for peak in (InterpolatedPeak(), SampledPeak()):
        for envelope, window in LENGTHS:
            errors, scores, refused = measure(count, peak=peak, envelope=envelope, window=window)
            cells = "".join(f"{w:10.1e} ({m:.0e})" for w, m in zip(errors.max(0), np.median(errors, 0), strict=True))
            z = " ".join(f"{value:.1f}" for value in np.abs(scores).max(0))
            print(f"{type(peak).__name__:<18}{envelope:9.0e}{window:7.2f}{cells}{z:>18}{refused:9d}")
