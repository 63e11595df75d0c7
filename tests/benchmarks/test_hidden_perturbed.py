"""Perturbed campaigns: the draws repeat, each kind changes the record as it says, and what is held back stays so."""

from __future__ import annotations

import ast
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import hidden
import stepid
from hidden import Run, changes, fast, laws, outside, perturb, reference
from hidden.campaigns import Request, make_campaigns
from hidden.draw import Setup, draw_setup
from hidden.sets import SETS, one, requests, seed_of

SIMULATOR = (
    *("changes", "compiled", "draw", "drive", "equations", "fast", "law_draws", "laws", "linear_fit"),
    *("outside", "perturb", "perturbed", "plant", "reference", "steps"),
)
T = 0.0088542


@pytest.fixture
def setup() -> Setup:
    return draw_setup(np.random.default_rng(3), "five")


def plain(setup: Setup, **changed: object) -> Run:
    slot = setup.slots[0]
    run = Run(
        setup.base_mass,
        setup.stiffness["medium"],
        setup.damping["half"],
        setup.gain,
        setup.sample_time,
        slot.inputs,
    )
    return replace(run, **changed)


def changed(kind: str, sizes: dict[str, float], off: float, run: Run, setup: Setup) -> np.ndarray:
    own = np.random.default_rng(1)
    x = fast([perturb.on_run(kind, sizes, off, run, setup, own)])[0]
    return perturb.on_reading(kind, sizes, off, x, setup, 1e-5, np.random.default_rng(2))


@pytest.mark.parametrize("name", SIMULATOR)
def test_the_simulator_imports_nothing_of_the_package(name: str) -> None:
    text = (Path(hidden.__file__).parent / f"{name}.py").read_text(encoding="utf-8")
    found = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            found |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and not node.level:
            found.add(str(node.module).split(".")[0])
    assert "stepid" not in found


def test_at_most_a_third_may_be_looked_at() -> None:
    assert set(perturb.SEEN) <= set(perturb.KINDS)
    assert 3 * len(perturb.SEEN) <= len(perturb.KINDS)
    assert 3 * len(outside.SEEN_OUTSIDE) <= len(outside.EVERY_OUTSIDE)
    assert len(laws.NEW_LAWS) >= 15
    assert not set(outside.NEW_OUTSIDE) & set(outside.SEEN_OUTSIDE)
    assert not set(outside.EVERY_OUTSIDE) & set(hidden.EVERY)


def test_sets_for_development_draw_only_what_may_be_seen() -> None:
    for which in ("perturbed-none-seen", "perturbed-single-seen", "perturbed-outside-seen"):
        assert {k for r in requests(which, 200, salt="any") for k in r.perturb} == set(perturb.SEEN)
    assert {r.outside for r in requests("perturbed-outside-seen", 60)} == set(outside.SEEN_OUTSIDE)
    assert {r.outside for r in requests("outside-seen", 60)} == set(outside.SEEN_OUTSIDE)
    assert {r.outside for r in requests("outside-new", 60)} == set(outside.NEW_OUTSIDE)
    assert {r.outside for r in requests("outside-all", 60)} == set(outside.EVERY_OUTSIDE)
    assert {k for r in requests("perturbed-single", 300, salt="any") for k in r.perturb} == set(perturb.KINDS)


def test_kinds_go_with_what_else_is_hidden() -> None:
    for which in ("perturbed-none", "perturbed-single", "perturbed-outside"):
        for r in requests(which, 300, salt="another"):
            assert 1 <= len(set(r.perturb)) == len(r.perturb) <= 2
            assert all(perturb.possible(k, r.effects, r.outside) for k in r.perturb)
            if set(r.perturb) & set(perturb.HOLDS):
                assert r.kind == "release"
            if set(r.perturb) & set(perturb.DRIVEN):
                assert r.kind != "release"


def test_sets_cover_the_whole_catalogue() -> None:
    for which, count in (("single-all", 1), ("pairs-all", 2), ("triples", 3)):
        wanted = requests(which, 150, salt="any")
        assert {len(set(r.effects)) for r in wanted} == {count}
        assert {e for r in wanted for e in r.effects} == set(hidden.EVERY)
    with pytest.raises(KeyError):
        requests("no such set", 1)


def test_seeds_come_from_salt_set_and_number() -> None:
    assert seed_of("triples", 4, "a") == 179697863047191
    assert len({seed_of(which, i, salt) for which in SETS for i in range(5) for salt in "ab"}) == len(SETS) * 10
    assert seed_of("none", 3) == 40_003  # the standing campaigns stay what they are
    assert requests("triples", 1, skip=4, salt="a") == requests("triples", 5, salt="a")[4:]


