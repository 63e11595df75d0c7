"""What may be fitted next: a set of effects with its starts and what they promise."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Protocol

from stepid.core.base import Array
from stepid.diagnosis.selection.candidate import Deviations, Key
from stepid.diagnosis.selection.effort import Effort
from stepid.effects.base import Effect
from stepid.fitting.candidate_fit import CandidateFit
from stepid.fitting.levenberg_marquardt import Optimum
from stepid.fitting.multistart import FitContext, Start

_MODE = 2  # own states


@dataclass(frozen=True)
class SearchContext:
    """What every move may use."""

    fit: FitContext
    catalogue: tuple[Effect, ...]
    effort: Effort


@dataclass
class Node:
    """A set of effects in the search, with its fit so far; `moves_made` are the names of those made from it."""

    fitted: CandidateFit
    moves_made: set[str] = field(default_factory=set)

    @property
    def effects(self) -> tuple[Effect, ...]:
        """Effects of the node."""
        return self.fitted.effects

    @property
    def deviations(self) -> Deviations:
        """Conditions that differ from run to run."""
        return self.fitted.deviations

    @cached_property
    def key(self) -> Key:
        """See `Candidate.key`."""
        return frozenset(e.name for e in self.effects), self.deviations

    @property
    def size(self) -> int:
        """Number of effects, and one where conditions differ from run to run."""
        return len(self.effects) + bool(self.deviations)

    @property
    def cost(self) -> float:
        """Sum of squared residuals on the decimated records, m²."""
        return self.fitted.cost

    @property
    def best(self) -> Optimum:
        """The fit so far."""
        assert self.fitted.best is not None
        return self.fitted.best


class Postponed:
    """Starts that are found once something is fitted from them: most proposals never are.

    Parameters
    ----------
    find : callable
        Finds them.
    """

    def __init__(self, find: Callable[[], Sequence[Start]]) -> None:
        self._find = find

    @cached_property
    def _found(self) -> Sequence[Start]:
        return self._find()

    def __iter__(self) -> Iterator[Start]:
        return iter(self._found)


@dataclass(frozen=True)
class Proposal:
    """A set of effects to fit: where from, and what is promised.

    Parameters
    ----------
    effects : tuple of Effect
    deviations : frozenset of str
    starts : iterable of Start
        Most promising first.
    base : tuple
        Key of the node that it is proposed on.
    like : Optimum
        That node's fit: local parameters begin there.
    left : float
        m², cost that it promises to leave.
    costly : float
        By which what it promises to gain is divided, in the order of proposals.
    move : str
        Name of the move that proposed it.
    """

    effects: tuple[Effect, ...]
    deviations: Deviations
    starts: Iterable[Start]
    base: Key
    like: Optimum
    left: float
    costly: float = 1.0
    move: str = ""

    @property
    def size(self) -> int:
        """Number of effects, and one where conditions differ from run to run."""
        return len(self.effects) + bool(self.deviations)

    @property
    def gain(self) -> float:
        """Decrease of the cost that it promises, m², less where it is costly."""
        return (self.like.cost - self.left) / self.costly

    @property
    def rank(self) -> float:
        """What it promises to leave, m², more where it is costly: the least goes first."""
        return self.like.cost - self.gain

    @cached_property
    def key(self) -> Key:
        """See `Candidate.key`."""
        return frozenset(e.name for e in self.effects), self.deviations


class Move(Protocol):
    """A way from one set of effects to others."""

    @property
    def name(self) -> str:
        """Name."""
        ...

    def propose(self, node: Node, context: SearchContext) -> list[Proposal]:
        """Propose sets of effects to fit next, from where a node stands; nothing is fitted here.

        Each set once and other than the node's, of `context.effort.effects` at most.
        """
        ...


def standing(node: Node, shared: Array | None = None) -> Start:
    """Where a node stands (or where `shared` says), as a start."""
    of = node.best.problem.layout
    shared = node.best.shared if shared is None else shared
    return Start(shared[of.linear], tuple(tuple(float(v) for v in shared[place]) for place in of.values))


def is_mode(effect: Effect) -> bool:
    """Tell whether an effect is a mode of its own, whose response is in no proportion to its mass."""
    return effect.n_extra >= _MODE


def n_parameters(effects: tuple[Effect, ...]) -> int:
    """Count parameters of effects, those of a run once."""
    return sum(len(e.parameters) + len(e.run_parameters) for e in effects)


def related(one: Effect, other: Effect) -> bool:
    """Tell whether two effects are the same, or one contains the other."""
    return one.name == other.name or one.name in other.contains or other.name in one.contains


def overshadowed(scored: Sequence[tuple[tuple[Effect, ...], float]]) -> set[frozenset[str]]:
    """Sets with a general law that leave no less than half of what the same with a simpler one in its place leaves.

    Parameters
    ----------
    scored : sequence of tuple
        Sets of as many effects, each with the cost that it promises to leave, m².
    """
    left: dict[frozenset[str], float] = {}
    simpler: dict[frozenset[str], list[frozenset[str]]] = {}
    for effects, cost in scored:
        names = frozenset(e.name for e in effects)
        left[names] = min(cost, left.get(names, math.inf))
        simpler[names] = [(names - {e.name}) | {inner} for e in effects for inner in e.contains]
    return {names for names, others in simpler.items() if any(2 * left[names] >= left.get(o, math.inf) for o in others)}
