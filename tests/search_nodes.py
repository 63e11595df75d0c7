"""Small nodes of a search, and what holds for all that moves propose from them: for tests that search nothing."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

import stepid
from broken_campaigns import campaign
from exact_plants import EFFECTS, exact_campaign
from scattered_campaigns import scattered
from stepid.diagnosis.selection.effort import Effort
from stepid.diagnosis.selection.proposal import Move, Node, Proposal, SearchContext
from stepid.effects import CATALOGUE, Effect, resolve
from stepid.fitting.candidate_fit import CandidateFit
from stepid.fitting.fit import prepare
from stepid.fitting.multistart import FitContext, Start

Values = Mapping[str, Mapping[str, float]]
FRICTION = {"coulomb_friction": {"level": 0.2}}
TWO = FRICTION | {"free_play": {"gap": 5e-4}}
GENERAL = [e for e in CATALOGUE if e.contains]
SIMPLE = [e for e in CATALOGUE if not e.contains]


def noisy(effects: Values) -> stepid.Campaign:
    return campaign(1, effects, masses=(0.0, 0.5, 1.5))


@cache
def prepared(which: str) -> FitContext:
    """Fit contexts of campaigns: none, one or two effects, runs that differ."""
    made = {
        "linear": lambda: noisy({}),
        "friction": lambda: noisy(FRICTION),
        "two": lambda: noisy(TWO),
        "stribeck": lambda: exact_campaign({"stribeck_friction": EFFECTS["stribeck_friction"]}),
        "power": lambda: noisy({"coulomb_friction": {"level": 0.3}, "quadratic_damping": {"coefficient": 40.0}}),
        "gain": lambda: scattered(1, gain=(0.02, -0.02, 0.01, 0.0, -0.01, 0.0)),
    }
    return prepare(made[which]())


def node(fit: FitContext, effects: Values | None = None) -> Node:
    """A node a few steps on from these values; without effects the linear plant.

    The plant starts from the linear fit, whose damper holds what an effect does: from the true values it may end there
    again, from smaller ones it does not.
    """
    if not effects:
        root = CandidateFit(fit, ())
        root.best, root.polished = fit.coarse_linear, fit.linear
        return Node(root)
    fitted = CandidateFit(fit, resolve(tuple(effects)))
    values = tuple(tuple(own.values()) for own in effects.values())
    fitted.begin([Start(fit.coarse_linear.shared, values)], like=fit.coarse_linear, iterations=10)
    return Node(fitted)


def context(fit: FitContext, catalogue: tuple[Effect, ...] = CATALOGUE, **effort: float) -> SearchContext:
    return SearchContext(fit, catalogue, Effort(**effort))


def sets(proposals: list[Proposal]) -> list[tuple[str, ...]]:
    return [tuple(e.name for e in p.effects) for p in proposals]


def sound(move: Move, from_: Node, proposals: list[Proposal]) -> None:
    """What holds for the proposals of every move."""
    assert proposals
    assert len({p.key for p in proposals}) == len(proposals), "two proposals of one set: join their starts"
    most = max(len(from_.effects), Effort().effects)
    for p in proposals:
        assert len({e.name for e in p.effects}) == len(p.effects) <= most, (
            "effects: each once, `effort.effects` at most"
        )
        assert (p.move, p.base, p.like) == (move.name, from_.key, from_.best)
        assert p.key != from_.key
        assert p.starts
        assert p.left >= 0
        assert p.costly >= 1
        for start in p.starts:
            assert start.linear.shape == from_.best.shared[from_.best.problem.layout.linear].shape
            assert [len(v) for v in start.values] == [len(e.parameters) for e in p.effects]
