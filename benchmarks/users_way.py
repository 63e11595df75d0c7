"""What a user would do instead: one record at a time with SciPy or python-control, then the mass differences; or lmfit.

Each function takes a campaign of single steps and returns base mass, stiffness and damping with what uncertainty the
route gives by itself.
"""

from __future__ import annotations

from typing import Any

import control
import lmfit
import numpy as np
from scipy.optimize import curve_fit

Found = dict[str, tuple[float, float | None]]


def response(t: np.ndarray, rate: float, ratio: float, still: float, rest: float) -> np.ndarray:
    """Step response of an underdamped plant, m."""
    root = np.sqrt(max(1 - ratio**2, 1e-12))
    phase = rate * root * np.maximum(t, 0.0)
    swing = np.exp(-ratio * rate * np.maximum(t, 0.0)) * (np.cos(phase) + ratio / root * np.sin(phase))
    return np.asarray(rest + np.where(t > 0, still * (1 - swing), 0.0))


def _step(e: Any) -> tuple[np.ndarray, np.ndarray]:
    """Time from the step, and position."""
    first = int(np.flatnonzero(e.input)[0])
    return e.time - e.time[first], np.array(e.position)


def _guess(t: np.ndarray, y: np.ndarray) -> tuple[float, float, float, float]:
    rest, end = float(np.mean(y[t <= 0])), float(np.mean(y[-len(y) // 5 :]))
    top = int(np.argmax(np.abs(y - rest)))
    over = max(abs(y[top] - rest) / abs(end - rest) - 1, 1e-3)
    log = np.log(over)
    ratio = float(-log / np.hypot(np.pi, log))
    return float(np.pi / max(t[top], 1e-3) / np.sqrt(1 - ratio**2)), ratio, end - rest, rest


def with_masses(added: np.ndarray, rate: np.ndarray, ratio: np.ndarray, spread: np.ndarray | None = None) -> Found:
    """Base mass, stiffness and damping from ω_n and ζ of each run: 1/ω_n² is a line in the added mass.

    `spread` (n, 2, 2) are their covariances, from which a careful user gets weights and, by the delta method, errors.
    """
    weight = np.ones_like(rate) if spread is None else rate**3 / 2 / np.sqrt(spread[:, 0, 0])

    def solved(rates: np.ndarray, ratios: np.ndarray) -> np.ndarray:
        slope, rise = np.polyfit(added, rates**-2, 1, w=weight)
        stiffness, mass = 1 / slope, rise / slope
        return np.array([mass, stiffness, np.mean(2 * ratios * rates * (mass + added))])

    value = solved(rate, ratio)
    sigma: list[float | None] = [None] * 3
    if spread is not None:
        variance = np.zeros(3)
        for i in range(rate.size):
            columns = []
            for moved, size in ((0, 1e-6 * rate[i]), (1, 1e-6)):
                rates, ratios = rate.copy(), ratio.copy()
                (rates, ratios)[moved][i] += size
                columns.append((solved(rates, ratios) - value) / size)
            slope = np.column_stack(columns)
            variance += np.einsum("ij,jk,ik->i", slope, spread[i], slope)
        sigma = np.sqrt(variance).tolist()
    return {q: (float(v), s) for q, v, s in zip(("base mass", "stiffness", "damping"), value, sigma, strict=True)}


def curve_fits(campaign: Any) -> Found:
    """`scipy.optimize.curve_fit` of the closed form on each record."""
    ends, spreads = [], []
    for e in campaign.experiments:
        t, y = _step(e)
        end, covariance = curve_fit(response, t, y, p0=_guess(t, y))
        ends.append(end[:2])
        spreads.append(covariance[:2, :2])
    added = np.array([e.added_mass for e in campaign.experiments])
    rate, ratio = np.array(ends).T
    return with_masses(added, rate, ratio, np.array(spreads))


def step_infos(campaign: Any) -> Found:
    """Peak time and overshoot by `control.step_info` on each record."""
    ends = []
    for e in campaign.experiments:
        t, y = _step(e)
        at = t >= 0
        y = y[at] - np.mean(y[t <= 0])
        told = control.step_info(y, T=t[at], yfinal=float(np.mean(y[-y.size // 5 :])))
        log = np.log(told["Overshoot"] / 100)
        ratio = -log / np.hypot(np.pi, log)
        ends.append((np.pi / told["PeakTime"] / np.sqrt(1 - ratio**2), ratio))
    rate, ratio = np.array(ends).T
    return with_masses(np.array([e.added_mass for e in campaign.experiments]), rate, ratio)


def realizations(campaign: Any) -> Found:
    """`control.era`, order 2, on the differences of each record, which are its impulse response."""
    ends = []
    for e in campaign.experiments:
        t, y = _step(e)
        h = e.sample_time
        markov = np.diff(y[t >= 0])
        stride = max(1, markov.size // 200)  # a user thins out what would take minutes
        markov = np.add.reduceat(markov, np.arange(0, markov.size - markov.size % stride, stride))
        rows = markov.size // 2
        system, _ = control.era(markov[None, None, :], 2, rows, rows - 1, dt=h * stride)
        pole = np.log(np.linalg.eigvals(system.A).astype(complex)[0]) / (h * stride)
        ends.append((abs(pole), -pole.real / abs(pole)))
    rate, ratio = np.array(ends).T
    return with_masses(np.array([e.added_mass for e in campaign.experiments]), rate, ratio)


def joint_lmfit(campaign: Any) -> Found:
    """lmfit on all records at once, masses, stiffness, damping and gain shared, a rest position each."""
    steps = [_step(e) for e in campaign.experiments]
    first = _guess(*steps[0])
    given = lmfit.Parameters()
    given.add("mass", value=1.3, min=1e-3)
    given.add("stiffness", value=1.3 * first[0] ** 2, min=1e-3)
    given.add("damping", value=2.6 * first[1] * first[0], min=0)
    given.add("still", value=first[2])
    for i, (t, y) in enumerate(steps):
        given.add(f"rest{i}", value=float(np.mean(y[t <= 0])))

    def residual(p: Any) -> np.ndarray:
        out = []
        for i, (e, (t, y)) in enumerate(zip(campaign.experiments, steps, strict=True)):
            mass = p["mass"].value + e.added_mass
            rate = np.sqrt(p["stiffness"].value / mass)
            ratio = p["damping"].value / 2 / mass / rate
            out.append(y - response(t, rate, ratio, p["still"].value, p[f"rest{i}"].value))
        return np.concatenate(out)

    end = lmfit.minimize(residual, given).params
    names = {"base mass": "mass", "stiffness": "stiffness", "damping": "damping"}
    return {q: (float(end[n].value), end[n].stderr) for q, n in names.items()}
