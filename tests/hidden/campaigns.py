"""Whole campaigns with a known truth, at a wanted visibility.

`r0` is the RMS residual of the best joint linear fit over the noise RMS: 1 is invisible, 100 is plain to the eye. A
campaign is drawn, simulated without noise, fitted linearly; then noise and strength are chosen for the wanted r0.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

import stepid

from .draw import Setup, choose_kind, draw_effect, draw_setup
from .linear_fit import linear_fit
from .outside import DRIVEN_OUTSIDE, apply_outside, ripple
from .perturbed import TRIES, Perturbed, clear, louder, perturb
from .plant import DRY, Run
from .readings import balance, experiments, misfit, simulate, without

ROUNDS = 6
HEAVIEST = 0.05  # noise RMS over static displacement
EXACT = 1e-9  # kg: the weights are what the records say


@dataclass(frozen=True)
class Request:
    """What to hide in one campaign; None is drawn at random from `seed`."""

    seed: int
    effects: tuple[str, ...] = ()
    outside: str | None = None
    r0: float | None = None
    kind: str | None = None
    perturb: tuple[str, ...] = ()
    number: int | None = None  # in its set


@dataclass
class Draft:
    request: Request
    setup: Setup
    target: float
    counting: bool  # no noise but the encoder's own rounding
    noise_wish: float
    spread: float
    variants: tuple[str, ...]
    strength: dict[str, float] = field(default_factory=dict)
    readings: list[np.ndarray] = field(default_factory=list)
    misfit: float = 0.0
    basis: np.ndarray | None = None  # what a linear plant with the effects can move, of the readings
    sigma: float = 0.0
    done: bool = False

    def stream(self, *tag: int) -> np.random.Generator:
        return np.random.default_rng([self.request.seed, *tag])

    def effects(self, only: Sequence[str] | None = None) -> dict[str, dict[str, float]]:
        wanted = self.request.effects if only is None else only
        return {
            name: {
                p: float(v) for p, v in draw_effect(self.stream(2, i), name, self.setup, self.strength[name]).items()
            }
            for i, name in enumerate(self.request.effects)
            if name in wanted
        }

    def runs(self, only: Sequence[str] | None = None) -> list[Run]:
        effects, made = self.effects(only), []
        for i, slot in enumerate(self.setup.slots):
            own = self.stream(3, i)
            start, phase = float(own.uniform(-1, 1)), float(own.uniform(0, 2 * np.pi))
            run = Run(
                mass=self.setup.base_mass + slot.added_mass,
                stiffness=self.setup.stiffness[slot.spring],
                damping=self.setup.damping[slot.damper],
                gain=self.setup.gain,
                sample_time=self.setup.sample_time,
                inputs=slot.inputs,
                effects=effects,
                phase=phase,
                position=slot.position,
                settled="settled" in self.variants,
            )
            if "anywhere in the band" in self.variants and self.setup.kind != "release" and set(effects) & set(DRY):
                forward, backward = run.levels[:2]
                reach = backward if start > 0 else forward
                run = replace(run, position=0.9 * start * reach / run.stiffness)
            if "anywhere in the play" in self.variants and "free_play" in effects:
                run = replace(run, position=run.position + 0.9 * start * effects["free_play"]["gap"])
            if "ripple before" in self.variants and "periodic_disturbance" in effects:
                before = self.lead(run)
                run = replace(run, inputs=np.concatenate([np.zeros(before), run.inputs]))
            if self.request.outside:
                strength = self.strength["outside"]
                run = apply_outside(self.request.outside, run, self.setup, strength, self.stream(4), self.stream(5, i))
            made.append(run)
        return made

    def lead(self, run: Run) -> int:
        """Samples before the record in which a disturbance that is always on comes to its steady swing."""
        decay = run.damping / 2 / run.mass
        return min(1500, int(10 / decay / run.sample_time)) if "ripple before" in self.variants else 0

    def read(self, run: Run, x: np.ndarray, slot_index: int) -> np.ndarray:
        n = self.setup.slots[slot_index].inputs.size
        x = x[x.size - n :]
        if self.request.outside == "sensor_ripple":
            x = ripple(x, self.setup, self.strength["outside"], self.stream(4))
        return x

    @property
    def step(self) -> float:
        return 1 / abs(self.setup.counts_per_meter)

    @property
    def rounding(self) -> float:
        return self.step / float(np.sqrt(12))


def _open(request: Request) -> Draft:
    rng = np.random.default_rng([request.seed, 1])
    needs = ("actuator_lag",) if request.outside in DRIVEN_OUTSIDE else ()  # nothing shows in a release
    kind = request.kind or choose_kind(rng, (*request.effects, *needs))
    setup = draw_setup(rng, kind)
    target = float(np.exp(rng.uniform(0, np.log(100)))) if request.r0 is None else request.r0
    counting = bool(rng.random() < 0.25)
    plain = float(np.exp(rng.uniform(np.log(10), np.log(400))))
    if request.r0 is not None and request.r0 < 10 and (request.effects or request.outside):
        counting = False  # rounding is no noise to an effect smaller than a count
    elif counting and request.r0 is None:
        target = plain
    rounding = 1 / abs(setup.counts_per_meter) / np.sqrt(12)
    heavy = max(HEAVIEST * setup.reach, 3 * rounding)
    wish = rounding if counting else float(np.exp(rng.uniform(np.log(1.5 * rounding), np.log(heavy))))
    spread = float(np.exp(rng.uniform(0, np.log(3))))
    variants = []
    if rng.random() < 0.75:
        variants.append("anywhere in the band")
    odd = rng.random() < 0.2
    if odd and "free_play" in request.effects and kind != "release":
        variants.append("anywhere in the play")
    if odd and "cogging" in request.effects and kind != "release" and not set(request.effects) & set(DRY):
        variants.append("settled")
    if odd and "periodic_disturbance" in request.effects and kind != "release" and len(request.effects) == 1:
        variants.append("ripple before")
    draft = Draft(request, setup, max(target, 1.0), counting, wish, spread, tuple(variants))
    draft.strength = dict.fromkeys((*request.effects, "outside"), 1.0)
    return draft


def _decide(draft: Draft, last: bool) -> None:
    """Accept the draft with the noise that gives the wanted r0, or change the strength for another round."""
    ratio = max(np.sqrt(draft.target**2 - 1), 0.1)
    sigma = draft.misfit / ratio
    heaviest = max(HEAVIEST * draft.setup.reach, 3 * draft.rounding)
    if draft.counting:
        off = draft.rounding / sigma
        fits = 0.9 < off < 1.1
    else:
        fits = 1.02 * draft.rounding <= sigma <= heaviest
        off = draft.noise_wish / sigma
    if fits or last:
        draft.done = True
        draft.sigma = draft.rounding if draft.counting else float(np.clip(sigma, draft.rounding, heaviest))
        return
    for name in draft.strength:
        draft.strength[name] *= float(np.clip(off, 1 / 300, 8))


def _finish(draft: Draft, perturbed: Perturbed | None = None) -> tuple[stepid.Campaign, dict[str, Any]]:
    s, request = draft.setup, draft.request
    noise = np.sqrt(max(draft.sigma**2 - draft.rounding**2, 0.0))
    positions, rests = [], []
    for i, x in enumerate(draft.readings if perturbed is None else perturbed.readings):
        own = draft.stream(6, i)
        rest = own.uniform(-45, 45) * draft.step
        counts = np.round((x + rest + noise * own.standard_normal(x.size)) / draft.step) * np.sign(s.counts_per_meter)
        positions.append(counts / s.counts_per_meter)
        rests.append(float(rest))
    made = experiments(draft, positions)
    found = linear_fit(made, base_mass={"cart": s.base_mass}, stiffness=s.stiffness, damping=s.damping)
    hidden = request.effects if not request.outside else (*request.effects, request.outside)
    name = f"{'+'.join(hidden) or 'none'} {request.seed}"
    if perturbed is not None:
        made, refused = without(made, perturbed.missing)
    truth = {
        "seed": request.seed,
        "number": request.number,
        "kind": s.kind,
        "effects": request.effects,
        "outside": request.outside,
        "base_mass": s.base_mass,
        "stiffness": {k: v for k, v in s.stiffness.items() if any(e.spring == k for e in made)},
        "damping": {k: v for k, v in s.damping.items() if any(e.damper == k for e in made)},
        "force_gain": s.gain,
        "parameters": {f"{e}.{p}": v for e, values in draft.effects().items() for p, v in values.items()},
        "noise_rms": draft.sigma,
        "misfit": draft.misfit,
        "exact": draft.readings,  # without noise, rounding and rest position
        "r0": found.rms / draft.sigma,
        "variants": tuple(v for v in draft.variants if v != "anywhere in the band"),
        "rests": rests,
        "starts": [float(r.start) for r in draft.runs()],
        "phases": [r.phase for r in draft.runs()],
    }
    if perturbed is not None:
        truth |= perturbed.truth(draft.sigma, found.rms) | {"refused": refused}
    return stepid.Campaign(name=name, experiments=tuple(made), weight_uncertainty=EXACT), truth


def _finish_perturbed(draft: Draft) -> tuple[stepid.Campaign, dict[str, Any]]:
    single = bool(draft.request.effects) and not draft.request.outside
    for attempt in range(TRIES):
        campaign, truth = _finish(draft, perturb(draft, attempt))
        if not single or clear(truth):
            return campaign, truth | {"qualified": True}
    again = louder(draft.request)
    if again is None:
        return campaign, truth | {"qualified": False}
    return _finish_perturbed(_settled([again])[0])


def make_campaigns(requests: Sequence[Request]) -> list[tuple[stepid.Campaign, dict[str, Any]]]:
    """Campaigns and truths of all requests."""
    return [_finish_perturbed(d) if d.request.perturb else _finish(d) for d in _settled(requests)]


def _settled(requests: Sequence[Request]) -> list[Draft]:
    """Drafts with their noise and strengths."""
    drafts = [_open(r) for r in requests]
    for count in (2, 3):
        some = [d for d in drafts if len(d.request.effects) == count]
        if some:
            balance(some)
    for number in range(ROUNDS):
        waiting = [d for d in drafts if not d.done]
        if not waiting:
            break
        for draft, readings in zip(waiting, simulate(waiting, [None] * len(waiting)), strict=True):
            draft.readings = readings
            if not draft.request.effects and not draft.request.outside:
                draft.sigma, draft.done = draft.noise_wish, True
                continue
            draft.misfit = misfit(draft, readings)
            _decide(draft, number == ROUNDS - 1)
    return drafts


def make_campaign(
    seed: int,
    effects: tuple[str, ...] = (),
    *,
    outside: str | None = None,
    r0: float | None = None,
    kind: str | None = None,
) -> tuple[stepid.Campaign, dict[str, Any]]:
    """One campaign with the given effects hidden in it, and its truth.

    The same request gives the same campaign, alone or in company.
    """
    return make_campaigns([Request(seed, tuple(effects), outside, r0, kind)])[0]
