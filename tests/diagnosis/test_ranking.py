"""What is told and drawn of the candidates."""

from __future__ import annotations

import matplotlib as mpl
import pytest
from matplotlib import pyplot as plt

import diagnosis_example as example
from diagnosis_example import changed
from stepid.diagnosis.text import ranking_header, ranking_rows
from stepid.plot import candidates


@pytest.mark.parametrize(("times", "told"), [(1.14, True), (1.16, False)])
def test_a_weight_is_a_probability_where_a_candidate_leaves_little_more_than_noise(times: float, told: bool) -> None:
    """One of several that all miss something is not the missing law, whatever it weighs."""
    d = example.named()
    far = tuple(one.model_copy(update={"rms": times * d.gap.noise}) for one in d.ranking)
    made = changed(d, ranking=far)
    assert made.reaches_noise is told
    assert ("probability" in ranking_header(made)) is told
    assert {len(row) for row in ranking_rows(made)} == {len(ranking_header(made))}
    table = made.summary().split("3. Which")[1].split("4. Is one")[0]
    assert ("probability" in table) is told
    mpl.use("Agg")
    axes = plt.figure().subplots()
    candidates(made, axes=axes)
    assert ("probable" in axes.get_xlabel()) is told
    plt.close("all")
