"""Candidates and evidence made up of plain numbers: for rules that only read them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from stepid.core.estimate import Estimate
from stepid.diagnosis import gather, refutation, verdict, vetoes
from stepid.diagnosis.criteria import Criteria
from stepid.diagnosis.exchangeable import Condition
from stepid.diagnosis.free_law import FreeLaw
from stepid.diagnosis.gather import EvidenceRecord
from stepid.diagnosis.selection.candidate import Candidate
from stepid.diagnosis.verdict import Answer
from stepid.effects import resolve
from stepid.effects.base import Effect
from stepid.fitting.input_fault import InputFault

FLOOR = 1e-5  # m
RUNS, SAMPLES = 4, 100  # a run


class Kept(SimpleNamespace):
    """Plain values that `once` can refer to weakly."""

    __hash__ = object.__hash__


def white(seed: int = 0) -> np.ndarray:
    """A residual of white noise of the floor's size."""
    return FLOOR * np.random.default_rng(seed).standard_normal(RUNS * SAMPLES)


class MadeUpRecords:
    """As much of `Records` as evidence reads."""

    def __init__(self, position: np.ndarray) -> None:
        self.position = position
        self.weight = np.ones(position.size)
        self.trusted = np.ones(position.size, dtype=bool)
        self.size = position.size
        self.weighed_size = float(position.size)
        self.sample_time = np.full(RUNS, 0.01)
        self.first = SAMPLES * np.arange(RUNS)
        self.runs = tuple(SimpleNamespace(name=f"case {i}", resolution=None) for i in range(RUNS))

    def pieces(self) -> list[slice]:
        return [slice(SAMPLES * i, SAMPLES * (i + 1)) for i in range(RUNS)]


def context() -> Any:
    position = 1e-2 * np.sin(0.3 * np.arange(RUNS * SAMPLES))
    records = MadeUpRecords(position)
    return SimpleNamespace(
        records=records,
        decimated=records,
        floor=FLOOR,
        unit=FLOOR**2,
        full_noise_cost=RUNS * SAMPLES * FLOOR**2,
        noise_cost=RUNS * SAMPLES * FLOOR**2,
        rounding=1e-9,
        rounding_cost=RUNS * SAMPLES * 1e-18,
        dithered=True,
        period=0.5,
        tolerance=0.0,
        slight=lambda optimum: 1e-3 * optimum.cost,
        faults=(),
        colored=None,
        by_weights=None,
        noise_limit=1.2 * RUNS * SAMPLES * FLOOR**2,
    )


def candidate(
    names: Sequence[str] = (),
    *,
    times: float = 1.0,
    deviations: Sequence[str] = (),
    residual: np.ndarray | None = None,
    structure: float = 0.0,
) -> Candidate:
    """A candidate that leaves so many times the floor; every effect and every condition has its price."""
    residual = white() if residual is None else residual
    residual = residual * times * FLOOR / np.sqrt(np.mean(residual**2))
    effects = resolve(tuple(names))
    free = np.ones(4 + sum(len(e.parameters) for e in effects), dtype=bool)
    active = np.zeros((6, RUNS), dtype=bool)
    active[: len(deviations), 1:] = True
    # each condition costs as a parameter does; no run starts late
    layout = SimpleNamespace(
        deviations=slice(0, 0), deviation=lambda _: 0, effects=effects,
        values=places(effects), effect_states=(slice(0, 0),) * len(effects),
    )  # fmt: skip
    lower = np.zeros(free.size)
    problem = SimpleNamespace(free=free, active=active, lower=lower, layout=layout, residual=lambda _: residual)
    optimum: Any = Kept(
        problem=problem,
        shared=np.ones(free.size),
        local=np.zeros_like(active, dtype=float),
        solved=None,
        residual=residual,
        cost=float(residual @ residual),
        rms=times * FLOOR,
    )
    return Candidate(effects, frozenset(deviations), optimum, structure)


def places(effects: Sequence[Effect]) -> tuple[slice, ...]:
    """Where the values of effects are among the shared parameters, after four of the plant."""
    ends = 4 + np.cumsum([len(e.parameters) for e in effects])
    return tuple(slice(int(end) - len(e.parameters), int(end)) for e, end in zip(effects, ends, strict=True))


def evidence(*candidates: Candidate, criteria: Criteria | None = None) -> EvidenceRecord:
    """Evidence of these and of a linear plant that leaves ten floors, unless it is among them."""
    plain = any(not c.effects and not c.deviations for c in candidates)
    every = candidates if plain else (*candidates, candidate(times=10.0))
    return EvidenceRecord(context(), criteria or Criteria(), every)


def losing(found: Candidate, qbic: float, names: Sequence[str], *, deviations: Sequence[str] = ()) -> Candidate:
    """A candidate whose QBIC is larger than another's by so much: what its parameters cost is in it."""
    from stepid.diagnosis.evidence import effective_samples, price

    counts = effective_samples(context().records, found.optimum.residual)
    other = candidate(names, deviations=deviations)
    missing = qbic + price(found.optimum, counts, FLOOR**2) - price(other.optimum, counts, FLOOR**2)
    times = found.optimum.rms / FLOOR * float(np.exp(0.5 * missing / counts.sum()))
    return candidate(names, times=times, deviations=deviations)


LINEAR = candidate(times=10.0)
FRICTION = candidate(["coulomb_friction"])


