"""Which proposals are worth a fit."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Sequence

from stepid.diagnosis.selection.candidate import Key
from stepid.diagnosis.selection.effort import Effort
from stepid.diagnosis.selection.proposal import Node, Proposal


def worthy(order: Sequence[Proposal], nodes: Iterable[Node], effort: Effort, rivals: Collection[str]) -> list[Proposal]:
    """Of each node's proposals those that promise a share of what its best promises; most on the best nodes.

    Parameters
    ----------
    order : sequence of Proposal
        Most promising first.
    nodes : iterable of Node
        All there are.
    effort : Effort
    rivals : collection of str
        Moves that look for rivals of an answer: all of their proposals are worth it.
    """
    plain: dict[int, Node] = {}
    for node in sorted(nodes, key=lambda n: n.cost):
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
