"""What else a diagnosis noticed: stretches left out, a wrong added mass, clipped records, open parameters."""

from __future__ import annotations

import numpy as np

from stepid.effects.base import Effect
from stepid.engine.least_squares import Optimum, minimize
from stepid.engine.problem import build, fixes_mass, start_local
from stepid.engine.records import own_base
from stepid.engine.search import Ground
from stepid.estimates import estimates
from stepid.experiment import Campaign
from stepid.floor import structure

_CLIPPED = 12  # samples at one extreme reading, in motion before and after


def notes_on(campaign: Campaign, ground: Ground, final: Optimum, effects: tuple[Effect, ...]) -> tuple[str, ...]:
    """Collect remarks in words."""
    records = ground.records
    out = []
    for i, run in enumerate(records.runs):
        if records.begin[i]:
            out.append(
                f"Run {run.name!r}: the first {records.begin[i]} samples, held by hand before the release, "
                "are left out."
            )
        if _is_clipped(run.position):
            out.append(
                f"Run {run.name!r} stays at its extreme reading for {_CLIPPED} samples or more: did it hit a stop?"
            )
    if fixes_mass(records) is not None:
        out.append(
            "No two runs differ in added mass: the total mass is set to 1 kg and every parameter is per unit mass."
        )
    values, _ = estimates(final, effects, ground.floor)
    for name, value in values.items():
        if value.uncertainty is None and not (name == "base_mass" and fixes_mass(records) is not None):
            out.append(f"The data do not determine {name}.")
        elif "." in name and value.uncertainty is not None and value.uncertainty > 0.5 * abs(value.value):
            out.append(f"{name} is undetermined: {value}.")
    if not final.converged:
        out.append("The fit did not converge; what is shown is the best so far.")
    return tuple(out)


def _is_clipped(position: object) -> bool:
    y = np.asarray(position)
    for extreme in (y.max(), y.min()):
        at = np.flatnonzero(y == extreme)
        if at.size >= _CLIPPED and at[0] > 0 and at[-1] < y.size - 1:
            run = np.diff(np.flatnonzero(np.concatenate([[True], np.diff(at) > 1, [True]])))
            long = int(run.max())
            if long >= _CLIPPED and abs(y[-1] - extreme) > 0.2 * np.ptp(y):
                return True
    return False


def wrong_mass(ground: Ground) -> str | None:
    """Find one run whose added mass alone is wrong: with its mass free, the linear plant reaches the floor."""
    records = ground.records
    if fixes_mass(records) is not None or len(records.runs) < 4:
        return None
    best: tuple[float, str] | None = None
    for i, run in enumerate(records.runs):
        if int(np.sum(records.base == records.base[i])) < 3:
            continue
        changed = own_base(records, i)
        problem = build(changed, ())
        n = len(records.bases)
        shared = np.insert(ground.linear.shared, n, ground.linear.shared[records.base[i]])
        found = minimize(problem, shared, start_local(problem, ground.linear), tolerance=ground.tolerance)
        if found is None:
            continue
        white = structure(changed, problem.residual(found.solved), ground.floor, ground.period)
        if white < 6.0 and found.rms < 1.1 * ground.floor and (best is None or found.cost < best[0]):
            off = float(found.shared[n] - found.shared[records.base[i]])
            words = (
                f"One wrong added mass explains everything: with {run.added_mass + off:.4g} kg instead of "
                f"{run.added_mass:g} kg in run {run.name!r} the linear model reaches the noise floor. Weigh it again."
            )
            best = (found.cost, words)
    return best[1] if best else None
