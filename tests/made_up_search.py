"""A search that has fitted a few sets, made up: what it does next can be asked without a fit."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from made_up_evidence import candidate, context
from stepid import Criteria, Effort
from stepid.diagnosis.selection.attempts import Attempts
from stepid.diagnosis.selection.fits import Fits
from stepid.diagnosis.selection.moves import MOVES
from stepid.diagnosis.selection.queue import Queue
from stepid.diagnosis.selection.search import Search
from stepid.diagnosis.selection.standings import Standings

PAIR = ("coulomb_friction", "cogging")


def nothing_imitates(monkeypatch: pytest.MonkeyPatch) -> None:
    """No linear parameter stands in for an effect, and no runs are repeats."""
    for module in ("standings", "order"):
        monkeypatch.setattr(f"stepid.diagnosis.selection.{module}.imitators", lambda *_: {})
    monkeypatch.setattr("stepid.diagnosis.selection.standings.barred", lambda *_: False)
    monkeypatch.setattr("stepid.diagnosis.selection.standings.repeatability", lambda _: None)


def node(*names: str, cost: float) -> Any:
    found = candidate(names)
    fitted = SimpleNamespace(polished=None, other_valleys=lambda: False)
    own = {"effects": found.effects, "deviations": found.deviations, "key": found.key, "size": len(names)}
    return SimpleNamespace(**own, cost=cost, fitted=fitted, best=found.optimum)


def proposed(base: Any, *names: str, move: str, left: float) -> Any:
    found = candidate(names)
    like = SimpleNamespace(cost=base.cost)
    own = {"effects": found.effects, "deviations": found.deviations, "key": found.key, "size": len(names)}
    return SimpleNamespace(**own, base=base.key, move=move, left=left, rank=left, like=like, gain=base.cost - left)


def a_search(lead: float, *, effort: Effort | None = None, **fit: Any) -> Search:
    """A pair that leaves so much of a misfit of 100 leads; five rivals of it are proposed."""
    prepared: Any = SimpleNamespace(**vars(context()) | {"noise_limit": 1.0, "unit": 0.01} | fit)
    found: Any = Search.__new__(Search)
    found.fit, found.criteria, found.effort, found.moves = prepared, Criteria(), effort or Effort(), MOVES
    found.standings = Standings(found.fit, found.criteria, found.effort)
    found.queue = Queue(found.standings, (), MOVES)
    found.fits = Fits(found.standings, found.queue, lambda proposal: None)
    found._attempts = Attempts(found.fits)
    root, pair = node(cost=100.0), node(*PAIR, cost=lead)
    found.standings.nodes = {n.key: n for n in (root, pair)}
    found.standings.candidates = {c.key: c for c in (candidate(times=30.0), candidate(PAIR, times=8.0))}
    found.queue.proposals = [
        proposed(pair, "coulomb_friction", "free_play", move="exchange", left=0.6 * lead),  # really 0.6^8 of it
        proposed(pair, "stribeck_friction", "cogging", move="generalize", left=0.98 * lead),
        proposed(pair, "coulomb_friction", move="drop", left=lead),
        proposed(pair, "coulomb_friction", "flexible_coupling", move="resemble", left=0.99 * lead),  # a mode
        proposed(pair, *PAIR, "free_play", move="exchange", left=0.9 * lead),  # three are an answer at the noise only
    ]
    return found  # type: ignore[no-any-return]
