"""Laws of effects from outside: which are refused and how, and that no law runs another one's machine code."""

from __future__ import annotations

import os
import subprocess
import sys
import types
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest

import stepid
from exact_plants import exact_campaign, true_model
from stepid.effects import CATALOGUE, Effect, Moment, Parameter, Scales
from stepid.effects.base import Values
from stepid.errors import InputError
from stepid.simulation.compiled import JIT
from stepid.simulation.fingerprint import fingerprint
from stepid.simulation.laws import law

POWER = 3.0
SHORT = ((0.0, 0.5), (0.5, 0.5), (1.5, -0.5))


class Own(Effect):
    """Damping by a power of the speed that stands beside the class."""

    name = "own_damping"
    parameters = (Parameter("coefficient", "N·s³/m³"),)

    def starts(self, scales: Scales) -> list[tuple[float, ...]]:
        return [(0.3 * scales.damping / scales.velocity**2,)]

    @staticmethod
    def force(p: Values, m: Moment) -> float:
        return -p[0] * np.sign(m.v) * abs(m.v) ** POWER


class Inheriting(Own):
    name = "inheriting"


def simulated(effect: Effect, value: float = 300.0) -> np.ndarray:
    campaign = exact_campaign({}, SHORT[:1])
    model = true_model(campaign, effect.name, {effect.parameters[0].name: value})
    return stepid.simulate(model, campaign, catalogue=(*CATALOGUE, effect))["case 1"]


def of_old(method: str) -> type[Effect]:
    def old(self: Effect, p: tuple[np.ndarray, ...], m: object) -> object:
        return 0.0 * p[0]

    return type("Old", (Own,), {"name": "old", method: old})


METHODS = ("force", "friction", "breakaway", "switches", "rates", "at_rest", "remember", "memory_slopes")
METHODS += ("drive", "delay", "reading", "relax", "kink")


@pytest.mark.parametrize("method", METHODS)
def test_an_effect_of_0_1_is_refused_by_its_method(method: str) -> None:
    words = rf"'old' is written as for stepid 0\.1: its method '{method}' is no static method"
    with pytest.raises(InputError, match=rf"{words}.*@staticmethod, def {method}\(.*own-effect.md"):
        simulated(of_old(method)())


def test_a_method_pieces_of_0_1_is_ignored() -> None:
    kind = type("Pieces", (Own,), {"name": "with_pieces", "pieces": lambda self, p, h: 3})
    np.testing.assert_array_equal(simulated(kind()), simulated(Own()))


def test_an_old_effect_is_refused_by_fit_and_export() -> None:
    effect = of_old("force")()
    campaign = exact_campaign({}, SHORT)
    with pytest.raises(InputError, match=r"written as for stepid 0\.1"):
        stepid.fit(campaign, effects=(effect,))
    model = true_model(campaign, "old", {"coefficient": 1.0})
    with pytest.raises(InputError, match=r"written as for stepid 0\.1"):
        stepid.nonlinear_system(model, campaign["case 1"], catalogue=(effect,))


def test_switches_that_are_announced_must_be_there() -> None:
    class Silent(Own):
        name = "silent"
        n_switches: ClassVar[int] = 2

    with pytest.raises(InputError, match=r"'silent' has n_switches = 2 and no method 'switches'.*a tuple of 2"):
        simulated(Silent())


@pytest.mark.skipif(not JIT, reason="nothing is compiled")
def test_an_effect_that_cannot_be_compiled_is_refused_by_its_method() -> None:
    class Unheard(Own):
        name = "unheard"
        n_extra: ClassVar[int] = 1

        @staticmethod
        def rates(p: Values, m: Moment) -> tuple[float, ...]:
            return (float(sorted(open(str(p)))[0]),)

    with pytest.raises(InputError, match=r"'unheard' cannot be compiled: its method 'rates' \(.+\)\. Write"):
        simulated(Unheard())


@pytest.mark.skipif(not JIT, reason="nothing is compiled")
def test_too_few_numbers_are_refused() -> None:
    class Short(Own):
        name = "short"
        n_extra: ClassVar[int] = 2

        @staticmethod
        def rates(p: Values, m: Moment) -> tuple[float, ...]:
            return (0.0,)

    with pytest.raises(InputError, match="'short' cannot be compiled: its method 'rates'"):
        simulated(Short())


def test_more_than_a_simulation_holds_is_refused() -> None:
    many = tuple(type("Many", (Own,), {"name": f"many_{i}"})() for i in range(9))
    with pytest.raises(InputError, match=r"9 effects are more than a simulation holds \(8\)"):
        stepid.fit(exact_campaign({}, SHORT), effects=many)


@pytest.mark.parametrize("kind", [Own, Inheriting])
def test_an_effect_from_outside_is_simulated_and_fitted(kind: type[Effect]) -> None:
    plain = exact_campaign({}, SHORT)
    moved = stepid.simulate(true_model(plain, kind.name, {"coefficient": 300.0}), plain, catalogue=(kind(),))
    rng = np.random.default_rng(4)
    runs = [
        run.model_copy(update={"position": moved[run.name] + 1e-5 * rng.standard_normal(run.time.size)})
        for run in plain.experiments
    ]
    found = stepid.fit(stepid.Campaign(name="own", experiments=tuple(runs)), effects=(kind(),))
    estimate = found.parameters[f"{kind.name}.coefficient"]
    assert estimate.value == pytest.approx(300.0, abs=4 * (estimate.uncertainty or 0.0))
    assert found.rms == pytest.approx(1e-5, rel=0.1)


