"""Effects of one state whose forces cancel: the law is neither of theirs."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from hidden.campaigns import Request, make_campaigns
from stepid.diagnosis.states import cancelling, states_of, states_of_all
from stepid.effects import resolve
from stepid.fitting.fit import prepare
from stepid.fitting.fit_effects import fit_effects
from stepid.fitting.levenberg_marquardt import Optimum
from stepid.fitting.multistart import FitContext


@pytest.fixture(scope="module")
def bent() -> FitContext:
    return prepare(make_campaigns([Request(3, ("cubic_stiffness",), None, 8.0, "four")])[0][0])


def having(context: FitContext, *names: str, values: tuple[float, ...]) -> Optimum:
    """A fit with the effects' parameters set by hand."""
    fitted = fit_effects(context, resolve(names))
    assert fitted is not None
    shared = fitted.shared.copy()
    shared[fitted.problem.layout.values[0].start :] = values
    return replace(fitted, shared=shared)


def cancelled(context: FitContext, fitted: Optimum) -> str:
    return cancelling(context, fitted, states_of_all(context, fitted))


@pytest.mark.parametrize(
    ("part", "found"), [(1.0, "position"), (0.8, "position"), (0.4, ""), (3.0, ""), (0.0, ""), (-1.0, "")]
)
def test_a_spring_that_hardens_cancels_one_that_softens(bent: FitContext, part: float, found: str) -> None:
    """k (sin(a x)/a - x) is -k a² x³/6 and less: a cubic of as much leaves little of either."""
    curvature = 0.5 / bent.scales.displacement
    cubic = part * float(bent.motion.stiffness.mean()) * curvature**2 / 6
    fitted = having(bent, "cubic_stiffness", "sine_stiffness", values=(cubic, curvature))
    assert cancelled(bent, fitted) == found


def test_effects_of_other_states_cancel_nothing(bent: FitContext) -> None:
    curvature = 0.5 / bent.scales.displacement
    assert cancelled(bent, having(bent, "quadratic_damping", "sine_stiffness", values=(-9.0, curvature))) == ""
    assert cancelled(bent, having(bent, "sine_stiffness", values=(curvature,))) == ""
    assert cancelled(bent, bent.linear) == ""


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_stop_that_is_met_at_the_end_of_the_motion_only_has_a_state(bent: FitContext, side: float) -> None:
    """Of 200 samples all along a long record none need be in contact."""
    (stop,) = resolve(["end_stop"])
    x = 0.009 * np.sin(0.01 * np.arange(20_001))
    x[10_001:10_021] = side * 0.0101  # between the 10,000th sample and the next of the 200
    motion = bent.motion._replace(**{name: np.zeros(x.size) for name in bent.motion._fields} | {"x": x})
    context: Any = SimpleNamespace(motion=motion)
    given = tuple(side * 0.01 if q.name == "position" else 1e4 for q in stop.parameters)
    assert states_of(context, stop, given) == {"position"}
