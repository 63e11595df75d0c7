"""Take one effect away."""

from __future__ import annotations

import numpy as np

from stepid.core.base import Array
from stepid.diagnosis.selection.proposal import Node, Proposal, SearchContext
from stepid.fitting.levenberg_marquardt import Optimum
from stepid.fitting.multistart import Start


class Drop:
    """Take each effect of a set away: a smaller set can have been stuck where the larger one was not."""

    name = "drop"

    def propose(self, node: Node, context: SearchContext) -> list[Proposal]:
        """Propose the node's effects without one of them."""
        out = []
        for place, effect in enumerate(node.effects if len(node.effects) > 1 else ()):
            own = node.best.problem.layout.values[place]
            values = tuple(float(v) for v in node.best.shared[own])
            moved, loss = without(node.best, own, np.array(effect.faint(values, 0.0)))
            of = node.best.problem.layout
            rest = [i for i in range(len(node.effects)) if i != place]
            start = Start(moved[of.linear], tuple(tuple(map(float, moved[of.values[i]])) for i in rest))
            still = Start(node.best.shared[of.linear], tuple(tuple(map(float, node.best.shared[of.values[i]])) for i in rest))
            effects = tuple(node.effects[i] for i in rest)
            out.append(Proposal(effects, node.deviations, (start, still), node.best, node.cost + loss, 1.0, self.name))
        return out


def without(optimum: Optimum, own: slice, values: Array) -> tuple[Array, float]:
    """Parameters with those of one effect set to `values` and the others where that asks for them, to first order.

    Returns the global parameters, shape (P,), and the increase of the cost that it asks for, m².
    """
    problem = optimum.problem
    jacobian = problem.jacobian(optimum.solved)
    place = np.flatnonzero(problem.free)
    fixed = np.zeros(jacobian.shape[1], dtype=bool)
    fixed[: place.size] = (place >= own.start) & (place < own.stop)
    shared = optimum.shared.copy()
    shared[own] = values
    if not np.isfinite(jacobian).all():
        return shared, 0.0
    asked = jacobian[:, fixed] @ (values - optimum.shared[own])[problem.free[own]]
    size = np.linalg.norm(jacobian, axis=0)
    size[size == 0] = np.inf
    scaled = (jacobian / size)[:, ~fixed]
    step = np.linalg.lstsq(scaled, -asked, rcond=1e-6)[0]
    left = asked + scaled @ step
    change = np.zeros(jacobian.shape[1])
    change[~fixed] = step / size[~fixed]
    shared[problem.free] += change[: place.size]
    shared[own] = values
    return np.clip(shared, problem.lower, problem.upper), float(left @ left)
