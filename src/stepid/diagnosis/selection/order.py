"""Which proposals are worth a fit, the most promising first."""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence

from stepid.diagnosis.criteria import Criteria
from stepid.diagnosis.evidence import at_floor
from stepid.diagnosis.selection.candidate import LEADING, Candidate, Key, includes
from stepid.diagnosis.selection.effort import Effort
from stepid.diagnosis.selection.moves.exchange import Exchange
from stepid.diagnosis.selection.moves.generalize import Generalize
from stepid.diagnosis.selection.moves.specialize import Specialize
from stepid.diagnosis.selection.proposal import Move, Node, Proposal, is_mode
from stepid.diagnosis.vetoes import barred, imitators
from stepid.effects.base import Effect
from stepid.fitting.multistart import FitContext, Start


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


def first_together(
    proposals: Sequence[Proposal], nodes: Mapping[Key, Node], share: int, moves: Sequence[Move]
) -> list[Proposal]:
    """Of effects that were scored together the most promising that have not been fitted, a few of each size."""
    out: list[Proposal] = []
    for move in moves:
        out += [p for p in proposals if p.move == move.name and p.key not in nodes][:share]
    return out


def largest_lead(nodes: Iterable[Node]) -> Node | None:
    """Of the sets of as many effects as may lead, conditions alike in all runs, the one that leaves least."""
    most = [n for n in nodes if len(n.effects) == LEADING and not n.deviations]
    return min(most, key=lambda n: n.cost, default=None)


def largest_beyond(nodes: Iterable[Node], aside: Collection[Key]) -> Node | None:
    """Of sets of more effects than may lead, some left aside, the one that leaves least; None without any.

    Those that leave less than half of what any that may lead does, and at most twice what the best does; runs alike.
    """
    alike = [n for n in nodes if not n.deviations]
    more = sorted((n for n in alike if len(n.effects) > LEADING), key=lambda n: n.cost)
    leads = [n.cost for n in alike if len(n.effects) <= LEADING]
    near = [n for n in more if n.cost < min(leads) / 2 and n.cost <= 2 * more[0].cost]
    return next((n for n in near if n.key not in aside), None)


def exchanges(proposals: Sequence[Proposal], nodes: Mapping[Key, Node], base: Node, count: int) -> list[Proposal]:
    """Some exchanges of one effect of a base for another, the most promising first: of sets that are new, or left more.

    They promise to leave less than half of what the others leave without it, where that is known; a linearized step
    tells not much more than the order in which to try.
    """
    out = []
    for p in proposals:
        if p.move != Exchange.name or p.base != base.key or len(p.effects) != len(base.effects):
            continue
        others = nodes.get((p.key[0] & base.key[0], p.deviations))
        known = nodes.get(p.key)
        if (others is None or p.left < others.cost / 2) and (known is None or p.left < known.cost):
            out.append(p)
    return sorted(out, key=lambda p: p.rank)[:count]


def generals(proposals: Sequence[Proposal], nodes: Mapping[Key, Node], base: Node) -> list[Proposal]:
    """A more general law in the place of one of a base's effects: of sets that are new, or left more than the base.

    What contains a law leaves no more than it does: a set that did had ended elsewhere.
    """
    able = [p for p in proposals if p.move == Generalize.name and p.base == base.key]
    newest = {p.key: p for p in able}  # from where the base stands now
    return [p for p in newest.values() if p.key not in nodes or nodes[p.key].cost > base.cost]


def larger(
    proposals: Sequence[Proposal], nodes: Mapping[Key, Node], base: Node | None, share: int, moves: Sequence[Move]
) -> list[Proposal]:
    """Sets of one effect more than may lead, not fitted yet: the first few on a base, and of the moves in turn."""
    able = [p for p in proposals if len(p.effects) > LEADING and not p.deviations and p.key not in nodes]
    own = sorted((p for p in able if base is not None and p.base == base.key), key=lambda p: p.rank)[:share]
    together = first_together(able, nodes, share, moves)[:share]
    return list({p.key: p for p in (*together, *own)}.values())  # the same set once, from its base


def apart(nodes: Iterable[Node], size: int, count: int) -> list[Node]:
    """The sets of so many effects that leave least, conditions alike in all runs; of kin the best only."""
    out: list[Node] = []
    for node in sorted((n for n in nodes if len(n.effects) == size and not n.deviations), key=lambda n: n.cost):
        if len(out) < count and not any(akin(node, other) for other in out):
            out.append(node)
    return out


def akin(one: Node, other: Node) -> bool:
    """Tell whether two sets of as many effects are the same but for laws of which one contains the other."""
    return includes(one.effects, other.effects) or includes(other.effects, one.effects)


def beside(proposals: Sequence[Proposal], base: Key) -> list[Proposal]:
    """Sets of one effect more than a base, conditions alike in all runs, the most promising first."""
    able = [p for p in proposals if p.base == base and base[0] < p.key[0] and not p.deviations]
    return sorted(able, key=lambda p: p.rank)


def inside(nodes: Iterable[Node], pairs: Collection[Node]) -> list[Node]:
    """Of some nodes the single effects that one of the pairs holds, or a law that contains them, the first of each.

    Their runs differ by no more than the pair's.
    """
    first: dict[frozenset[str], Node] = {}
    for node in (n for n in nodes if len(n.effects) == 1):
        if any(node.deviations <= pair.deviations and includes(pair.effects, node.effects) for pair in pairs):
            first.setdefault(node.key[0], node)
    return list(first.values())


