"""The hidden simulator against closed forms, and its two routes against each other."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid
from scipy.linalg import expm
from scipy.optimize import brentq
from scipy.special import ellipk

from exact_plants import EFFECTS, NEW_EFFECTS
from hidden import EVERY, Run, fast, reference, sets
from paper_run import paper_run

COUNT = 1 / 226600
T = 0.0088542
EXAMPLES = {**EFFECTS, **NEW_EFFECTS}


def both(run: Run) -> list[np.ndarray]:
    return [reference(run), fast([run])[0]]


def held_linear(matrix: np.ndarray, forces: np.ndarray, period: float) -> np.ndarray:
    """States of y' = A y + B f with f held, by one matrix exponential; the last row of `matrix` is B's place."""
    step = expm(matrix * period)
    state, out = np.zeros(matrix.shape[0]), []
    for force in forces:
        state[-1] = force
        out.append(state[0])
        state = step @ state
    return np.array(out)


def test_every_effect_of_the_catalogue_has_an_example() -> None:
    assert set(EXAMPLES) == set(EVERY)


@pytest.mark.parametrize("name", sorted(EXAMPLES))
def test_the_two_routes_agree(name: str) -> None:
    run = paper_run(effects={name: EXAMPLES[name]})
    one, two = both(run)
    assert np.max(np.abs(one - two)) < 0.005 * COUNT
    plain = reference(paper_run())
    assert np.max(np.abs(one - plain)) > 20 * COUNT  # the effect is there at all


@pytest.mark.slow
@pytest.mark.parametrize(
    "pair",
    [
        ("coulomb_friction", "free_play"),
        ("stribeck_friction", "flexible_coupling"),
        ("asymmetric_friction", "actuator_lag"),
        ("coulomb_friction", "periodic_disturbance"),
        ("presliding_hysteresis", "end_stop"),
        ("load_proportional_friction", "viscoelastic_spring"),
        ("cogging", "coulomb_friction"),
        ("input_delay", "cubic_stiffness"),
        ("actuator_rate_limit", "coulomb_friction"),
        ("actuator_rate_limit", "actuator_lag"),
        ("power_damping", "coulomb_friction"),
    ],
)
def test_the_two_routes_agree_on_pairs(pair: tuple[str, str]) -> None:
    one, two = both(paper_run(effects={name: EXAMPLES[name] for name in pair}))
    assert np.max(np.abs(one - two)) < 0.01 * COUNT


def test_a_slip_shorter_than_a_solver_step_is_seen() -> None:
    shaken = {
        "coulomb_friction": {"level": 0.32809940510882724},
        "periodic_disturbance": {"amplitude": 1.7008446305643627, "frequency": 10.346500784731035},
    }
    for phase in (0.0, 4.5):
        one, two = both(paper_run(effects=shaken, mass=5.77, stiffness=652.5, phase=float(phase)))
        assert np.max(np.abs(one - two)) < 0.01 * COUNT


@pytest.mark.slow
def test_a_mode_begins_past_its_edge() -> None:
    # an edge located a rounding too early ended the new mode where it began, again and again
    (campaign, truth), number = sets.one("pairs", 233), 6
    experiment = campaign.experiments[number]
    gap, level = truth["parameters"]["free_play.gap"], truth["parameters"]["coulomb_friction.level"]
    run = Run(
        mass=truth["base_mass"] + experiment.added_mass,
        stiffness=truth["stiffness"][experiment.spring],
        damping=truth["damping"][experiment.damper],
        gain=truth["force_gain"],
        sample_time=float(experiment.time[1]),
        inputs=np.asarray(experiment.input),
        effects={"coulomb_friction": {"level": level}, "free_play": {"gap": gap}},
        position=truth["starts"][number],
    )
    assert np.max(np.abs(reference(run) - truth["exact"][number])) < 0.01 * COUNT


@pytest.mark.slow
def test_company_does_not_change_a_run() -> None:
    short = np.repeat([0.0, 0.5, 0.0], [3, 60, 60])
    chosen = [n for n in EFFECTS if n != "stribeck_friction"]
    runs = [paper_run(effects={n: EXAMPLES[n]}, mass=1 + 0.1 * i, inputs=short) for i, n in enumerate(chosen)]
    for run, together in zip(runs, fast(runs), strict=True):
        np.testing.assert_allclose(fast([run])[0], together, atol=1e-4 * COUNT)


@pytest.mark.parametrize("damping", [0.0, 6.0, 2 * math.sqrt(216 * 1.45), 60.0])
def test_linear_step_in_every_regime(damping: float) -> None:
    run = paper_run(damping=damping)
    forces = 7.8 * np.asarray(run.inputs)
    matrix = np.array([[0, 1, 0], [-216 / 1.45, -damping / 1.45, 1 / 1.45], [0, 0, 0.0]])
    for x in both(run):
        assert np.max(np.abs(x - held_linear(matrix, forces, T))) < 0.002 * COUNT


@pytest.mark.parametrize("level", [0.05, 0.3])
def test_coulomb_friction_takes_four_levels_over_stiffness_a_cycle(level: float) -> None:
    mass, stiffness = 1.2, 216.0
    period = 2 * math.pi * math.sqrt(mass / stiffness)
    run = Run(
        mass, stiffness, 0.0, 7.8, period / 100, np.zeros(2001), {"coulomb_friction": {"level": level}}, position=0.02
    )
    for x in both(run):
        cycles = 0.02 - 4 * level / stiffness * np.arange(20)
        cycles = cycles[cycles > 4 * level / stiffness]
        np.testing.assert_allclose(x[:2000:100][: cycles.size], cycles, atol=0.005 * COUNT)
        # dead stop where the spring no longer beats the friction: half-cycles lose 2 F/k each
        halves = math.ceil((0.02 - level / stiffness) / (2 * level / stiffness))
        stop = (0.02 - 2 * level / stiffness * halves) * (-1) ** halves
        if halves * 50 < 2000:
            np.testing.assert_allclose(x[halves * 50 + 60 :], stop, atol=0.005 * COUNT)


@pytest.mark.parametrize("cubic", [4e5, -1e5])
def test_duffing_period(cubic: float) -> None:
    mass, stiffness, amplitude = 1.2, 216.0, 0.018
    omega2 = (stiffness + cubic * amplitude**2) / mass
    m = cubic * amplitude**2 / (2 * (stiffness + cubic * amplitude**2))
    period = 4 * ellipk(m) / math.sqrt(omega2)
    run = Run(
        mass,
        stiffness,
        0.0,
        7.8,
        period / 50,
        np.zeros(501),
        {"cubic_stiffness": {"coefficient": cubic}},
        position=amplitude,
    )
    for x in both(run):
        np.testing.assert_allclose(x[::50], amplitude, atol=0.01 * COUNT)
        np.testing.assert_allclose(x[25::50], -amplitude, atol=0.01 * COUNT)


def test_free_play_swing_has_its_closed_period() -> None:
    mass, stiffness, gap, amplitude = 1.2, 216.0, 0.002, 0.01
    omega = math.sqrt(stiffness / mass)
    period = 2 * math.pi / omega + 4 * gap / (omega * (amplitude - gap))
    run = Run(mass, stiffness, 0.0, 7.8, period / 40, np.zeros(401), {"free_play": {"gap": gap}}, position=amplitude)
    for x in both(run):
        np.testing.assert_allclose(x[::40], amplitude, atol=0.005 * COUNT)


def test_end_stop_swing_has_its_closed_period() -> None:
    mass, stiffness, stop, extra, amplitude = 1.2, 216.0, 0.005, 3000.0, 0.012
    energy = stiffness * amplitude**2 / 2  # released from the free side; turns beyond the stop
    free = math.sqrt(stiffness / mass)
    # from −amplitude to the stop, then a swing of the stiffer spring about its own equilibrium
    time = math.acos(-stop / amplitude) / free
    stiff = stiffness + extra
    center = extra * stop / stiff
    fast_rate = math.sqrt(stiff / mass)
    speed = math.sqrt(2 * (energy - stiffness * stop**2 / 2) / mass)
    time += math.atan2(speed / fast_rate, stop - center) / fast_rate
    run = Run(
        mass,
        stiffness,
        0.0,
        7.8,
        2 * time / 60,
        np.zeros(301),
        {"end_stop": {"stiffness": extra, "position": stop}},
        position=-amplitude,
    )
    for x in both(run):
        np.testing.assert_allclose(x[::60], -amplitude, atol=0.01 * COUNT)


def test_quadratic_damping_takes_its_closed_share_of_a_half_swing() -> None:
    # while v < 0: d(v²)/dx − s v² = −2 k x/m with s = 2 c₂/m, so (1 + s x) exp(−s x) is the same at both turning points
    mass, c2, start = 1.2, 30.0, 0.02
    s = 2 * c2 / mass
    level = (1 + s * start) * math.exp(-s * start)
    low = brentq(lambda x: (1 + s * x) * math.exp(-s * x) - level, -start, -1e-6, xtol=1e-15)
    run = Run(mass, 216.0, 0.0, 7.8, 1e-4, np.zeros(2600), {"quadratic_damping": {"coefficient": c2}}, position=start)
    for x in both(run):
        assert float(np.min(x)) == pytest.approx(low, abs=3e-9)  # the sample nearest the turning point


def test_viscoelastic_and_coupled_masses_are_linear_systems() -> None:
    run = paper_run(effects={"viscoelastic_spring": EXAMPLES["viscoelastic_spring"]})
    forces, m = 7.8 * np.asarray(run.inputs), 1.45
    three = np.array([[0, 1, 0, 0], [-276 / m, -6 / m, 60 / m, 1 / m], [10, 0, -10, 0], [0, 0, 0, 0.0]])
    for x in both(run):
        assert np.max(np.abs(x - held_linear(three, forces, T))) < 0.002 * COUNT
    run = paper_run(effects={"flexible_coupling": EXAMPLES["flexible_coupling"]})
    four = np.zeros((5, 5))
    four[0, 1] = four[2, 3] = 1
    four[1] = [-1016 / m, -6.8 / m, 800 / m, 0.8 / m, 1 / m]
    four[3, :4] = [3200, 3.2, -3200, -3.2]
    for x in both(run):
        assert np.max(np.abs(x - held_linear(four, forces, T))) < 0.002 * COUNT


def test_lag_is_a_first_order_filter_and_delay_a_shift() -> None:
    m = 1.45
    run = paper_run(effects={"actuator_lag": {"time_constant": 0.01}})
    lagged = np.array([[0, 1, 0, 0], [-216 / m, -6 / m, 1 / m, 0], [0, 0, -100, 100], [0, 0, 0, 0.0]])
    for x in both(run):
        assert np.max(np.abs(x - held_linear(lagged, 7.8 * np.asarray(run.inputs), T))) < 0.005 * COUNT
    plain = reference(paper_run())
    for x in both(paper_run(effects={"input_delay": {"delay": 2 * T}})):
        assert np.max(np.abs(x[2:] - plain[:-2])) < 0.002 * COUNT
    # a delay of two and a half samples: compare with a record of half the sample time
    fine = reference(paper_run(sample_time=T / 2, inputs=np.repeat(paper_run().inputs, 2)))
    for x in both(paper_run(effects={"input_delay": {"delay": 2.5 * T}})):
        assert np.max(np.abs(x[3:] - fine[1:-5:2])) < 0.002 * COUNT


def test_presliding_is_a_spring_when_small_and_friction_when_large() -> None:
    level, distance = 0.25, 1.5e-4
    small = Run(
        1.2, 216.0, 0.0, 1.0, 1e-3, np.zeros(2), {"presliding_hysteresis": {"level": level, "distance": distance}}
    )
    small = replace(small, inputs=np.full(60, 1e-4))
    stiff = 216 + level / distance
    t = 1e-3 * np.arange(20)
    for x in both(small):
        expected = 1e-4 / stiff * (1 - np.cos(np.sqrt(stiff / 1.2) * t))
        np.testing.assert_allclose(x[:20], expected, atol=2e-3 * 1e-4 / stiff)
    coulomb = reference(paper_run(effects={"coulomb_friction": {"level": level}}))
    gaps = [
        float(
            np.sqrt(
                np.mean(
                    (reference(paper_run(effects={"presliding_hysteresis": {"level": level, "distance": d}})) - coulomb)
                    ** 2
                )
            )
        )
        for d in (4e-4, 1e-4, 2.5e-5)
    ]
    assert gaps[0] > gaps[1] > gaps[2]


def test_sticks_until_the_net_force_leaves_the_band() -> None:
    force = np.concatenate([np.full(50, 0.2), np.full(50, 0.38), np.full(50, 0.42)])
    run = Run(
        1.2, 216.0, 3.0, 1.0, T, force, {"stribeck_friction": {"level": 0.2, "breakaway": 0.4, "velocity": 0.006}}
    )
    for x in both(run):
        assert np.all(x[:101] == 0)
        assert x[104] > 0
    run = replace(run, effects={"asymmetric_friction": {"level_forward": 0.5, "level_backward": 0.1}}, inputs=-force)
    for x in both(run):
        assert np.all(x[2:] < 0)
    for x in both(replace(run, inputs=force)):
        assert np.all(x == 0)


def test_energy_of_a_free_swing_with_stiffness_effects_is_kept() -> None:
    effects = {n: EXAMPLES[n] for n in ("cubic_stiffness", "quadratic_stiffness", "free_play", "end_stop", "cogging")}
    run = Run(1.2, 216.0, 0.0, 7.8, 1e-3, np.zeros(1500), effects, position=0.021)
    x = reference(run)
    pull = np.array([run.static(float(p)) for p in np.linspace(-0.03, 0.03, 20001)])
    potential = -cumulative_trapezoid(pull, dx=0.06 / 20000, initial=0)
    height = np.interp(x, np.linspace(-0.03, 0.03, 20001), potential)
    assert np.max(height) == pytest.approx(height[0], abs=1e-7)
    np.testing.assert_allclose(fast([run])[0], x, atol=0.05 * COUNT)
