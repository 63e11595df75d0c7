"""One run that disagrees with all others; what would explain it is in `stepid.fitting.record_faults`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from stepid.core.base import Array
from stepid.fitting.levenberg_marquardt import Optimum, minimize
from stepid.fitting.multistart import FitContext
from stepid.fitting.problem import build, fit_linear, fixes_mass
from stepid.fitting.record_faults import SLACK, WHITE, Mistake, at_floor, known, mistakes
from stepid.simulation.records import Records

_PROMISE = 0.6  # share of the misfit that may be left, to first order, without the run
_ROUGH = 3e-3  # share of the misfit to which the fits without a run are told, where
_AGREE = 0.7  # of it is left, or more: the others do not agree
_LIKELY = 4.0  # times the noise that it may be where an effect explains it as well
_TRIED = 2  # runs left out in turn where effects make the fit slow
_STANDS_OUT = 0.3  # the same where it alone is to tell
_LOUD = 1.5  # times the others' misfit that the run's may then be, its mistake mended
_DECIDES = 10.0  # χ²

Rest = dict[int, Optimum | None]  # fits to the other runs, by the run left out


@dataclass(frozen=True)
class Suspect:
    """A run that disagrees with the others.

    `rivals` are runs that may as well be the wrong one; `evidence` is χ² of all runs, the suspect's mistake mended,
    plus the price of its parameter.
    """

    run: str
    rivals: tuple[str, ...]
    mistake: Mistake | None
    evidence: float

    @property
    def sure(self) -> bool:
        """Whether one mistake in the manifest, in one run, explains it."""
        return self.mistake is not None and self.mistake.plain and not self.rivals

    @property
    def settles(self) -> bool:
        """Whether it is needless to look for effects beside it: nothing in the whole plant looks like this."""
        return self.mistake is not None and self.mistake.single and not self.rivals

    @property
    def words(self) -> str:
        """Say which run disagrees, and what would explain it."""
        if self.rivals:
            names = " or ".join(repr(n) for n in (self.run, *self.rivals))
            return f"One run disagrees with the others, {names}; without it the others agree. Record them again."
        said = f"Run {self.run!r} disagrees with the others, which agree among themselves."
        return f"{said} {self.mistake.words}" if self.mistake else f"{said} Look at that record, or repeat the run."


def find_suspect(context: FitContext, fits: Sequence[Optimum]) -> Suspect | None:
    """Find the run without which one of the fits reaches the noise floor.

    Parameters
    ----------
    context : FitContext
    fits : sequence of Optimum
        To all records; tried in turn.

    Returns
    -------
    Suspect or None
        None where no single run is to blame.
    """
    if len(context.records.runs) < 3 or at_floor(context, fits[0], SLACK, WHITE):
        return None
    if any(at_floor(context, fit, SLACK, WHITE) for fit in fits[1:]):
        return _suspect(context, fits[0], {}, promise=_LIKELY)  # an effect explains it; a mistake must do so as well
    rest: Rest = {}
    found = _suspect(context, fits[0], rest)
    found = found or _gross(context, rest if fits[0] is context.linear else {})
    for fit in fits[1:]:
        found = found or _suspect(context, fit, {})
    return found


def _suspect(context: FitContext, fit: Optimum, rest: Rest, *, promise: float = np.inf) -> Suspect | None:
    """Find the run without which this fit reaches the noise floor; the fits without each run are left in `rest`."""
    records = context.records
    linear = not fit.problem.simulator.effects
    noise = np.add.reduceat(records.weight**2, records.first) * context.floor**2
    left = _left_without(fit)
    order = [int(i) for i in np.argsort(left) if left[i] < promise * (noise.sum() - noise[i])]
    if not linear:  # slower to fit: only those runs whose loss would change much
        order = [i for i in order if left[i] < _PROMISE * fit.cost][:_TRIED]
    found = []
    for i in order:
        others = rest[i] = _without(fit, i, context.tolerance)
        if others is not None and at_floor(context, others, SLACK, WHITE):
            best = min(mistakes(context, fit, others, i), key=lambda m: m.cost, default=None)
            cost = (others.cost + (best.cost if best else float(noise[i]))) / context.floor**2
            found.append((best is None, cost, i, best))
    if not found:
        return None
    found.sort(key=lambda item: item[:2])
    unknown, cost, i, best = found[0]
    names = [run.name for run in records.runs]
    rivals = tuple(names[j] for other, also, j, _ in found[1:] if other == unknown and also < cost + _DECIDES)
    samples = noise / context.floor**2
    price = float(fit.problem.free.sum() + 1) * np.log(samples.sum()) + float(
        np.sum(fit.problem.active * np.log(samples))
    )
    return Suspect(names[i], rivals, best, cost + price)


def _gross(context: FitContext, rest: Rest) -> Suspect | None:
    """A run with a plain mistake, seen by the linear plant although more is missing; `rest`: linear fits, if known."""
    records, fit = context.records, context.linear
    fits = rest or {i: _without(fit, i, context.tolerance) for i in range(len(records.runs))}
    counts = np.add.reduceat(records.weight**2, records.first)
    power = {i: f.cost / (counts.sum() - counts[i]) for i, f in fits.items() if f is not None}
    if len(power) < 2:
        return None
    i, second = sorted(power, key=lambda k: power[k])[:2]
    others = fits[i]
    if others is None or power[i] > _STANDS_OUT * min(power[second], fit.cost / counts.sum()):
        return None
    level = max(_LOUD * float(np.sqrt(power[i])) / context.floor, SLACK)
    plain = [m for m in mistakes(context, fit, others, i, slack=level, white=np.inf) if m.plain]
    found = min(plain, key=lambda m: m.cost, default=None)
    return None if found is None else Suspect(records.runs[i].name, (), found, np.inf)


def _left_without(fit: Optimum) -> Array:
    """Cost [m²] that the other runs would leave without each run, to first order, shape (R,)."""
    problem = fit.problem
    records = problem.records
    residual, jacobian = problem.residual(fit.solved), problem.jacobian(fit.solved)
    out = np.full(len(records.runs), np.inf)
    if not np.isfinite(jacobian).all():
        return out
    size = np.linalg.norm(jacobian, axis=0)
    jacobian = jacobian / np.where(size > 0, size, 1.0)
    for i in range(out.size):
        rest = records.run != i
        step = np.linalg.lstsq(jacobian[rest], residual[rest], rcond=1e-9)[0]
        out[i] = float(np.sum((residual[rest] - jacobian[rest] @ step) ** 2))
    return out


def _without(fit: Optimum, run: int, tolerance: float) -> Optimum | None:
    """Fit the other runs; None where they leave the mass or the force open."""
    records = fit.problem.records
    keep = [j for j in range(len(records.runs)) if j != run]
    rest = records.subset(keep)
    if (fixes_mass(rest) is None) != (fixes_mass(records) is None) or not _still_driven(rest, records):
        return None
    problem = build(rest, fit.problem.simulator.effects)
    problem = replace(problem, active=fit.problem.active[:, keep], free=problem.free & known(problem))
    rough = max(tolerance, _ROUGH * fit.cost)
    found = [minimize(problem, fit.shared, fit.local[:, keep], tolerance=rough)]
    if not problem.simulator.effects and known(problem).all():  # the bad run may have led it far astray
        found.append(fit_linear(rest, tolerance=rough))
    best = min((f for f in found if f is not None), key=lambda f: f.cost, default=None)
    if best is None or best.cost > _AGREE * fit.cost:
        return best
    return minimize(best.problem, best.shared, best.local, tolerance=tolerance)


def _still_driven(rest: Records, records: Records) -> bool:
    return bool(np.any(rest.volts)) or not np.any(records.volts)
