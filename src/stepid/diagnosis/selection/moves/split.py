"""Put two simple effects in the place of a general one whose force is nearly theirs."""

from __future__ import annotations

from itertools import product

import numpy as np

from stepid.core.base import Array
from stepid.diagnosis.selection.proposal import Node, Proposal, SearchContext, related, standing
from stepid.effects.base import Regressor
from stepid.fitting.multistart import Start
from stepid.fitting.weak_form import force_along, motion_along


class Split:
    """Replace a general law by two simple ones, one of them inside it, whose force along its path is nearly its own."""

    name = "split"

    def propose(self, node: Node, context: SearchContext) -> list[Proposal]:
        """Propose pairs of simple effects for a general one that leads alone."""
        if len(node.effects) != 1 or context.effort.effects < 2:
            return []
        effect, fit = node.effects[0], context.fit
        inside = [e for e in context.catalogue if e.name in effect.contains]
        if not inside or effect.affine or effect.n_extra or effect.n_memory:
            return []  # a curved law of velocity or position may be two; others are seldom mistaken
        here = standing(node)
        records, linear = node.best.problem.records, node.best.shared[: here.linear.size]
        motion = motion_along(records, linear, *node.best.solved.states[:2])
        seen = np.abs(motion.v) > context.effort.attenuated * np.abs(motion.v).max()
        force = force_along(effect, here.values[0], motion)
        table = np.column_stack([motion.x, motion.v])[seen]
        found: dict[str, tuple[float, Proposal]] = {}
        others = [e for e in context.catalogue if not e.contains and not any(related(e, i) for i in inside)]
        for one, other in product(inside, [e for e in others if not e.dry]):
            for pair in product(one.regressors(fit.scales, motion), other.regressors(fit.scales, motion)):
                left, start = _fitted(force[seen], table, pair, seen, here.linear, node)
                known = found.get(other.name)
                if start is not None and left < context.effort.alike and (known is None or left < known[0]):
                    promise = 0.5 * node.cost
                    found[other.name] = (
                        left,
                        Proposal((one, other), node.deviations, (start,), node.key, node.best, promise, move=self.name),
                    )
        best = sorted(found.values(), key=lambda item: item[0])[:2]
        return [proposal for _, proposal in best]


def _fitted(
    force: Array, table: Array, pair: tuple[Regressor, Regressor], seen: Array, linear: Array, node: Node
) -> tuple[float, Start | None]:
    """Share of a force that two effects beside stiffness and damping leave, and the start that they make."""
    forces = np.column_stack([table, *(f[seen] for one in pair for f in one.forces)])
    q = np.linalg.qr(table)[0]
    beyond = force - q @ (q.T @ force)
    size = np.linalg.norm(forces, axis=0)
    size[size == 0] = np.inf
    found = np.linalg.lstsq(forces / size, force, rcond=np.sqrt(np.finfo(float).eps))[0] / size
    left = force - forces @ found
    width = 2 + len(pair[0].forces)
    values = pair[0].values(found[2:width]), pair[1].values(found[width:])
    share = float(left @ left) / max(float(beyond @ beyond), np.finfo(float).tiny)
    if values[0] is None or values[1] is None:
        return share, None
    of, moved = node.best.problem.layout, linear.copy()
    moved[of.stiffness] -= found[0]
    moved[of.damping] -= found[1]
    return share, Start(moved, (values[0], values[1]))
