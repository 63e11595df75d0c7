"""Where the hidden simulator's steps meet their limits: a lag that they do not resolve, a run that does not end."""

from __future__ import annotations

import sys
from dataclasses import replace

import numpy as np
import pytest

from hidden import Run, fast, reference

T = 0.0088542


def step_run(**changes: object) -> Run:
    inputs = np.zeros(400)
    inputs[5:200] = 0.5
    run = Run(mass=1.45, stiffness=216.0, damping=6.0, gain=7.8, sample_time=T, inputs=inputs, phase=0.7)
    return replace(run, **changes)  # type: ignore[arg-type]


def test_a_lag_too_short_for_micro_steps_is_a_delay() -> None:
    plain = fast([step_run()])[0]
    np.testing.assert_array_equal(fast([step_run(effects={"actuator_lag": {"time_constant": 1e-14}})])[0], plain)
    lag = 2e-6
    speed = np.gradient(plain, T)
    late = fast([step_run(effects={"actuator_lag": {"time_constant": lag}})])[0]
    np.testing.assert_allclose(late, plain - lag * speed, atol=0.05 * lag * np.max(np.abs(speed)))


def test_the_reference_gives_up_where_it_would_never_end(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys.modules["hidden.reference"], "MOST", 2000)
    with pytest.raises(RuntimeError, match=r"no end in sight at 0\.0\d+ s"):
        reference(step_run(effects={"actuator_lag": {"time_constant": 1e-7}}))
