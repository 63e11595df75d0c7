"""Which effects a python-control system can express, and why not the others; derived from what an effect overrides."""

from __future__ import annotations

from collections.abc import Callable

from stepid.effects import Effect
from stepid.errors import InputError

_DRY = "dry friction holds the cart at rest: whether it moves is an event, which an equation of motion cannot say"
_DELAY = "a delay needs the input's past, which no finite number of states holds"


def why_not_nonlinear(effect: Effect) -> str | None:
    """Why `control.nlsys` cannot express an effect, None where it can."""
    kind = type(effect)
    if effect.dry:
        return _DRY
    if kind.delay is not Effect.delay:
        return _DELAY
    if effect.n_memory and kind.memory_slopes is Effect.memory_slopes:
        return "its memory follows the path, and the effect does not say how fast (memory_slopes)"
    if effect.n_extra and kind.rates is Effect.rates:
        return "its state is known in closed form only, and the effect does not say how fast it changes (rates)"
    return None


def why_not_linear(effect: Effect) -> str | None:
    """Why a transfer function or state space cannot express an effect, None where it can."""
    kind = type(effect)
    if kind.delay is not Effect.delay:
        return _DELAY
    if not effect.linear:
        return _DRY if effect.dry else "its force is not linear in the state, or changes with time"
    if kind.reading is not Effect.reading:
        return "the reading changes with time"
    if kind.drive is not Effect.drive and not effect.n_extra:
        return "the drive is not proportional to the voltage"
    return None


def refuse(effects: tuple[Effect, ...], why_not: Callable[[Effect], str | None], *, what: str, remedy: str) -> None:
    """Raise InputError for the effects that cannot be expressed, each with its reason."""
    reasons = [(effect.name, why_not(effect)) for effect in effects]
    lost = [f"{name} ({reason})" for name, reason in reasons if reason is not None]
    if lost:
        raise InputError(f"{what} cannot express {'; '.join(lost)}", remedy)


def system_name(run: str) -> str:
    """Name a system after a run; python-control refuses a dot, as in "1.5 kg"."""
    return run.replace(".", ",")
