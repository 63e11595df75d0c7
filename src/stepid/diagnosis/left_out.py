"""What candidates predict of runs that their fit did not see."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from stepid.core.base import Array
from stepid.diagnosis.evidence import part_left
from stepid.diagnosis.selection.candidate import Candidate, Deviations, free_effects, is_free
from stepid.effects.base import Effect
from stepid.fitting.cross_validation import held_out_residuals, judging
from stepid.fitting.deviations import starts_kept, with_deviations
from stepid.fitting.levenberg_marquardt import Optimum, minimize
from stepid.fitting.noise_floor import repeatability
from stepid.fitting.problem import build, start_local

if TYPE_CHECKING:
    from stepid.diagnosis.gather import EvidenceRecord


class LeftOut:
    """Predictions of runs left out in turn; see docs/evidence.md.

    Parameters
    ----------
    evidence : EvidenceRecord
    """

    def __init__(self, evidence: EvidenceRecord) -> None:
        self._told = evidence
        self._seen: dict[Optimum, tuple[dict[int, Array], dict[int, Array]]] = {}  # `residuals`, by a candidate's fit
        self._plains: dict[Deviations, Optimum] = {}  # linear plants, by what differs

    def residuals(self, found: Candidate) -> tuple[dict[int, Array], dict[int, Array]]:
        """Residuals of runs left out, linear plant with the same conditions free and candidate.

        Starts that are free with an effect are among them: what that freedom does is no sign of the effect. The whole
        run judges a candidate that has no freedom in it but its start: most motion follows a step at once. Conditions
        that lead the linear plant astray are no sign of the effect either: with runs alike it may predict more.
        """
        if found.optimum not in self._seen:
            first = self._told.criteria.first if is_free(found) or found.deviations else 1.0
            plain, alike = self._plain(found), self._told.linear.optimum
            plains = (plain,) if alike is plain else (plain, alike)
            both = [self.of_two(one, found.optimum, first) for one in plains]
            self._seen[found.optimum] = min(both, key=lambda pair: _power(pair[0], pair[0], 0.0))
        return self._seen[found.optimum]

    def of_two(self, one: Optimum, other: Optimum, first: float = 1.0) -> tuple[dict[int, Array], dict[int, Array]]:
        """Residuals of the runs that two fits can both be held against; see `held_out_residuals`."""
        part = self._told.criteria.first
        able = sorted({*judging(one, first, part)} & {*judging(other, first, part)})

        def held_out(optimum: Optimum) -> dict[int, Array]:
            tolerance = self._told.context.tolerance
            return held_out_residuals(optimum, tolerance=tolerance, first=first, part=part, among=able)

        before = held_out(one)
        after = held_out(other) if other is not one else before
        both = sorted(before.keys() & after.keys())
        return {i: before[i] for i in both}, {i: after[i] for i in both}

    def part_of_effects(self, found: Candidate) -> float:
        """Part of the misfit's power that conditions which differ leave to a candidate's effects, between 0 and 1.

        So do starts that they free, where runs differ; else all of it is theirs.
        """
        if not found.deviations:
            return 1.0
        told = self._told
        return min(part_left(told.linear.optimum.rms**2, self._plain(found).rms ** 2, told.context.floor**2), 1.0)

    def _plain(self, found: Candidate) -> Optimum:
        """The linear plant as a candidate's runs differ, or with runs alike where that cannot be fitted."""
        conditions = found.deviations | starts_kept(found.optimum.problem, ())
        if conditions not in self._plains:
            self._plains[conditions] = self._with((), found) or self._told.linear.optimum
        return self._plains[conditions]

    def _with(self, effects: tuple[Effect, ...], found: Candidate) -> Optimum | None:
        """Some of a candidate's effects, or none, with the conditions and starts free that are so under the candidate.

        What these explain, the effects that are left out of it do not. None where that cannot be fitted.
        """
        conditions = found.deviations | starts_kept(found.optimum.problem, effects)
        key = frozenset(e.name for e in effects), conditions
        known = [c.optimum for c in self._told.candidates if c.key == key]
        if known:
            return known[0]
        linear, whole = self._told.linear.optimum, found.optimum
        if not effects:
            problem, shared, like = linear.problem, linear.shared, linear
        else:
            of, problem, like = whole.problem.layout, build(linear.problem.records, effects), whole
            values = [whole.shared[v] for e, v in zip(of.effects, of.values, strict=True) if e in effects]
            shared = np.concatenate([whole.shared[of.linear], *values])
            begun = problem.active.copy()
            begun[:2] &= whole.problem.active[:2]  # runs that are at rest with the candidate are so
            problem = replace(problem, active=begun)
        problem = with_deviations(problem, conditions)
        tolerance = self._told.context.tolerance
        return minimize(problem, shared, start_local(problem, like), tolerance=tolerance)

    def share(self, found: Candidate) -> tuple[float, float]:
        """Share of the misfit's repeatable power that a candidate takes on runs left out, and its steadiness.

        Zero where no run can be left out. Runs that show no misfit, such as releases of what acts on the drive, say
        nothing of how steady it is.
        """
        before, after = self.residuals(found)
        if not before:
            return 0.0, 0.0
        noise = self._noise(found)
        shown = [i for i in before if _shows(before[i], noise)] or list(before)
        single = [_taken({i: before[i]}, after, noise) for i in shown]
        steady = min(single) / max(single) if max(single) > 0 else 0.0
        return _taken(before, after, noise), max(steady, 0.0)

    def share_of_free(self, found: Candidate) -> float:
        """Share of what a candidate's other effects leave that those with a freedom in every run take."""
        free = free_effects(found)
        others = tuple(e for e in found.effects if e not in free)
        if not others:
            return self.share(found)[0]
        beside = self._with(others, found)
        if beside is None:
            return 0.0
        return _taken(*self.of_two(beside, found.optimum, self._told.criteria.first), self._noise(found))

    def judges(self, found: Candidate) -> bool:
        """Tell whether some run left out has power that a candidate could take: else its share says nothing."""
        before, _ = self.residuals(found)
        return _power(before, before, self._noise(found)) > 0

    def shows(self, found: Candidate) -> bool:
        """Tell whether the linear plant, as free as a candidate, leaves more than chance on the runs left out."""
        before, _ = self.residuals(found)
        return bool(before) and _shows(np.concatenate(list(before.values())), self._noise(found))

    def _noise(self, found: Candidate) -> float:
        """Square that each sample holds of noise and of what repeats differ by beyond a candidate's conditions, m²."""
        differ = repeatability(self._told.context.records, self._plain(found).residual)
        return max(self._told.context.floor, differ or 0.0) ** 2


_Residuals = Mapping[int, Array]


def _taken(before: _Residuals, after: _Residuals, noise: float) -> float:
    """Share of a residual's repeatable power that is gone, in the runs of the first; 0 where there was none."""
    return 1.0 - part_left(_power(before, before, noise), _power(after, before, noise))


def _power(seen: _Residuals, runs: Iterable[int], noise: float) -> float:
    """Power of residuals in some runs beyond a square [m²] that each sample holds, m²."""
    return sum(float(np.sum(seen[i] ** 2)) - noise * seen[i].size for i in runs)


def _shows(residual: Array, noise: float) -> bool:
    """Tell whether runs left out show more than chance does: their power, by two standard deviations of noise's."""
    return bool(residual @ residual > noise * (residual.size + 2 * np.sqrt(2 * residual.size)))
