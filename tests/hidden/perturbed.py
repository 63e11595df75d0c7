"""Campaigns that are perturbed: a settled draft is run again with its perturbations, and what they cost is told.

`r0_perturbation` is the RMS that the perturbations leave of the best linear plant with the true effect, over the floor
(1: nothing to be seen). `share` is what the true effect takes of the misfit's power, noise included.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from . import changes
from .fast import fast
from .linear_fit import free_response, unit_response
from .outside import ripple
from .perturb import HOLDS, Sizes, draw, gone, on_reading, on_run, own_size
from .readings import misfit

if TYPE_CHECKING:
    from .campaigns import Draft, Request

TRIES = 8  # draws of a perturbation until the effect takes its part
HALF, CLEAREST, FAINTEST = 0.5, 100.0, 1.5


@dataclass(frozen=True)
class Perturbed:
    """One draw: sizes by kind, deviations run by run, and what the sensor then reads (without white noise), m."""

    sizes: dict[str, Sizes]
    runs: dict[str, list[float]]
    readings: list[np.ndarray]
    missing: list[np.ndarray]
    cost: float  # RMS that no linear plant with the true effect takes up, m
    alone: dict[str, float]  # the same of each kind alone
    cut: tuple[float, float] | None  # where a hand holds: cost, and linear misfit, of what comes after the release

    def truth(self, floor: float, linear: float) -> dict[str, Any]:
        after = floor**2 + self.cost**2
        told: dict[str, Any] = {"r0_perturbation": float(np.sqrt(after) / floor)}
        told["r0_kinds"] = {k: float(np.hypot(cost, floor) / floor) for k, cost in self.alone.items()}
        if self.cut is not None:  # whoever knows of the hold sets it aside
            after = floor**2 + self.cut[0] ** 2
            linear = float(np.hypot(floor, self.cut[1]))
            told["r0"] = linear / floor
        perturbations = {k: {**s, "runs": self.runs[k]} for k, s in self.sizes.items()}
        return told | {"perturbations": perturbations, "share": float(1 - after / linear**2)}


def perturb(draft: Draft, attempt: int, only: str | None = None) -> Perturbed:
    """The readings of a settled draft with its perturbations (or `only` one), which `attempt` draws anew."""
    kinds, setup = draft.request.perturb, draft.setup
    sizes = {k: draw(k, draft.stream(7, attempt, i), setup) for i, k in enumerate(kinds) if only in (None, k)}
    runs = draft.runs()
    off: dict[str, list[float]] = {k: [] for k in sizes}
    for j, slot in enumerate(setup.slots):
        for i, kind in _numbered(kinds, sizes):
            own = draft.stream(8, attempt, i, j)
            off[kind].append(float(own_size(kind, sizes[kind], own, slot.inputs)))
            runs[j] = on_run(kind, sizes[kind], off[kind][j], runs[j], setup, own)
    readings, free, missing = [], [], []
    for j, (slot, x) in enumerate(zip(setup.slots, fast(runs), strict=True)):
        x = x[x.size - slot.inputs.size :]
        if draft.request.outside == "sensor_ripple":
            x = ripple(x, setup, draft.strength["outside"], draft.stream(4))
        lost = np.zeros(x.size, bool)
        after = x  # the release, as if no hand had held
        for i, kind in _numbered(kinds, sizes):
            x = on_reading(kind, sizes[kind], off[kind][j], x, setup, draft.sigma, draft.stream(9, attempt, i, j))
            if kind not in HOLDS:
                own = draft.stream(9, attempt, i, j)
                after = on_reading(kind, sizes[kind], off[kind][j], after, setup, draft.sigma, own)
            lost |= gone(kind, sizes[kind], slot.inputs, draft.stream(10, attempt, i, j))
        free.append(after)
        if sizes.get("dropped", {}).get("held"):
            x, lost = changes.repeated(x, lost), np.zeros(x.size, bool)
        readings.append(np.asarray(x))
        missing.append(lost)
    cost = _cost(draft, readings)
    alone = {k: cost if len(sizes) == 1 else perturb(draft, attempt, k).cost for k in sizes}
    cut = (_cost(draft, free), misfit(draft, free)) if set(sizes) & set(HOLDS) else None
    return Perturbed(sizes, off, readings, missing, cost, alone, cut)


def _numbered(kinds: Sequence[str], some: Iterable[str]) -> list[tuple[int, str]]:
    return [(i, kind) for i, kind in enumerate(kinds) if kind in some]


def _linear(draft: Draft, factors: dict[str, float]) -> np.ndarray:
    """All readings of the linear plant, one after the other, with some parameters changed by a factor."""
    s, out = draft.setup, []
    for slot in s.slots:
        mass = s.base_mass * factors.get("mass", 1.0) + slot.added_mass
        k = s.stiffness[slot.spring] * factors.get(f"stiffness {slot.spring}", 1.0)
        c = s.damping[slot.damper] * factors.get(f"damping {slot.damper}", 1.0)
        if np.any(slot.inputs):
            out.append(s.gain * factors.get("gain", 1.0) * unit_response(mass, k, c, slot.inputs, s.sample_time))
        else:
            columns = free_response(mass, k, c, slot.inputs.size, s.sample_time)
            out.append(slot.position * (columns[:, 0] + c / (2 * mass) * columns[:, 1]))
    return np.concatenate(out)


def _columns(draft: Draft) -> np.ndarray:
    """What the parameters of the linear plant, the rest positions, initial states and the effect's size can move."""
    s = draft.setup
    plain = _linear(draft, {})
    labels = {f"stiffness {x.spring}" for x in s.slots} | {f"damping {x.damper}" for x in s.slots}
    names = ["mass", "gain", *sorted(labels)]
    columns = [(_linear(draft, {n: 1.001}) - plain) * 1000 for n in names]
    columns.append(np.concatenate(draft.readings) - plain)
    begin = 0
    for slot in s.slots:
        n = slot.inputs.size
        some = [np.ones((n, 1))]
        if not np.any(slot.inputs):
            plant = (s.base_mass + slot.added_mass, s.stiffness[slot.spring], s.damping[slot.damper])
            some.append(free_response(*plant, n, s.sample_time))
        for own in np.hstack(some).T:
            column = np.zeros(plain.size)
            column[begin : begin + n] = own
            columns.append(column)
        begin += n
    sizes = [float(np.sqrt(np.mean(c**2))) for c in columns]
    smallest = 1e-9 * s.reach
    return np.column_stack([c / size for c, size in zip(columns, sizes, strict=True) if size > smallest])


def _cost(draft: Draft, readings: Sequence[np.ndarray]) -> float:
    change = np.concatenate(readings) - np.concatenate(draft.readings)
    if draft.basis is None:  # the same for all draws of the perturbations
        left, values, _ = np.linalg.svd(_columns(draft), full_matrices=False)
        draft.basis = left[:, values > 1e-7 * values[0]]
    return float(np.sqrt(np.mean((change - draft.basis @ (draft.basis.T @ change)) ** 2)))


def clear(truth: dict[str, Any]) -> bool:
    """Whether the one true effect takes half of the misfit, at an r0 in the range."""
    return bool(truth["share"] >= HALF and FAINTEST <= truth["r0"] <= CLEAREST)


def louder(request: Request) -> Request | None:
    """The same request at a greater visibility, where the perturbations hide the effect; None where it is greatest."""
    most = 0.7 * CLEAREST
    if request.r0 is None or request.r0 >= most:
        return None
    return replace(request, r0=min(2.5 * request.r0, most))
