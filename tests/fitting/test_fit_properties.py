"""What must not matter to the joint fit: sign of the encoder, order of runs, the encoder's zero."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

import stepid
from closed_form import Plant, make_run

few = settings(max_examples=6, deadline=None, derandomize=True)
plants = st.builds(
    Plant,
    base_mass=st.floats(0.6, 1.5),
    stiffness=st.floats(150.0, 500.0),
    damping=st.floats(2.0, 12.0),
    gain=st.sampled_from([7.8, -5.0]),
)
seeds = st.integers(0, 2**32 - 1)


def campaign(plant: Plant, seed: int) -> stepid.Campaign:
    rng = np.random.default_rng(seed)
    runs = [
        make_run(plant, added, name=f"case {i}", count=160, noise=2e-5, rng=rng)
        for i, added in enumerate((0.0, 0.5, 1.5))
    ]
    return stepid.Campaign(name="linear", experiments=tuple(runs))


def moved(given: stepid.Campaign, *, factor: float = 1.0, offsets: tuple[float, ...] = (0.0,) * 3) -> stepid.Campaign:
    return stepid.Campaign(
        name="moved",
        experiments=tuple(
            e.model_copy(update={"position": factor * e.position + offset})
            for e, offset in zip(given.experiments, offsets, strict=True)
        ),
    )


def same(one: stepid.Fit, other: stepid.Fit, *, gain: float = 1.0) -> None:
    """Parameters agree to a hundredth of their uncertainties, the uncertainties to a thousandth."""
    for name, estimate in one.parameters.items():
        factor = gain if name == "force_gain" else 1.0
        twin = other.parameters[name]
        assert estimate.uncertainty is not None
        assert twin.uncertainty is not None
        assert abs(factor * twin.value - estimate.value) < 0.01 * estimate.uncertainty, name
        assert abs(twin.uncertainty / estimate.uncertainty - 1) < 1e-3, name


@few
@given(plants, seeds)
def test_the_encoders_sign_turns_the_gain_and_nothing_else(plant: Plant, seed: int) -> None:
    data = campaign(plant, seed)
    same(stepid.fit(data), stepid.fit(moved(data, factor=-1.0)), gain=-1.0)


@few
@given(plants, seeds, st.permutations([0, 1, 2]))
def test_the_order_of_runs_does_not_matter(plant: Plant, seed: int, order: list[int]) -> None:
    data = campaign(plant, seed)
    shuffled = stepid.Campaign(name="shuffled", experiments=tuple(data.experiments[i] for i in order))
    same(stepid.fit(data), stepid.fit(shuffled))


@few
@given(plants, seeds, st.tuples(*[st.floats(-0.1, 0.1)] * 3))
def test_the_encoders_zero_does_not_matter(plant: Plant, seed: int, offsets: tuple[float, float, float]) -> None:
    data = campaign(plant, seed)
    first, second = stepid.fit(data), stepid.fit(moved(data, offsets=offsets))
    same(first, second)
    for e, offset in zip(data.experiments, offsets, strict=True):
        shift = second.model.runs[e.name].rest - first.model.runs[e.name].rest
        assert abs(shift - offset) < 1e-7
