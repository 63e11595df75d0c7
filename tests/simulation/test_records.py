"""Records laid end to end: what their weights count."""

from __future__ import annotations

import numpy as np
import pytest

from hidden.campaigns import Request, make_campaigns
from stepid.simulation.records import lay_out


def test_readings_count_by_their_weight_whose_square_roots_are_kept() -> None:
    records = lay_out(make_campaigns([Request(3, (), None, None, "four")])[0][0])
    assert records.weighed_size == records.size
    weight = np.where(records.run == 0, 0.5, 1.0)
    part = records.reweighted(weight)
    assert part.weighed_size == pytest.approx(records.size - 0.75 * records.bounds[1])
    assert part.subset([0]).weighed_size == pytest.approx(0.25 * records.bounds[1])