def modes(proposals: Sequence[Proposal], nodes: Mapping[Key, Node], bases: Collection[Key]) -> list[Proposal]:
    """A mode beside the effects of each base, of those not fitted yet."""
    new = [p for p in proposals if p.base in bases and p.base[0] and p.base[0] < p.key[0] and p.key not in nodes]
    return list({p.key: p for p in new if any(is_mode(e) for e in p.effects if e.name not in p.base[0])}.values())


def resting(proposals: Sequence[Proposal]) -> list[Proposal]:
    """Simple effects alone that let a cart rest away from the spring's rest position."""
    alone = [p for p in proposals if len(p.effects) == 1 and not (p.deviations or p.base[0])]
    return list({p.key: p for p in alone if p.effects[0].rests_anywhere and not p.effects[0].contains}.values())


def sources(proposal: Proposal, proposals: Sequence[Proposal], rivals: Collection[str]) -> list[Proposal]:
    """A proposal, and those of the same set from other bases: they begin in other valleys."""
    if proposal.move in rivals:
        return [proposal]
    others = [p for p in proposals if p.key == proposal.key and p.move not in rivals and p is not proposal]
    return [proposal, *others]


def starts_in_order(source: Proposal, effects: Sequence[Effect]) -> list[Start]:
    """Starts of a proposal, its effects in this order."""
    order = [source.effects.index(e) for e in effects]
    return [start._replace(values=tuple(start.values[i] for i in order)) for start in source.starts]


def outdone(
    proposal: Proposal, least: Node, root: Node, proposals: Sequence[Proposal], effort: Effort, tie: float
) -> bool:
    """Tell whether a proposal need not be fitted beside a set at the noise floor: it has more, or promises far less.

    Parameters
    ----------
    proposal : Proposal
    least : Node
        The set at the floor.
    root : Node
        The linear plant.
    proposals : sequence of Proposal
        All: what that set promised tells what it takes.
    effort : Effort
    tie : float
        m², difference of cost below which two candidates are not told apart.
    """
    if proposal.base != root.key:  # its rivals are looked for from where it stands
        fewer = len(proposal.effects) < len(least.effects)
        return len(proposal.deviations) >= len(least.deviations) and not fewer
    if len(proposal.effects) > max(len(least.effects), 1):
        return True
    told = min((p.left for p in proposals if p.key == least.key), default=0.0)
    gain, other = root.cost - told, root.cost - proposal.left
    return other < effort.rival * gain and gain - other > 2 * tie


def promises_more(
    proposal: Proposal, known: float, least: float, effort: Effort, fit: FitContext, criteria: Criteria
) -> bool:
    """Tell whether a rival promises to leave less than the `known` cost [m²] at which the same set ended."""
    slack = effort.stuck * fit.unit
    if proposal.move == Specialize.name:  # it stands inside the other: no worse a start
        return known > proposal.left + slack
    rival = proposal.left < least + criteria.tie * slack
    return 0.5 * known > proposal.left or (rival and known > proposal.left + slack)


def nameable(
    fit: FitContext, criteria: Criteria, nodes: Sequence[Node], candidates: Mapping[Key, Candidate]
) -> Iterator[Node]:
    """Of some nodes those without an effect that something else can stand in for, by all samples where known.

    Where these leave only noise, no parameter may be open either: that is no answer.
    """

    def may(node: Node) -> bool:
        known = candidates.get(node.key)
        if known is None or node.fitted.polished is None:
            return not imitators(fit, criteria, Candidate(node.effects, node.deviations, node.best, 0.0))
        if at_floor(fit, criteria, known):
            return not barred(fit, criteria, known)
        return not imitators(fit, criteria, known)

    return filter(may, nodes)


def of_each_size(nodes: Iterable[Node]) -> list[list[Node]]:
    """Nodes by the number of effects and conditions in them, the smallest first; each size in the order given."""
    order = sorted(nodes, key=lambda n: n.size)
    return [list(alike) for _, alike in itertools.groupby(order, key=lambda n: n.size)]


def hoped(proposal: Proposal, effort: Effort) -> float:
    """Cost that may really be left where one linearized step promises to leave some share, m²."""
    share = max(proposal.left, 0.0) / proposal.like.cost if proposal.like.cost > 0 else 1.0
    return float(proposal.like.cost * min(share, 1.0) ** effort.hope)


def hoped_of_parts(
    proposal: Proposal, proposals: Sequence[Proposal], nodes: Mapping[Key, Node], effort: Effort
) -> float:
    """Cost that a set may really leave, by what it promises more than its parts of one effect less, m²; 0 without any.

    Effects that were scored together promise much where one of them takes most: what such a part left once it was
    fitted is known. The part that promises most of what the whole set does tells what the effect left out may add.
    """
    names, whole = proposal.key[0], max(proposal.left, 0.0)
    parts = {
        p.key: p
        for p in proposals
        if p.key in nodes and p.base == proposal.base and p.left > 0 and p.key[0] < names
        and len(p.effects) + 1 == len(proposal.effects) and p.deviations == proposal.deviations
    }  # fmt: skip
    return max((nodes[key].cost * min(whole / p.left, 1.0) ** effort.hope for key, p in parts.items()), default=0.0)


def no_answer(noise_limit: float, effects: Sequence[Effect], cost: float) -> bool:
    """Tell whether a set is none that may lead, and leaves a rest: so many effects are an answer at the floor only."""
    return len(effects) > LEADING and cost > noise_limit
