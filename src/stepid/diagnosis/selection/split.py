"""A general friction law that leads may stand for two simple effects: its force, in terms of theirs."""

from __future__ import annotations

from itertools import product
from typing import NamedTuple

import numpy as np

from stepid.diagnosis.selection.candidate import Candidate, polish
from stepid.diagnosis.selection.racing import Progress
from stepid.effects.base import Effect
from stepid.fitting.multistart import Contender, FitContext, Start
from stepid.fitting.weak_form import force_along, motion_along

_LEFT = 0.1  # share of the force that two simple effects may leave, beyond the plant's own
_TRIED = 2
_CREEP = 0.02  # of the largest velocity, below which friction holds as much as it moves


class _Words(NamedTuple):
    left: float
    effects: tuple[Effect, ...]
    start: Start


def translated(
    context: FitContext, general: Contender, catalogue: tuple[Effect, ...], progress: Progress
) -> list[Candidate]:
    """Fit the pairs of simple effects whose force along its path is nearly a general law's, from where they agree."""
    found = []
    for words in _translations(context, general, catalogue)[:_TRIED]:
        assert general.best is not None
        progress(" + ".join(e.name for e in words.effects))
        contender = Contender(context, words.effects)
        contender.begin([words.start], like=general.best, keep=1)
        contender.run(laps=20)
        done = polish(context, contender) if contender.cost < general.cost else None
        if done is not None:
            found.append(done)
    return found


def _translations(context: FitContext, general: Contender, catalogue: tuple[Effect, ...]) -> list[_Words]:
    """Starts of an effect inside the general one with another beside it, the nearest first."""
    effect, best = general.effects[0], general.best
    if best is None or effect.affine or not effect.contains or effect.n_extra or effect.n_memory:
        return []  # a curved law of velocity or position may be two; others are seldom mistaken
    of = general.coarse.layout
    n = of.linear.stop
    motion = motion_along(general.coarse.records, best.shared[:n], *best.solved.states[:2])
    seen = np.abs(motion.v) > _CREEP * np.abs(motion.v).max()
    force = force_along(effect, tuple(float(v) for v in best.shared[n:]), motion)
    out = []
    inside = [e for e in catalogue if e.name in effect.contains]
    for one, other in product(inside, [e for e in catalogue if not e.contains and not e.dry]):
        pairs = product(one.regressors(context.scales, motion), other.regressors(context.scales, motion))
        for first, second in pairs:
            table = np.column_stack([motion.x, motion.v, *first.forces, *second.forces])[seen]
            q = np.linalg.qr(table[:, :2])[0]
            beyond = force[seen] - q @ (q.T @ force[seen])
            size = np.linalg.norm(table, axis=0)
            size[size == 0] = np.inf
            found = np.linalg.lstsq(table / size, force[seen], rcond=1e-9)[0] / size
            left = force[seen] - table @ found
            width = 2 + len(first.forces)
            values = first.values(found[2:width]), second.values(found[width:])
            share = float(left @ left) / max(float(beyond @ beyond), np.finfo(float).tiny)
            if None in values or share > _LEFT:
                continue
            linear = best.shared[:n].copy()
            linear[of.stiffness] -= found[0]
            linear[of.damping] -= found[1]
            out.append(_Words(share, (one, other), Start(linear, tuple(v for v in values if v is not None))))
    return sorted(out, key=lambda words: words.left)