def all_is_determined(monkeypatch: pytest.MonkeyPatch) -> None:
    """No parameter is open, and nothing stands in for an effect."""
    monkeypatch.setattr(vetoes, "estimates", lambda *_: ({}, None))
    monkeypatch.setattr(gather, "imitators", lambda *_: {})
    monkeypatch.setattr(gather, "followed_condition", lambda *_: None)


def law_of(state: str, parts: float, *, share: float = 0.2, beyond: float = 9.0, change: float = 0.0) -> FreeLaw:
    """A law of any shape that takes so many times what real laws are rough by."""
    return FreeLaw(state, share, parts * Criteria().rough * LINEAR.optimum.cost, beyond, changes=(change,))


def leaving(
    *laws: FreeLaw,
    states: Sequence[str],
    monkeypatch: pytest.MonkeyPatch,
    names: Sequence[str] = ("cubic_stiffness",),
    noise: float = 0.0,
) -> EvidenceRecord:
    """Evidence whose lead, of laws of these states, leaves what these laws of any shape take."""
    e = evidence(candidate(names, times=3.0))
    with_rest(e, noise)
    all_is_determined(monkeypatch)
    monkeypatch.setattr(refutation, "free_laws", lambda *_: laws)
    monkeypatch.setattr(gather, "states_of_all", lambda *_: tuple(frozenset({s}) for s in states))
    return e


def with_rest(e: EvidenceRecord, noise: float = 0.0) -> None:
    """Give evidence the linear plant's cost in the race, and the noise's there, m²."""
    e.context.coarse_linear, e.context.noise_cost = LINEAR.optimum, noise  # type: ignore[misc]


@dataclass
class Told:
    """Evidence whose every answer is given: what a rule of the verdict may ask an `EvidenceRecord`."""

    best: Candidate = FRICTION
    linear: Candidate = LINEAR
    likeliest: Candidate = FRICTION
    lead: Candidate = FRICTION
    white: bool = False
    rivals: tuple[Candidate, ...] = ()
    undetermined: tuple[str, ...] = ()
    imitated: dict[str, str] = field(default_factory=dict)
    not_nameable: tuple[tuple[str, ...], ...] = ()
    too_short: dict[str, str] = field(default_factory=dict)
    sized: dict[str, Estimate] = field(default_factory=dict)
    open_beside: tuple[str, ...] = ()
    beside_lead: tuple[Candidate, ...] = ()
    outdone_by: bool = False
    elsewhere: Candidate | None = None
    sure_part: Candidate | None = None
    share_taken: tuple[float, float] = (0.95, 0.9)
    held: float = 1.0
    simpler: tuple[Candidate, ...] = ()
    stood_for: tuple[tuple[str, ...], ...] = ()
    floored: tuple[str, ...] = ("coulomb_friction", "free_play")
    input_fault: InputFault | None = None
    other_shape: str = ""
    still_followed: str = ""
    goes_with: Condition | None = None
    noisy: bool = True
    judged: bool = True
    taken_by_free: float = 0.9
    criteria: Criteria = field(default_factory=Criteria)
    context: object = field(default_factory=context)

    plain: Candidate = LINEAR
    without: Told | None = None

    @property
    def without_free(self) -> Told:
        return self.without or Told(best=LINEAR, likeliest=LINEAR, lead=LINEAR)

    @property
    def faint(self) -> float:
        return self.criteria.faint

    def at_floor(self, found: Candidate) -> bool:
        return set(found.names) <= set(self.floored) and bool(found.names or found.deviations)

    def times(self, found: Candidate) -> float:
        return found.optimum.rms / FLOOR

    def stands_for(self, simple: Candidate, general: Candidate) -> bool:
        return general.names in self.stood_for

    def weight(self, *found: Candidate) -> float:
        return self.held

    def outdone(self, lead: Candidate) -> bool:
        return self.outdone_by

    def rival_elsewhere(self, lead: Candidate) -> Candidate | None:
        return self.elsewhere

    def beside(self, lead: Candidate) -> tuple[Candidate, ...]:
        return self.beside_lead

    def refuted(self, lead: Candidate) -> str:
        return self.other_shape

    def followed(self, found: Candidate) -> str:
        return self.still_followed

    def systematic(self, found: Candidate) -> Condition | None:
        return self.goes_with

    def is_noise(self, found: Candidate) -> bool:
        return self.noisy

    def judges(self, found: Candidate) -> bool:
        return self.judged

    def share_of_free(self, found: Candidate) -> float:
        return self.taken_by_free

    def patchwork(self, found: Candidate) -> str:
        return self.other_shape if len(found.effects) > 2 else ""

    def share(self, found: Candidate) -> tuple[float, float]:
        return self.share_taken

    def imitators(self, found: Candidate) -> dict[str, str]:
        return self.imitated | self.too_short

    def unseen(self, found: Candidate) -> dict[str, str]:
        return self.too_short

    def barred(self, found: Candidate) -> bool:
        own = bool(self.undetermined or self.too_short) and found.names == self.best.names
        return bool(self.imitated) or own or found.names in self.not_nameable

    def limited(self, found: Candidate) -> dict[str, Estimate]:
        return self.sized

    def open(self, found: Candidate) -> tuple[str, ...]:
        return self.open_beside


def ask(rule: str, **told: object) -> Answer | None:
    """What a rule of the verdict answers on evidence whose every answer is given."""
    found: Answer | None = getattr(verdict, rule)(Told(**told))  # type: ignore[arg-type]
    return found