def test_a_perturbed_campaign_repeats() -> None:
    first, truth = one("perturbed-none-seen", 1, "a")
    again, same = one("perturbed-none-seen", 1, "a")
    assert first == again
    assert truth["perturbations"] == same["perturbations"]
    assert first != one("perturbed-none-seen", 1, "b")[0]


@pytest.mark.parametrize("samples", [0.3, 1.0, 1.7, -0.6, -2.0])
def test_start_time_shifts_the_response(setup: Setup, samples: float) -> None:
    u = np.repeat([0.0, 1.0], [5, 150])
    x = fast([plain(setup, inputs=u)])[0]
    shifted = changed("start_time", {"samples": 1.0}, samples, plain(setup, inputs=u), setup)
    at = np.arange(10, 140)
    expected = np.interp(at - samples, np.arange(x.size), x)
    np.testing.assert_allclose(shifted[at], expected, atol=0.004 * np.max(np.abs(x)))
    assert np.max(np.abs(shifted - x)) > 0.01 * np.max(np.abs(x))


def test_gain_damping_and_friction_scale(setup: Setup) -> None:
    run = plain(setup)
    x = fast([run])[0]
    np.testing.assert_allclose(changed("gain", {}, 0.05, run, setup), 1.05 * x, atol=1e-12)
    own = np.random.default_rng(0)
    assert perturb.on_run("damping", {}, -0.04, run, setup, own).damping == pytest.approx(0.96 * run.damping)
    rubbing = replace(run, effects={"stribeck_friction": {"level": 1.0, "breakaway": 2.0, "velocity": 0.01}})
    found = perturb.on_run("friction", {}, 0.03, rubbing, setup, own).effects["stribeck_friction"]
    assert found == {"level": pytest.approx(1.03), "breakaway": pytest.approx(2.06), "velocity": 0.01}


@pytest.mark.parametrize("when", [0, 1, 2])
def test_rest_moves_by_its_share(setup: Setup, when: int) -> None:
    u = np.repeat([0.0, setup.volts, 0.0], [5, 400, 600])
    run = plain(setup, inputs=u, damping=3 * setup.damping["half"])
    off = changed("rest", {"scatter": 0.02, "when": float(when)}, 0.02, run, setup) - fast([run])[0]
    assert off[-1] == pytest.approx(0.02 * setup.reach, rel=0.01)
    assert off[4] == pytest.approx(0.02 * setup.reach if when == 0 else 0.0, abs=1e-9)


def test_noises_have_their_size_and_color() -> None:
    rng = np.random.default_rng(0)
    slow = changes.colored(20_000, 0.001, 0.01, rng)
    assert np.std(slow) == pytest.approx(1.0, abs=0.1)
    assert np.mean(slow[1:] * slow[:-1]) == pytest.approx(np.exp(-0.1), abs=0.1)
    power = np.abs(np.fft.rfft(changes.pink(8192, rng))) ** 2
    assert power[4:32].mean() / power[400:3200].mean() == pytest.approx(100, rel=0.7)
    line = np.abs(np.fft.rfft(changes.hum(1000, 0.001, 50.0, 0.3)))
    assert np.argmax(line) == 50


def test_samples_are_wrong_alone_and_missing_where_nothing_switches() -> None:
    rng = np.random.default_rng(0)
    off = changes.wrong(400, 0.02, 5.0, 9.0, rng)
    at = np.flatnonzero(off)
    assert at.size == 8
    assert np.diff(at).min() > 1
    assert (np.abs(off[at]) >= 5).all()
    u = np.repeat([0.0, 1.0, 0.0], [5, 200, 200])
    gone = changes.lost(u, 0.05, 4, rng)
    assert 0.03 < gone.mean() < 0.08
    assert not gone[[0, 4, 5, 6, 204, 205, 206, 404]].any()
    x = np.arange(405.0)
    kept = changes.repeated(x, gone)
    assert (kept[gone] < x[gone]).all()
    assert (kept[~gone] == x[~gone]).all()


def test_eccentricity_is_a_wave_over_position(setup: Setup) -> None:
    x = np.linspace(0, setup.reach, 200)
    off = changes.eccentric(x, 1e-5, setup.reach / 2, 0.7) - x
    assert off[0] == 0
    assert off[100] == pytest.approx(off[0], abs=1e-6)
    assert np.ptp(off) == pytest.approx(2e-5, rel=0.01)


