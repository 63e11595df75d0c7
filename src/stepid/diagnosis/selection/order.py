"""Which proposals are worth a fit, the most promising first."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Collection, Mapping, Sequence

from stepid.diagnosis.criteria import Criteria
from stepid.diagnosis.selection.candidate import Candidate, Key, includes
from stepid.diagnosis.selection.effort import Effort
from stepid.diagnosis.selection.proposal import Node, Proposal
from stepid.diagnosis.vetoes import imitators
from stepid.fitting.multistart import FitContext


def worthy(
    order: Sequence[Proposal], nodes: Mapping[Key, Node], effort: Effort, rivals: Collection[str]
) -> list[Proposal]:
    """Of each node's proposals those that promise a share of what its best promises; most on the best nodes.

    Parameters
    ----------
    order : sequence of Proposal
        Most promising first.
    nodes : mapping
        Key to node.
    effort : Effort
    rivals : collection of str
        Moves whose proposals are always worth it.
    """
    plain: dict[int, Node] = {}
    for node in sorted(nodes.values(), key=lambda n: n.cost):
        if not node.deviations and not any(e.contains for e in node.effects):
            plain.setdefault(node.size, node)
    leading = {node.key for node in plain.values()}
    most: dict[Key, float] = {}
    for p in order:
        most[p.base] = max(most.get(p.base, 0.0), p.gain)
    taken: Counter[Key] = Counter()
    first, then = [], []
    for p in order:
        if p.move in rivals:
            first.append(p)
            continue
        taken[p.base] += 1
        if taken[p.base] <= effort.share:
            first.append(p)
        elif p.base in leading and (taken[p.base] <= effort.first or p.gain > effort.worth * most[p.base]):
            then.append(p)
    return first + then


def nameable(fit: FitContext, criteria: Criteria, nodes: Sequence[Node]) -> list[Node]:
    """Of some nodes those without an effect that a linear parameter can stand in for."""
    return [n for n in nodes if not imitators(fit, criteria, Candidate(n.effects, n.deviations, n.best, 0.0))]


def hoped(proposal: Proposal, effort: Effort) -> float:
    """Cost that may really be left where one linearized step promises to leave some share, m²."""
    share = max(proposal.left, 0.0) / proposal.like.cost if proposal.like.cost > 0 else 1.0
    return float(proposal.like.cost * min(share, 1.0) ** effort.hope)


def value(fit: FitContext, node: Node) -> float:
    """Cost of a node and of its parameters, m², as if the best left only noise."""
    problem = node.best.problem
    count = int(problem.free.sum() + problem.active.sum())
    return node.cost + count * math.log(fit.records.size) * fit.unit


def singles(nodes: Collection[Node], best: Candidate) -> list[Node]:
    """Single effects beside which conditions that differ may do what the best answer does, least cost first.

    That is nothing but such conditions, or several effects of which each is one.
    """
    if bool(best.effects) == bool(best.deviations) or len(best.effects) == 1:
        return []
    alike = [n for n in nodes if len(n.effects) == 1 and not n.deviations]
    return sorted((n for n in alike if not best.effects or includes(best.effects, n.effects)), key=lambda n: n.cost)
