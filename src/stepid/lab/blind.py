"""Make a blind campaign for each group of a class."""

from __future__ import annotations

import hashlib
import json
import math
import re
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from stepid.core.base import Array
from stepid.core.experiment import Campaign
from stepid.core.noise import rms
from stepid.core.takes import a, described, optional, takes
from stepid.diagnosis.progress import Progress, Tell, listener, telling
from stepid.effects import CATALOGUE, Effect, a_catalogue
from stepid.errors import InputError
from stepid.fitting.covariance import estimates
from stepid.fitting.levenberg_marquardt import Optimum
from stepid.fitting.problem import build
from stepid.lab.answers import Answer, Answers
from stepid.lab.assignment import LONG_ENOUGH, SEALED, Assignment, guessable
from stepid.lab.choice import Choice, Draw, chosen_for, stream
from stepid.lab.hashes import digest
from stepid.lab.hide import Start, campaign_of, linear_misfit, model_of, respond, sized
from stepid.lab.rig import Plant, Rig, draw_plant
from stepid.simulation.model import EffectModel, PlantModel
from stepid.simulation.records import lay_out
from stepid.simulation.simulate import pack

_NAME = re.compile(r"\w(?:[\w .+-]{0,38}\w)?")  # of a group: also a folder's
_choice = a(
    (Draw, Sequence, Mapping), 'a Draw, effects in a sequence as ("coulomb_friction",), or a mapping of group to those'
)
_UNITS = ("kg", "N/m", "N·s/m", "N/V")
_DIGITS = 1000  # of a seed
_ZERO = 50  # counts by which a record's zero may be off


@takes(catalogue=a_catalogue, rig=optional(a(Rig, "stepid.lab.Rig(…)")), effects=optional(_choice), progress=listener)
def make(
    *,
    seed: int | str,
    groups: Sequence[str],
    effects: Choice | None = None,
    visibility: tuple[float, float] = (5.0, 25.0),
    rig: Rig | None = None,
    catalogue: tuple[Effect, ...] = CATALOGUE,
    progress: Tell | bool | None = None,
) -> Assignment:
    """Make a blind campaign for each group, with a hidden effect.

    Each group gets a plant of its own. The strength of a hidden effect is chosen so that a linear model visibly misses
    it. The records are simulated by `stepid.simulate`: good for teaching, no proof of what the diagnosis can do.

    Parameters
    ----------
    seed : int or str
        The same seed makes the same campaigns with the same versions of stepid and numpy. **Whoever knows it can make
        the answers, too**: take a text that nobody can guess, of 12 characters at least. A shorter whole number is good
        for trying things out; `Assignment.write` refuses it. A group's campaign does not depend on the other groups.
    groups : sequence of str
        Names: letters, digits, blanks and ``_ . + -``; each becomes a folder.
    effects : Draw, sequence, or mapping of group to sequence; optional
        What to hide. A sequence of canonical names, or of `stepid.EffectModel` where you choose the values; () hides
        nothing. Drawn by ``Draw()`` if not given.
    visibility : (float, float)
        Range from which r0 of each hidden effect is drawn, logarithmically: the RMS that the best joint linear fit
        leaves, over the RMS of the noise. 1 is invisible, 5 is seen at once in the residual. Does not change values
        that you have chosen.
    rig : Rig, optional
        ``Rig()`` if not given.
    catalogue : tuple of Effect
        Where names are looked up.
    progress : callable or False, optional
        Called with a `stepid.Progress` before each group: its name, how many are made and how many are left. If not
        given, a notebook shows a bar and a script nothing; False is silent.

    Returns
    -------
    Assignment

    Raises
    ------
    stepid.errors.InputError
        If a text as seed is too short, a name of a group, an effect or its parameter is wrong, or an effect cannot be
        made visible on this rig.
    stepid.errors.ConvergenceError
        If values that you have chosen make the response run away.

    Examples
    --------
    >>> assignment = stepid.lab.make(seed="an old sentence that nobody knows", groups=("A", "B"))
    >>> assignment.write("autumn", passphrase="and another one")
    """
    names, seed, visibility = _groups(groups), _seed(seed), _range(visibility)
    rig = Rig() if rig is None else rig
    choice: Choice = Draw() if effects is None else effects
    extra = sorted(set(choice) - set(names)) if isinstance(choice, Mapping) else []
    if extra:
        raise InputError(f"effects speaks of a group {extra[0]!r}", f"The groups are {', '.join(names)}.")
    campaigns, answers = [], []
    with telling(progress, line=str) as tell:
        for done, group in enumerate(names):
            tell(Progress(group, done=done, left=len(names) - done))
            chosen = chosen_for(group, choice, seed, catalogue=catalogue)
            campaign, answer = _one(group, seed, chosen, visibility, rig, catalogue)
            campaigns.append(campaign)
            answers.append(answer)
    return Assignment(campaigns=tuple(campaigns), answers=Answers(seed=seed, answers=tuple(answers)))


def _groups(groups: object) -> tuple[str, ...]:
    if isinstance(groups, str) or not isinstance(groups, Sequence) or not groups:
        raise InputError(f"groups is {described(groups)}", 'Give a sequence of names, as in ("A", "B").')
    for name in groups:
        if not isinstance(name, str) or not _NAME.fullmatch(name) or name.lower() == SEALED:
            raise InputError(
                f"a group cannot be called {described(name)}",
                "Use letters, digits, blanks and _ . + -, at most 40 in all.",
            )
    if len({name.lower() for name in groups}) < len(groups):
        raise InputError("two groups have the same name, or differ in capitals only", "Each name becomes a folder.")
    return tuple(groups)


