"""Whether a residual is white, whatever its size."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import lsim

import stepid
from stepid.fitting.fit import prepare
from stepid.fitting.noise_floor import bounded_floor, noise_floor, von_neumann_ratio
from stepid.simulation.records import lay_out

RECORDS = lay_out(stepid.datasets.lab_campaign())


def _noise(seed: int) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=RECORDS.size)


def test_white_noise_gives_one_within_its_error() -> None:
    found = [von_neumann_ratio(RECORDS, _noise(seed)) for seed in range(200)]
    count = found[0][1]
    assert 1000 < count < RECORDS.size
    scores = np.array([(ratio - 1.0) * np.sqrt(count) for ratio, _ in found])
    assert abs(scores.mean()) < 0.3
    assert scores.std() == pytest.approx(1.0, abs=0.2)


@pytest.mark.parametrize("size", [1e-9, 1e-3])
def test_the_size_of_the_residual_does_not_matter(size: float) -> None:
    assert von_neumann_ratio(RECORDS, size * _noise(1))[0] == pytest.approx(von_neumann_ratio(RECORDS, _noise(1))[0])


def test_a_slow_misfit_as_large_as_a_third_of_the_noise_shows() -> None:
    wave = np.sqrt(2) / 3 * np.sin(2 * np.pi * 1.5 * RECORDS.time)
    ratio, count = von_neumann_ratio(RECORDS, _noise(2) + wave)
    assert ratio > 1.0 + 3.0 / np.sqrt(count)


@pytest.mark.parametrize("samples", [8, 15, 60])
@pytest.mark.parametrize("noise", [2e-4, 5e-3])
def test_an_input_that_changes_at_every_sample_is_no_noise(samples: int, noise: float) -> None:
    rng = np.random.default_rng(4)
    time = np.arange(900) / samples
    volts = rng.standard_normal(900)
    _, swing, _ = lsim(([1.0], [1.0, 0.6, 4 * np.pi**2]), volts, time)
    size = noise * float(np.std(swing))
    run = stepid.Experiment(
        name="a", time=time, position=swing + size * rng.standard_normal(900), input=volts, added_mass=0.0,
        spring="s", damper="d", input_between="lines",
    )  # fmt: skip
    found = noise_floor(lay_out(stepid.Campaign(name="c", experiments=(run,))))
    assert found == pytest.approx(size, rel=0.15)


@pytest.mark.skipif("STEPID_REAL_DATA" not in os.environ, reason="STEPID_REAL_DATA does not name the real recordings")
@pytest.mark.parametrize("kind", ["multisine", "arrow"])
def test_the_floor_of_the_silverbox_is_what_a_bent_prediction_leaves(kind: str) -> None:
    """Beside a prediction of each reading by the four before, their squares and cubes, from two of three slices."""
    files = sorted((Path(os.environ["STEPID_REAL_DATA"]) / "silverbox").glob(f"{kind}-*.csv"))
    records = [np.loadtxt(file, delimiter=",", skiprows=1, unpack=True) for file in files]
    runs = tuple(
        stepid.Experiment(
            name=file.stem, time=np.arange(volts.size) * 2**14 / 1e7, position=position, input=volts, added_mass=0.0,
            spring="s", damper="d",
        )
        for file, (volts, position) in zip(files, records, strict=True)
    )  # fmt: skip
    found = noise_floor(lay_out(stepid.Campaign(name="silverbox", experiments=runs)))
    pieces = [_bent_regressors(volts, y) for volts, y in records]
    squares = []
    for i, (x, y) in enumerate(pieces):
        others = [piece for j, piece in enumerate(pieces) if j != i]
        factors = np.linalg.lstsq(np.vstack([o[0] for o in others]), np.hstack([o[1] for o in others]), rcond=None)[0]
        squares.append(float(np.mean((y - x @ factors) ** 2)) / (1 + float(np.sum(factors[1:5] ** 2))))
    left = np.sqrt(np.mean(squares))  # multisine 44 µV, arrow 105; by differences 630 and 820
    assert 0.6 * left < found < 1.2 * left


def _bent_regressors(volts: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    at = np.arange(4, y.size - 1)
    before = [y[at - j] for j in range(4)]
    bent = [x**power for x in before for power in (2, 3)]
    return np.column_stack([np.ones(at.size), *before, *(volts[at + 1 - j] for j in range(5)), *bent]), y[at + 1]


SPARSE = stepid.PlantModel(
    base_mass={"cart": 0.8}, stiffness={"s": 200.0}, damping={"d": 1.5}, force_gain=8.0, effects=()
)


def sparsely_sampled(cubic: float, *, samples: int, count: int) -> tuple[stepid.Campaign, float]:
    """Two masses under an input that changes at every sample, some samples a period; and the noise, m."""
    rng = np.random.default_rng(5)
    step = 2 * np.pi * np.sqrt(1.3 / 200.0) / samples
    runs = tuple(
        stepid.Experiment(
            name=f"{added} kg",
            time=step * np.arange(count),
            position=np.zeros(count),
            input=np.convolve(rng.standard_normal(count + 2), np.ones(3) / 3, "valid"),
            added_mass=added,
            spring="s",
            damper="d",
            starts="rest",
        )
        for added in (0.0, 0.5, 1.0)
    )
    plain = stepid.Campaign(name="sparse", experiments=runs, weight_uncertainty=1e-9)  # the weights are exact
    size = max(float(np.abs(y).max()) for y in stepid.simulate(SPARSE, plain).values())
    effect = stepid.EffectModel(name="cubic_stiffness", values={"coefficient": cubic * 200.0 / size**2})
    moved = stepid.simulate(SPARSE.model_copy(update={"effects": (effect,)}) if cubic else SPARSE, plain)
    noise = 1e-4 * size
    noisy = tuple(
        run.model_copy(update={"position": moved[run.name] + noise * rng.standard_normal(count)}) for run in runs
    )
    return plain.model_copy(update={"experiments": noisy}), noise


@pytest.mark.parametrize("samples", [8, 15])
def test_few_samples_a_period_hide_no_noise_floor_of_a_linear_plant(samples: int) -> None:
    made, noise = sparsely_sampled(0.0, samples=samples, count=130)
    assert prepare(made).floor == pytest.approx(noise, rel=0.1)


@pytest.mark.parametrize("samples", [8, 15])
@pytest.mark.parametrize("cubic", [0.003, 0.1])
def test_a_cubic_spring_at_few_samples_a_period_is_named(samples: int, cubic: float) -> None:
    made, noise = sparsely_sampled(cubic, samples=samples, count=130)
    found = stepid.diagnose(made)
    assert (found.verdict, found.effects) == ("named", ("cubic_stiffness",))
    assert found.gap.noise == pytest.approx(noise, rel=0.15)


def test_no_fit_leaves_less_than_the_noise() -> None:
    floor, count = 1e-4, RECORDS.size
    assert bounded_floor(RECORDS, floor, 2.0 * floor, 10) == floor
    assert bounded_floor(RECORDS, floor, (1 - 2 / np.sqrt(2 * count)) * floor, 10) == floor  # by chance
    left = bounded_floor(RECORDS, floor, 0.5 * floor, 10)
    assert left == pytest.approx(0.5 * floor * np.sqrt(count / (count - 10)))
    steps = [run.resolution for run in RECORDS.runs if run.resolution is not None]
    assert bounded_floor(RECORDS, floor, 0.0, 10) == pytest.approx(
        max(steps, default=1e-12 * np.sqrt(12)) / np.sqrt(12)
    )