@pytest.mark.parametrize(("kind", "held"), [("hold_short", 3.4), ("hold_long", 60.0)])
def test_a_hand_holds_before_it_lets_go(setup: Setup, kind: str, held: float) -> None:
    run = plain(setup, inputs=np.zeros(300), position=0.01)
    sizes = {"push": 0.0, "tremble": 0.001 if kind == "hold_long" else 0.0}
    x = changed(kind, sizes, held, run, setup)
    still = int(held)
    np.testing.assert_allclose(x[: still + 1], 0.01, atol=1.1e-5 if kind == "hold_long" else 1e-12)
    free = fast([run])[0]
    np.testing.assert_allclose(x[70:], np.interp(np.arange(70, 300) - held, np.arange(300), free), atol=4e-5)


@pytest.mark.parametrize("kind", ["second_mode", "creep"])
def test_faint_modes_are_their_own_twins(setup: Setup, kind: str) -> None:
    sizes = perturb.draw(kind, np.random.default_rng(4), setup)
    run = perturb.on_run(kind, sizes, 0.0, plain(setup), setup, np.random.default_rng(1))
    assert set(run.effects) == {perturb.TWINS[kind]}
    assert perturb.TWINS[kind] in hidden.NAMES
    assert not perturb.possible(kind, (perturb.TWINS[kind],), None)
    off = np.max(np.abs(fast([run])[0] - fast([plain(setup)])[0]))
    assert 1e-4 < off / setup.reach < 0.2


def test_the_cost_is_what_a_linear_fit_leaves() -> None:
    made = make_campaigns([Request(77, perturb=("gain", "ar1"), kind="five")])
    campaign, truth = made[0]
    assert isinstance(campaign, stepid.Campaign)
    assert truth["r0_perturbation"] == pytest.approx(truth["r0"], rel=0.08)
    assert set(truth["r0_kinds"]) == {"gain", "ar1"}
    both = np.sqrt(1 + sum(r0**2 - 1 for r0 in truth["r0_kinds"].values()))
    assert both == pytest.approx(truth["r0_perturbation"], rel=0.1)
    assert len(truth["perturbations"]["gain"]["runs"]) == len(campaign.experiments)


def test_one_effect_takes_at_least_half_of_the_misfit() -> None:
    _, truth = make_campaigns([Request(77, ("cubic_stiffness",), None, 10.0, "five", ("gain",))])[0]
    assert truth["qualified"]
    assert truth["share"] >= 0.5
    assert 1.5 <= truth["r0"] <= 100


def test_missing_samples_keep_their_stamps_or_are_refused_in_words() -> None:
    for seed in range(20):
        campaign, truth = make_campaigns([Request(seed, perturb=("dropped",), kind="four")])[0]
        if not truth["perturbations"]["dropped"]["held"]:
            short = [e.time.size < len(x) for e, x in zip(campaign.experiments, truth["exact"], strict=True)]
            assert truth["refused"] or any(short)
            return
    pytest.fail("no campaign with real time stamps")


def law_run(setup: Setup, name: str) -> Run:
    common, own = np.random.default_rng(5), np.random.default_rng(6)
    return outside.apply_outside(name, plain(setup, inputs=setup.slots[0].inputs[:120]), setup, 1.0, common, own)


@pytest.mark.parametrize("name", laws.NEW_LAWS)
def test_a_law_moves_the_cart_and_leaves_it_where_it_rests(setup: Setup, name: str) -> None:
    run = law_run(setup, name)
    off = np.abs(fast([run])[0] - fast([plain(setup, inputs=run.inputs)])[0])
    assert 1e-4 < np.max(off) / setup.reach < 0.6
    if run.law is not None and name not in ("chirp", "pumped_spring"):
        assert run.law.force(0.0, 0.0, 0.0, np.zeros(2), 0.0) == 0.0


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=() if n == "memory_friction" else pytest.mark.slow) for n in laws.NEW_LAWS]
)
def test_the_two_routes_agree_on_laws(setup: Setup, name: str) -> None:
    run = law_run(setup, name)
    assert np.max(np.abs(reference(run) - fast([run])[0])) < 0.02 / 226600


def test_the_two_routes_agree_on_bristles_of_a_cart_that_starts_in_motion() -> None:
    rubbing = {"presliding_hysteresis": {"level": 0.05, "distance": 2e-4}}
    run = Run(1.2, 216.0, 3.0, 7.8, T, np.zeros(150), rubbing, position=0.015, velocity=0.01)
    np.testing.assert_allclose(fast([run])[0], reference(run), atol=0.002 / 226600)