def _seed(seed: object) -> int | str:
    if isinstance(seed, bool) or not isinstance(seed, int | str) or seed == "":
        raise InputError(f"seed is {described(seed)}", "Give a whole number or a text.")
    if isinstance(seed, str) and guessable(seed):  # a number may be for trying things out, until it is written
        raise InputError(f"seed {seed!r} can be guessed", LONG_ENOUGH)
    if isinstance(seed, int) and abs(seed) >= 10**_DIGITS:
        raise InputError(f"seed is {described(seed)}", f"Give a whole number of up to {_DIGITS} digits, or a text.")
    return seed


def _range(visibility: object) -> tuple[float, float]:
    try:
        low, high = (float(v) for v in visibility)  # type: ignore[attr-defined]
    except (TypeError, ValueError):
        low = high = math.nan
    if not 1.5 <= low <= high < 1e6:
        raise InputError(
            f"visibility is {described(visibility)}", "Give two numbers from 1.5 up, the smaller one first."
        )
    return low, high


def _one(
    group: str,
    seed: int | str,
    chosen: tuple[tuple[Effect, EffectModel | None], ...],
    visibility: tuple[float, float],
    rig: Rig,
    catalogue: tuple[Effect, ...],
) -> tuple[Campaign, Answer]:
    def own(what: str) -> np.random.Generator:
        return stream(seed, group, what)

    rounding = 1 / rig.counts_per_meter / math.sqrt(12)
    noise = math.hypot(rig.noise, rounding)
    drawn = draw_plant(rig, own("plant"))
    plant = Plant(*(float(f"{v:.6g}") for v in drawn))
    places = own("start")
    start = Start(places.uniform(-1, 1, len(rig.runs)), places.uniform(0, 2 * math.pi, len(rig.runs)))
    hidden = [
        given or _sized(effect, rig, plant, start, noise=noise, visibility=visibility, own=own, catalogue=catalogue)
        for effect, given in chosen
    ]
    effects = tuple(hidden)
    model = model_of(rig, plant, effects, start, catalogue=catalogue)
    amplifier = own("drive noise")
    inputs = tuple(rig.inputs(plan.level) for plan in rig.runs)
    noisy = tuple(volts + rig.drive_noise * amplifier.standard_normal(volts.size) for volts in inputs)
    exact = respond(rig, model, catalogue=catalogue)
    read = _read(rig, respond(rig, model, catalogue=catalogue, inputs=noisy), own("reading"))
    campaign = campaign_of(rig, positions=read, name=f"group {group}")
    error = np.concatenate([x - y - np.mean(x - y) for x, y in zip(read, exact, strict=True)])
    random = max(rms(error), rounding)
    values, units = _written(rig, plant, tuple(effect for effect, _ in chosen), effects)
    return campaign, Answer(
        group=group,
        effects=tuple(effect.name for effect, _ in chosen),
        parameters=values,
        units=units,
        attainable=_attainable(campaign, model, tuple(effect for effect, _ in chosen), random),
        visibility=linear_misfit(rig, read) / random,
        noise=random,
        records=digest(campaign),
        nonce=hashlib.sha256(json.dumps(["nonce", seed, group]).encode()).hexdigest(),
    )


def _sized(
    effect: Effect,
    rig: Rig,
    plant: Plant,
    start: Start,
    *,
    noise: float,
    visibility: tuple[float, float],
    own: Callable[[str], np.random.Generator],
    catalogue: tuple[Effect, ...],
) -> EffectModel:
    """An effect as visible as is drawn for it; `noise` in m."""
    low, high = visibility
    wanted = math.exp(own(f"{effect.name} visibility").uniform(math.log(low), math.log(high)))
    return sized(
        rig,
        plant,
        effect,
        start,
        misfit=noise * math.sqrt(wanted**2 - 1),
        least=noise * math.sqrt(low**2 - 1),
        stream=own,
        catalogue=catalogue,
    )


def _written(
    rig: Rig, plant: Plant, effects: tuple[Effect, ...], hidden: tuple[EffectModel, ...]
) -> tuple[dict[str, float], dict[str, str]]:
    """Values and units of an answer, by name."""
    values = dict(zip(rig.labels, plant, strict=True))
    units = dict(zip(rig.labels, _UNITS, strict=True))
    for effect, own in zip(effects, hidden, strict=True):
        for parameter in effect.parameters:
            values[f"{effect.name}.{parameter.name}"] = own.values[parameter.name]
            units[f"{effect.name}.{parameter.name}"] = parameter.unit
    return values, units


def _attainable(
    campaign: Campaign, model: PlantModel, effects: tuple[Effect, ...], noise: float
) -> dict[str, float | None]:
    """Standard uncertainties by noise of a joint fit that has found the truth, from its sensitivities there."""
    records = lay_out(campaign)
    problem = build(records, effects)
    shared, local = pack(model, records, effects)
    solved = problem.solve(shared, local)
    if solved is None:
        return {}
    left = problem.residual(solved)
    optimum = Optimum(problem, shared, local, solved, cost=float(left @ left), converged=True, iterations=0)
    found = estimates(optimum, effects, noise)[0]
    return {name: e.parts.get("noise", e.uncertainty) for name, e in found.items()}


def _read(rig: Rig, positions: tuple[Array, ...], noise: np.random.Generator) -> tuple[Array, ...]:
    """What the encoder says: from a zero of its own, with noise, in whole counts, m."""
    out = []
    for x in positions:
        zero = noise.uniform(-_ZERO, _ZERO)
        counts = np.rint((x + rig.noise * noise.standard_normal(x.size)) * rig.counts_per_meter + zero)
        out.append(counts / rig.counts_per_meter)
    return tuple(out)
