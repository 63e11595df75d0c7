"""What to try where conditions differ from run to run: effects in their place, and effects beside them."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Sequence

from stepid.diagnosis.selection.candidate import Candidate, Key, includes
from stepid.diagnosis.selection.moves.deviate import Deviate
from stepid.diagnosis.selection.moves.instead import Instead
from stepid.diagnosis.selection.proposal import Node, Proposal, standing
from stepid.fitting.deviations import conditions
from stepid.fitting.multistart import Start


def calmer(nodes: Iterable[Node], best: Candidate) -> list[Node]:
    """Nodes of the best's effects in which one condition less differs from run to run, least cost first."""
    one_less = {(best.key[0], best.deviations - {condition}) for condition in best.deviations}
    return sorted((n for n in nodes if n.key in one_less), key=lambda n: n.cost)


def ended_elsewhere(nodes: Sequence[Node], slack: float) -> list[Proposal]:
    """Sets that leave more than the same effects do with fewer conditions free, begun from there.

    What has more that is free cannot leave more: it ended, or is on its way, in another valley.

    Parameters
    ----------
    nodes : sequence of Node
    slack : float
        m², by which it has to leave more.
    """
    out = []
    for node in nodes:
        fewer = (n for n in nodes if n.key[0] == node.key[0] and n.deviations < node.deviations)
        inside = min(fewer, key=lambda n: n.cost, default=None)
        if inside is not None and inside.cost + slack < node.cost:
            here, like, move = (standing(inside),), inside.best, Deviate.name
            out.append(Proposal(inside.effects, node.deviations, here, inside.key, like, inside.cost, move=move))
    return out


def instead(
    proposals: Sequence[Proposal], tried: Collection[tuple[Key, Key]], bases: Collection[Key], share: int
) -> list[Proposal]:
    """The first few effects on each base that may stand in the place of a condition, of those not tried yet."""
    able: dict[Key, list[Proposal]] = {}
    for p in sorted(proposals, key=lambda p: p.rank):
        if p.move == Instead.name and p.base in bases and (p.base, p.key) not in tried:
            able.setdefault(p.base, []).append(p)
    return [p for own in able.values() for p in own[:share]]


def from_the_best(proposal: Proposal, best: Node) -> Start:
    """Where the best stands, with an effect more that a proposal begins: in the place of a condition it does the same.

    Without the condition the best's other parameters have moved to make up for it.
    """
    values = dict(zip((e.name for e in proposal.effects), next(iter(proposal.starts)).values, strict=True))
    here = standing(best)
    values |= zip((e.name for e in best.effects), here.values, strict=True)
    return Start(here.linear, tuple(values[e.name] for e in proposal.effects))


def in_place(nodes: Collection[Node], calmer: Collection[Node], best: Node, slack: float) -> list[Node]:
    """Sets of one effect more than the best, of which the effect takes most of what one of its conditions does.

    Beside the effect runs may still differ, by less.

    Parameters
    ----------
    nodes : collection of Node
    calmer : collection of Node
        Those of the best's effects in which one condition less differs.
    best : Node
    slack : float
        m², cost by which a set with the best's conditions may be worse than the best: if it is by more, it is stuck.
    """
    done = {n.key[0] for n in nodes if n.deviations == best.deviations and n.cost <= best.cost + slack}
    out: dict[Key, Node] = {}
    for node in calmer:
        more = [n for n in nodes if n.deviations <= node.deviations and best.key[0] < n.key[0]]
        more = [n for n in more if len(n.effects) == len(best.effects) + 1]
        found = min(more, key=lambda n: n.cost, default=None)
        most = found is not None and found.cost - best.cost < (node.cost - best.cost) / 2
        if found is not None and most and found.key[0] not in done:
            out[found.key] = found
    return list(out.values())


def singles(nodes: Collection[Node], best: Candidate) -> list[Node]:
    """Single effects beside which a further condition that differs may do what the best answer does, least cost first.

    That is nothing but such conditions, or several effects: one of these, or of the conditions that differ already, may
    stand for another condition.
    """
    if len(best.effects) == 1 or not (best.effects or best.deviations):
        return []
    most = best.deviations if best.effects else frozenset()
    alone = [n for n in nodes if len(n.effects) == 1 and n.deviations <= most]
    return sorted((n for n in alone if not best.effects or includes(best.effects, n.effects)), key=lambda n: n.cost)


def first_of(nodes: Sequence[Node], proposals: Sequence[Proposal], move: str, count: int) -> list[Node]:
    """The first `count` of some nodes, and the `count` of which a proposal by a move promises to leave least.

    Proposals of one further condition count: all together promise to leave nothing of any.
    """
    least: dict[Key, float] = {}
    for p in proposals:
        if p.move == move and conditions(p.deviations - p.base[1]) == 1:
            least[p.base] = min(p.left, least.get(p.base, math.inf))
    promising = sorted((n for n in nodes if n.key in least), key=lambda n: least[n.key])
    return list({n.key: n for n in (*nodes[:count], *promising[:count])}.values())
