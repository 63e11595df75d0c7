"""What candidates predict of runs that their fit did not see."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stepid.core.base import Array
from stepid.diagnosis.selection.candidate import Candidate, Deviations, is_free
from stepid.fitting.cross_validation import held_out_residuals
from stepid.fitting.deviations import with_deviations
from stepid.fitting.levenberg_marquardt import Optimum, minimize
from stepid.fitting.noise_floor import repeatability

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

    def residuals(self, found: Candidate) -> tuple[dict[int, Array], dict[int, Array]]:
        """Residuals of runs left out, linear plant with the same conditions free and candidate.

        The whole run judges a candidate that has no freedom in it but its start: most motion follows a step at once.
        """
        first = self._told.criteria.first if is_free(found) or found.deviations else 1.0
        return self.of_two(self._plain(found.deviations), found.optimum, first)

    def of_two(self, one: Optimum, other: Optimum, first: float = 1.0) -> tuple[dict[int, Array], dict[int, Array]]:
        """Residuals of the runs that two fits can both be held against; see `held_out_residuals`."""
        how = {"tolerance": self._told.context.tolerance, "first": first, "part": self._told.criteria.first}
        before = held_out_residuals(one, **how)
        after = held_out_residuals(other, **how) if other is not one else before
        both = sorted(before.keys() & after.keys())
        return {i: before[i] for i in both}, {i: after[i] for i in both}

    def _plain(self, deviations: Deviations) -> Optimum:
        """The linear plant with some conditions that differ from run to run: what they explain, no effect does."""
        known = [c for c in self._told.candidates if not c.effects and c.deviations == deviations]
        if known:
            return known[0].optimum
        linear = self._told.linear.optimum
        problem = with_deviations(linear.problem, deviations)
        return minimize(problem, linear.shared, linear.local, tolerance=self._told.context.tolerance) or linear

    def share(self, found: Candidate) -> tuple[float, float]:
        """Share of the misfit's repeatable power that a candidate takes on runs left out, and its steadiness.

        Zero where no run can be left out.
        """
        before, after = self.residuals(found)
        if not before:
            return 0.0, 0.0
        noise = max(self._told.context.floor, repeatability(self._told.context.records) or 0.0) ** 2

        def taken(runs: list[int]) -> float:
            power = [sum(float(np.sum(seen[i] ** 2)) - noise * seen[i].size for i in runs) for seen in (before, after)]
            return 1.0 - max(power[1], 0.0) / power[0] if power[0] > 0 else 0.0

        single = [taken([i]) for i in before]
        steady = min(single) / max(single) if max(single) > 0 else 0.0
        return taken(list(before)), max(steady, 0.0)
