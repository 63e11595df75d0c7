"""Where the hidden simulator's steps meet their limits: a lag that they do not resolve, a run that does not end."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from exact_plants import PERIOD
from hidden import fast, reference
from paper_run import paper_run


def test_a_lag_too_short_for_micro_steps_is_a_delay() -> None:
    plain = fast([paper_run()])[0]
    np.testing.assert_array_equal(fast([paper_run(effects={"actuator_lag": {"time_constant": 1e-14}})])[0], plain)
    lag = 2e-6
    speed = np.gradient(plain, PERIOD)
    late = fast([paper_run(effects={"actuator_lag": {"time_constant": lag}})])[0]
    np.testing.assert_allclose(late, plain - lag * speed, atol=0.05 * lag * np.max(np.abs(speed)))


def test_the_reference_gives_up_where_it_would_never_end(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys.modules["hidden.reference"], "MOST", 2000)
    with pytest.raises(RuntimeError, match=r"no end in sight at 0\.0\d+ s"):
        reference(paper_run(effects={"actuator_lag": {"time_constant": 1e-7}}))