class OneWay(Effect):
    """A damper of one way: linear between reversals, its slope another after each."""

    name = "one_way"
    parameters = (Parameter("coefficient", "N·s/m"),)
    reverses = True

    @staticmethod
    def force(p: Values, m: Moment) -> float:
        return -p[0] * m.v if m.sign > 0 else 0.0


class OneWayInLeaps(OneWay):
    name = "one_way_in_leaps"
    affine = True


def test_an_affine_law_whose_slope_turns_with_the_motion_is_simulated_as_any_other() -> None:
    plain, affine = simulated(OneWay(), 5.0), simulated(OneWayInLeaps(), 5.0)
    assert np.ptp(plain - simulated(OneWay(), 0.0)) > 1e-3
    assert affine == pytest.approx(plain, abs=1e-9)


def test_two_classes_of_one_name_have_laws_of_their_own() -> None:
    def kind(factor: float) -> Effect:
        def force(p: Values, m: Moment) -> float:
            return -factor * p[0] * m.v * m.v * m.v

        return type("Twin", (Own,), {"name": "twin", "force": staticmethod(force)})()

    one, two, again = kind(1.0), kind(2.0), kind(1.0)
    if JIT:
        assert law(one) == law(again) != law(two)
    np.testing.assert_allclose(simulated(one, 600.0), simulated(two), rtol=1e-9)
    assert np.abs(simulated(one) - simulated(two)).max() > 1e-6


def test_a_law_that_is_changed_in_its_class_is_the_one_that_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    before = simulated(Own())
    monkeypatch.setitem(globals(), "POWER", 2.0)
    changed = simulated(Own())
    assert np.abs(changed - before).max() > 1e-4
    monkeypatch.setattr(Own, "force", staticmethod(lambda p, m: -p[0] * m.v))
    assert np.abs(simulated(Own()) - changed).max() > 1e-4
    monkeypatch.undo()
    np.testing.assert_array_equal(simulated(Own()), before)


def test_the_fingerprint_follows_what_a_law_names() -> None:
    numbers = types.ModuleType("numbers_of_mine")
    numbers.level, numbers.table = 1.0, np.zeros(2000)  # type: ignore[attr-defined]
    space = {"numbers": numbers, "np": np, "own": 2.0}
    exec("def helper(x):\n    return own * x", space)
    text = "def law(p, m):\n    return numbers.level * helper(np.sign(m)) + numbers.table[0]"
    exec(text, space)
    seen = {fingerprint(space["law"])}  # type: ignore[arg-type]

    def new() -> bool:
        before = len(seen)
        seen.add(fingerprint(space["law"]))  # type: ignore[arg-type]
        return len(seen) > before

    assert not new()
    numbers.level = 2.0  # type: ignore[attr-defined]
    assert new()
    numbers.table[1000] = 1.0  # type: ignore[attr-defined]
    assert new()
    space["own"] = 3.0
    assert new()
    exec("def helper(x):\n    return own + x", space)
    assert new()
    space["unused"] = 1.0
    assert not new()


MINE = """
from stepid.effects import Effect, Parameter

class Mine(Effect):
    name = "mine"
    parameters = (Parameter("coefficient", "N·s/m"),)

    @staticmethod
    def force(p, m):
        return -{factor} * p[0] * m.v
"""
IMPORTED = "from {module} import Mine"
EXECUTED = """
import importlib.util
spec = importlib.util.spec_from_file_location("no_file_of_mine", "{path}")
spec.loader.exec_module(module := importlib.util.module_from_spec(spec))
Mine = module.Mine
"""
SCRIPT = """
import stepid
{given}
from exact_plants import exact_campaign, true_model

campaign = exact_campaign({{}}, ((0.0, 0.5),))
model = true_model(campaign, "mine", {{"coefficient": 1.0}})
print(repr(float(stepid.simulate(model, campaign, catalogue=(Mine(),))["case 1"][60])))
"""


def asked(folder: Path, given: str) -> str:
    """What a process of its own simulates with a class from outside; machine code is kept in the folder."""
    paths = [str(folder), str(Path(__file__).parents[1]), str(Path(stepid.__file__).parents[1])]
    keep = {"NUMBA_CACHE_DIR": str(folder / "kept"), "PYTHONPATH": os.pathsep.join(paths)}
    command = [sys.executable, "-B", "-c", SCRIPT.format(given=given)]
    done = subprocess.run(command, env={**os.environ, **keep}, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.slow
@pytest.mark.skipif(not JIT, reason="nothing is compiled")
def test_an_edited_file_never_runs_its_old_machine_code(tmp_path: Path) -> None:
    def ask(factor: str) -> str:
        (tmp_path / "mine.py").write_text(MINE.format(factor=factor), encoding="utf-8")
        os.utime(tmp_path / "mine.py", (1e9, 1e9))  # a clock that does not tell the edit
        return asked(tmp_path, IMPORTED.format(module="mine"))

    def kept() -> int:
        return len(list((tmp_path / "kept" / "stepid").glob("mine_*.py")))

    first = ask("1.0")
    assert kept() == 1
    assert ask("3.0") != first
    assert kept() == 2
    assert ask("1.0") == first
    assert kept() == 2


@pytest.mark.slow
@pytest.mark.skipif(not JIT, reason="nothing is compiled")
def test_a_law_outlives_the_module_that_it_was_compiled_in(tmp_path: Path) -> None:
    path = tmp_path / "mine.py"
    path.write_text(MINE.format(factor="1.0"), encoding="utf-8")
    first = asked(tmp_path, IMPORTED.format(module="mine"))
    path = path.rename(tmp_path / "renamed.py")
    assert asked(tmp_path, IMPORTED.format(module="renamed")) == first
    for _ in range(2):  # compiled, then kept
        assert asked(tmp_path, EXECUTED.format(path=path.as_posix())) == first
