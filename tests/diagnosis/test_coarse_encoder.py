"""A sensor of few counts: what is less than its rounding leaves is no evidence, be it as regular as a law."""

from __future__ import annotations

import numpy as np
import pytest

import rubbing_carts
import stepid
from hidden import Run, fast
from stepid.fitting.fit import prepare

STEP = 1e-4  # m, of the encoder; the largest deflection is some 60 of them


def coarse(seed: int, effects: dict[str, dict[str, float]], damping: float = 21.0) -> stepid.Campaign:
    """Steps up of a cart, each encoder begun somewhere within a count."""
    rng, time = np.random.default_rng(seed), 0.01 * np.arange(300)
    added, volts = (0.0, 0.5, 2.0), (0.5, 0.25, 0.5)
    runs = [
        Run(
            mass=1.4 + more, stiffness=490.0, damping=damping, gain=6.2, sample_time=0.01,
            inputs=np.where(time >= 0.1, level, 0.0), effects=effects,
        )
        for more, level in zip(added, volts, strict=True)
    ]  # fmt: skip
    read = [STEP * np.round(x / STEP + rng.uniform(-0.5, 0.5)) for x in fast(runs)]
    return stepid.Campaign(
        name="coarse",
        experiments=[
            stepid.Experiment(
                name=f"case {i}", time=time, position=x, input=run.inputs, added_mass=more, spring="s", damper="d",
                counts_per_meter=1 / STEP,
            )
            for i, (x, run, more) in enumerate(zip(read, runs, added, strict=True))
        ],
    )  # fmt: skip


@pytest.mark.parametrize("seed", [4, 5, 7])
def test_rounding_is_no_cogging_beside_friction(seed: int) -> None:
    found = stepid.diagnose(coarse(seed, {"coulomb_friction": {"level": 0.16}}))
    assert found.verdict in ("named", "ambiguous")
    assert ("coulomb_friction",) in (found.effects, *found.alternatives)
    assert len(found.effects) == 1


def test_a_linear_plant_stays_linear() -> None:
    assert stepid.diagnose(coarse(3, {})).verdict == "adequate"


def test_readings_on_a_grid_are_rounded_whether_counts_are_said_or_not() -> None:
    step = 2e-5
    plain = rubbing_carts.campaign(2)
    read = [run.model_copy(update={"position": step * np.round(run.position / step)}) for run in plain.experiments]
    counted = [run.model_copy(update={"counts_per_meter": 1 / step}) for run in read]
    untold, told = (plain.model_copy(update={"experiments": tuple(runs)}) for runs in (read, counted))
    assert prepare(untold).floor == pytest.approx(prepare(told).floor, rel=1e-9)
    assert prepare(untold).rounding == pytest.approx(step / np.sqrt(12))
    assert stepid.diagnose(untold).effects == stepid.diagnose(told).effects == ("coulomb_friction",)
