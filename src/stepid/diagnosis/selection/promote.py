"""Let the promising candidates run on: the fewer, the further."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from itertools import islice

from stepid.diagnosis.selection.effort import Effort
from stepid.diagnosis.selection.order import of_each_size
from stepid.diagnosis.selection.proposal import Node
from stepid.fitting.multistart import FitContext


def promote(
    nodes: Collection[Node],
    fit: FitContext,
    tie: float,
    effort: Effort,
    worth: Callable[[Node], float],
    named: Callable[[Sequence[Node]], Iterable[Node]],
) -> None:
    """Let the promising nodes of each size run on: the fewer, the further.

    Each size by itself: a single effect on its way to what a larger set leaves would otherwise stay behind that.
    Single effects go on from the end of another start, too: what larger sets begin with.

    Parameters
    ----------
    nodes : collection of Node
    fit : FitContext
    tie : float
        Of `stepid.Criteria`: nodes that are as near to the one of least cost run on as well.
    effort : Effort
    worth : callable
        QBIC of a node: the first by it run on, too. Sets in which the runs differ in everything leave least.
    named : callable
        Those of some nodes that may be named: the first of them run on, too. What may not takes no place of theirs.
    """
    least = min(node.cost for node in nodes)
    for alike in of_each_size(nodes):
        iterations, count = effort.promote, effort.promoted
        while count:
            by_cost = sorted(alike, key=lambda n: n.cost)
            near = by_cost[0].cost + (1 + effort.promoted - count) * fit.unit * tie
            first = [*by_cost[:count], *sorted(alike, key=worth)[:count], *islice(named(by_cost), count)]
            for node in by_cost:
                if node.cost < near or any(node is other for other in first):
                    share = max(effort.enough * max(node.cost - least, node.fitted.excess), effort.converged * fit.unit)
                    node.fitted.run(iterations=iterations, tolerance=share, others=len(node.effects) == 1)
            iterations, count = 2 * iterations, count // 2
