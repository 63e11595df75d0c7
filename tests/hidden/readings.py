"""What the sensor of a drafted campaign reads, how much a linear fit leaves of it, and effects that balance."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

import stepid

from .fast import fast
from .linear_fit import linear_fit

if TYPE_CHECKING:
    from .campaigns import Draft


def experiments(draft: Draft, readings: Sequence[np.ndarray]) -> list[Any]:
    s = draft.setup
    return [
        stepid.Experiment(
            name=slot.name,
            time=np.asarray(s.sample_time * np.arange(slot.inputs.size), np.float64),
            position=x,
            input=slot.inputs,
            added_mass=slot.added_mass,
            spring=slot.spring,
            damper=slot.damper,
            counts_per_meter=s.counts_per_meter,
        )
        for slot, x in zip(s.slots, readings, strict=True)
    ]


def misfit(draft: Draft, readings: Sequence[np.ndarray]) -> float:
    s = draft.setup
    found = linear_fit(
        experiments(draft, readings), base_mass={"cart": s.base_mass}, stiffness=s.stiffness, damping=s.damping
    )
    return found.rms


def simulate(drafts: Sequence[Draft], only: Sequence[Sequence[str] | None]) -> list[list[np.ndarray]]:
    """Readings of each draft; one that runs away is made weaker until it does not."""
    with np.errstate(over="ignore", invalid="ignore"):
        out = _simulated(drafts, only)
    wild = [i for i, some in enumerate(out) if not all(np.isfinite(x).all() for x in some)]
    if wild:
        for i in wild:
            for name in drafts[i].strength:
                drafts[i].strength[name] *= 0.5
        again = simulate([drafts[i] for i in wild], [only[i] for i in wild])
        for i, readings in zip(wild, again, strict=True):
            out[i] = readings
    return out


def _simulated(drafts: Sequence[Draft], only: Sequence[Sequence[str] | None]) -> list[list[np.ndarray]]:
    runs = [d.runs(o) for d, o in zip(drafts, only, strict=True)]
    flat = fast([r for some in runs for r in some])
    out, at = [], 0
    for draft, some in zip(drafts, runs, strict=True):
        out.append([draft.read(r, flat[at + i], i) for i, r in enumerate(some)])
        at += len(some)
    return out


def balance(drafts: Sequence[Draft]) -> None:
    """Of several effects, none may hide behind another: misfits alone within a factor of three of the largest."""
    alone: dict[int, list[float]] = {id(d): [] for d in drafts}
    for which in range(len(drafts[0].request.effects)):
        only = [(d.request.effects[which],) for d in drafts]
        for draft, readings in zip(drafts, simulate(drafts, only), strict=True):
            alone[id(draft)].append(misfit(draft, readings))
    for draft in drafts:
        sizes = [max(m, 1e-9) for m in alone[id(draft)]]
        for name, size in zip(draft.request.effects, sizes, strict=True):
            if max(sizes) > draft.spread * size:
                draft.strength[name] *= min(max(sizes) / size / draft.spread, 8.0)


def without(made: Sequence[Any], missing: Sequence[np.ndarray]) -> tuple[list[Any], str]:
    """Records that lack their missing samples, with the real time stamps; and what `stepid` says if it refuses them."""
    out, refused = [], ""
    for e, gone in zip(made, missing, strict=True):
        fields = {name: np.array(getattr(e, name))[~gone] for name in ("time", "position", "input")}
        try:
            out.append(stepid.Experiment(**(e.model_dump() | fields)) if gone.any() else e)
        except ValueError as error:
            out.append(e)
            refused = str(error)
    return out, refused
