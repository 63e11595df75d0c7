"""A set of effects and of conditions that differ from run to run, fitted to all samples."""

from __future__ import annotations

from dataclasses import dataclass

from stepid.effects.base import Effect
from stepid.fitting.deviations import conditions, without_deviations
from stepid.fitting.levenberg_marquardt import Optimum
from stepid.fitting.multistart import FitContext

LEADING = 2  # effects at most in what is named where a rest remains

Deviations = frozenset[str]
"""Conditions that differ from run to run: names as `stepid.fitting.deviations.with_deviations` takes them."""


@dataclass(frozen=True)
class Candidate:
    """A fit to all samples; `structure` is how far its residual is from white noise, in standard deviations."""

    effects: tuple[Effect, ...]
    deviations: Deviations
    optimum: Optimum
    structure: float

    @property
    def names(self) -> tuple[str, ...]:
        """Canonical names of the effects."""
        return tuple(e.name for e in self.effects)

    @property
    def key(self) -> Key:
        """What tells it from others, whatever the order of its effects."""
        return frozenset(self.names), self.deviations

    @property
    def complexity(self) -> int:
        """Number of effects and of conditions that differ from run to run: offset and velocity of a start are one."""
        return len(self.effects) + conditions(self.deviations)

    def alike(self, context: FitContext) -> Optimum:
        """The fit with conditions alike in all runs, as near as matters beside what it leaves with them."""
        return without_deviations(self.optimum, context.slight(self.optimum)) if self.deviations else self.optimum


def free_effects(found: Candidate) -> tuple[Effect, ...]:
    """Effects of a candidate with a freedom of their own in every run: a phase, or states in which the run begins."""
    problem = found.optimum.problem
    states = zip(found.effects, problem.layout.effect_states, strict=True)
    return tuple(e for e, own in states if e.run_parameters or problem.active[own].any(axis=0).all())


def is_free(found: Candidate) -> bool:
    """Tell whether a candidate has an effect with a freedom of its own in every run."""
    return bool(free_effects(found))


def includes(bigger: tuple[Effect, ...], smaller: tuple[Effect, ...]) -> bool:
    """Tell whether every effect of `smaller` is in `bigger` or contained in one of its effects."""
    return all(any(e.name == b.name or e.name in b.contains for b in bigger) for e in smaller)


Key = tuple[frozenset[str], Deviations]
LINEAR: Key = (frozenset(), frozenset())
"""Key of the linear plant."""
