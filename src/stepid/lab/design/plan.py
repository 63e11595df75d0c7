"""Design before the lab: compare sets of runs by what they would determine, and advise the least that suffices."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from stepid.core.mass_offset import WEIGHT_UNCERTAINTY
from stepid.core.quantities import (
    CART,
    INPUT_UNITS,
    MOTIONS,
    InputUnit,
    Motion,
    Quantities,
    middle_dot,
    quantities_of,
)
from stepid.core.recorded import recorded
from stepid.core.takes import a, each, one_of, optional, takes
from stepid.effects import CATALOGUE, Effect, Scales, a_catalogue, resolve
from stepid.errors import InputError
from stepid.lab.design.arguments import Asked, checked, wants
from stepid.lab.design.candidate import LEAST, Design, Step, enumerate_designs
from stepid.lab.design.guess import Given, Guess, as_plant, lasting, parameter_values, reach, sized, typical
from stepid.lab.design.information import covariances, information, lay_out_steps, simulated
from stepid.lab.design.result import Plan
from stepid.lab.design.separation import Confusion, apart, confusions, expected
from stepid.simulation.model import EffectModel, PlantModel
from stepid.simulation.threads import single_threaded

_TRIED = 6  # designs whose separation is looked at by a full fit


_given = each(a((str, EffectModel), ""), 'names of effects, as ("coulomb_friction",), or stepid.EffectModel(…)')


@takes(
    effects=_given,
    separate=optional(_given),
    catalogue=a_catalogue,
    motion=optional(one_of(MOTIONS)),
    input_unit=optional(one_of(INPUT_UNITS, middle_dot)),
)
@recorded()
@single_threaded
def plan(
    plant: Guess,
    *,
    noise: float,
    masses: Iterable[float] = (0.0, 0.5, 1.0, 1.5, 2.0),
    levels: Iterable[float] = (0.5, -0.5, 0.25),
    sample_times: Iterable[float] = (0.002, 0.005, 0.01),
    runs: Iterable[int] = (2, 3, 4, 6, 8, 12),
    effects: Iterable[Given] = (),
    wanted: Mapping[str, float] | None = None,
    separate: Sequence[Given] | None = None,
    duration: float | None = None,
    travel: float | None = None,
    noise_time: float = 0.0,
    weight_uncertainty: float = WEIGHT_UNCERTAINTY,
    catalogue: tuple[Effect, ...] = CATALOGUE,
    motion: Motion | None = None,
    input_unit: InputUnit | None = None,
) -> Plan:
    """Say which runs a guessed plant needs: added masses, number, sample time, size and direction of the steps.

    Every combination of what the rig can do is compared by the Fisher information of the joint fit of all its runs,
    each run's rest position fitted, too. The advice is the design with the fewest runs, and among these the fewest
    samples, that gives what is wanted.

    Parameters
    ----------
    plant : PlantModel or mapping
        The guess: a model, for example that of a first fit, or ``base_mass`` [kg], ``stiffness`` [N/m], ``damping``
        [N·s/m] and ``force_gain`` [N/V] by name.
    noise : float
        m, standard deviation of the sensor's noise; an encoder's rounding adds 1/√12 of a count in squares.
    masses : iterable of float
        kg, what can be added to the cart.
    levels : iterable of float
        V, steps that the rig can make; a negative one is a step the other way.
    sample_times : iterable of float
        s.
    runs : iterable of int
        How many runs one would make.
    effects : iterable of str or EffectModel
        Effects that are there and will be fitted, too, beside those of `plant`; by name with their usual size.
    wanted : mapping, optional
        Parameter, named as in `stepid.fit` or by its first word, to the largest relative standard uncertainty: by
        default 0.02 (2 %) of ``base_mass``, ``stiffness`` and ``damping``.
    separate : two of str or EffectModel, optional
        A pair of effects that the runs are to tell apart. The second of them, or the one without a size, gets that at
        which a fit that lacks it leaves as much as one that lacks the other.
    duration : float, optional
        s, of each record; by default twice the settling time of the heaviest run.
    travel : float, optional
        m, how far the cart can go from rest; steps that would take it farther are left out.
    noise_time : float
        s, correlation time of the noise: sampling faster than that tells little more.
    weight_uncertainty : float
        kg, standard uncertainty of one 0.5 kg weight.
    catalogue : tuple of Effect
        Where names of effects are looked up.
    motion, input_unit : str, optional
        As of `stepid.Campaign`: what stands for kg, m, N and V here; by default as of the fit whose model is given.

    Returns
    -------
    Plan

    Raises
    ------
    stepid.errors.InputError
        If an argument is of the wrong kind or size, or leaves no design.
    stepid.errors.ConvergenceError
        If the guessed plant runs away.

    Notes
    -----
    Fisher information: Ljung, System Identification (1999), 7.4 and 13. The wrong effect's χ² is expected to be larger
    than the right one's by so much that noise leaves 10 of it in 95 of 100 campaigns.
    """
    said = quantities_of(plant) if motion is None and input_unit is None else CART
    own = Quantities(motion or said.motion, input_unit or said.input_unit)
    with own.spoken():
        guess = as_plant(plant)
        asked = checked(noise, masses, levels, sample_times, runs, duration, travel, noise_time, weight_uncertainty)
        possible = _within_travel(asked, guess)
        length = asked.duration or lasting(guess, max(asked.masses))
        often = _often_enough(asked.sample_times, length)
        scales = typical(guess, max(possible, key=abs), 0.0, min(often), length)
        added = [e for e in sized(effects, guess.effects, scales, catalogue) if e not in guess.effects]
        guess = guess.model_copy(update={"effects": (*guess.effects, *added)})
        there = resolve([e.name for e in guess.effects], catalogue=catalogue)
        wanting = wants(wanted, parameter_values(guess, there))
        designs = enumerate_designs(asked.masses, possible, often, asked.runs, length)
        designs = _predicted(designs, guess, there, asked)
        ways: list[Confusion] = []
        pair: tuple[EffectModel, ...] = ()
        if separate is not None:
            ways, pair = _ways(separate, guess, there, designs, scales, catalogue)
            designs = _separated(designs, ways, asked)
        found = Plan(
            plant=guess,
            noise=asked.noise,
            noise_time=asked.noise_time,
            weight_uncertainty=asked.weight_uncertainty,
            wanted=wanting,
            pair=pair,
            designs=tuple(designs),
            advised=0,
        )
        return own.result(_advised(found, ways, asked))


def _often_enough(sample_times: tuple[float, ...], length: float) -> tuple[float, ...]:
    """Sample times [s] of which a record of some length [s] has a few."""
    kept = tuple(time for time in sample_times if LEAST * time <= length)
    if not kept:
        raise InputError(
            f"sample_times: {min(sample_times):g} s leaves fewer than {LEAST} samples in records of {length:.3g} s",
            f"Give sample times of at most {length / LEAST:.2g} s, or a longer duration.",
        )
    return kept


def _within_travel(asked: Asked, guess: PlantModel) -> list[float]:
    heaviest = max(asked.masses)
    possible = [v for v in asked.levels if asked.travel is None or reach(guess, v, heaviest) <= asked.travel]
    if not possible:
        raise InputError(
            f"levels: every one takes the cart farther than {asked.travel:g} m", "Give smaller levels, or more travel."
        )
    return possible


def _every_step(designs: Sequence[Design]) -> list[Step]:
    return list(dict.fromkeys(step for design in designs for step in design.steps))


def _predicted(designs: Sequence[Design], guess: PlantModel, effects: tuple[Effect, ...], asked: Asked) -> list[Design]:
    """The designs with the standard uncertainties that they would give."""
    steps, length = _every_step(designs), designs[0].duration
    point = simulated(guess, effects, lay_out_steps(steps, guess, length))
    known = dict(zip(steps, information(point), strict=True))
    names = list(parameter_values(guess, effects))
    out = []
    for design in designs:
        noise, weights, open_ = covariances(
            design.steps,
            known,
            variance=asked.variance(design.sample_time),
            weight_uncertainty=asked.weight_uncertainty,
        )
        parts = {"uncertainty": noise + weights, "from_noise": noise, "from_weights": weights}
        told = {
            part: {n: None if o else float(v) for n, o, v in zip(names, open_, np.sqrt(np.diag(square)), strict=True)}
            for part, square in parts.items()
        }
        out.append(design.model_copy(update=told))
    return out


def _pair(given: Sequence[Given], catalogue: tuple[Effect, ...]) -> tuple[Effect, ...]:
    items = [given] if isinstance(given, (str, EffectModel)) else list(given)
    pair = resolve([e.name if isinstance(e, EffectModel) else e for e in items], catalogue=catalogue)
    if len(pair) != 2:
        raise InputError(
            f"separate: needs two effects, not {len(pair)}",
            'Give for example ("coulomb_friction", "quadratic_damping").',
        )
    return pair


def _ways(
    separate: Sequence[Given],
    guess: PlantModel,
    there: tuple[Effect, ...],
    designs: Sequence[Design],
    scales: Scales,
    catalogue: tuple[Effect, ...],
) -> tuple[list[Confusion], tuple[EffectModel, EffectModel]]:
    """Both ways to take one effect of the pair for the other, looked for at the slowest sample time."""
    pair = _pair(separate, catalogue)
    given = dict(zip((e.name for e in pair), separate, strict=True))
    own = {m.name: m for m in guess.effects}
    sizes = {name: own.get(name) if isinstance(item, str) else item for name, item in given.items()}
    one, two = sorted(pair, key=lambda effect: sizes[effect.name] is None)  # stable: the first stays first
    (first,) = sized([sizes[one.name] or one.name], (), scales, catalogue)
    names = {one.name, two.name}
    bare = guess.model_copy(update={"effects": tuple(m for m in guess.effects if m.name not in names)})
    others = tuple(e for e in there if e.name not in names)
    slow = max(design.sample_time for design in designs)
    steps = [step for step in _every_step(designs) if step.sample_time == slow]
    return confusions(bare, ((one, first), (two, sizes[two.name])), others, steps, designs[0].duration, scales)


def _separated(designs: Sequence[Design], ways: Sequence[Confusion], asked: Asked) -> list[Design]:
    """The designs with the χ² that the wrong effect would leave, to first order."""
    steps, length = _every_step(designs), designs[0].duration
    tables = [way.by_step(steps, length) for way in ways]
    out = []
    for design in designs:
        out.append(_told(design, ways, [expected(design.steps, table) for table in tables], asked))
    return out


def _told(design: Design, ways: Sequence[Confusion], left: Sequence[float], asked: Asked) -> Design:
    least, misfit = apart(ways, left, variance=asked.variance(design.sample_time), design=design)
    return design.model_copy(update={"separation": least, "misfit": misfit})


def _advised(found: Plan, ways: Sequence[Confusion], asked: Asked) -> Plan:
    """The plan with its advice: the least design that suffices, its separation looked at by a full fit."""
    designs = list(found.designs)

    def first(i: int) -> tuple[float, ...]:
        return designs[i].runs, designs[i].samples, found.shortfall(designs[i])

    order = sorted(range(len(designs)), key=first)
    tried = 0
    for i in order:
        if found.shortfall(designs[i]) > 1:
            continue
        if ways:
            if tried == _TRIED:
                break
            tried += 1
            designs[i] = _told(designs[i], ways, [way.fitted(designs[i]) for way in ways], asked)
            if found.shortfall(designs[i]) > 1:
                continue
        return found.model_copy(update={"designs": tuple(designs), "advised": i})
    best = min(order, key=lambda i: found.shortfall(designs[i]))
    return found.model_copy(update={"designs": tuple(designs), "advised": best})
