"""Check what a group handed in against the answer."""

from __future__ import annotations

import math
from difflib import get_close_matches

from stepid.core.takes import number, takes
from stepid.effects import CATALOGUE, Effect, resolve
from stepid.errors import InputError, naming
from stepid.lab.answers import Answer, an_answer, in_words
from stepid.lab.checks import Check, Naming, ParameterCheck
from stepid.lab.submission import Submission, a_submission

_share = number("a positive share, such as 0.05 for 5 %", above=0.0)
_REACH = 3.0  # attainable standard uncertainties within which a value is close


@takes(answer=an_answer, submission=a_submission, tolerance=_share)
def check(
    answer: Answer, submission: Submission, *, tolerance: float = 0.05, catalogue: tuple[Effect, ...] = CATALOGUE
) -> Check:
    """Check what a group handed in against its answer.

    Every parameter of the linear plant and of what is hidden is checked twice: whether the 95 % interval that the group
    states holds the truth, and whether the value is within a tolerance of it. A narrow interval beside the truth is as
    wrong as a wide one around it. Where the records do not allow the tolerance, three of the standard uncertainties
    that a joint fit attains on them are enough, and any value where they leave it open.

    Parameters
    ----------
    answer : Answer
    submission : Submission
    tolerance : float
        Relative; for angles in rad, per radian.
    catalogue : tuple of Effect
        Where names of effects are looked up.

    Returns
    -------
    Check

    Raises
    ------
    stepid.errors.InputError
        If the submission is another group's, names an effect or parameter that does not exist, lacks a parameter of
        the linear plant or of an effect that it rightly names, or gives a wrong unit or an uncertainty of zero.
    """
    who = f"submission of group {submission.group!r}"
    if submission.group != answer.group:
        raise InputError(
            f"the {who} is not for the answer of group {answer.group!r}", "Take answers[submission.group]."
        )
    units = _units(answer, submission, who, catalogue)
    _refuse_wrong(submission, units, who)
    named = {n for effects in (submission.effects, *submission.alternatives) for n in effects}
    for name in answer.parameters:
        owner = name.partition(".")[0]
        if name not in submission.parameters and (owner not in answer.effects or owner in submission.effects):
            raise InputError(
                f"the {who} lacks {name!r}", f"Give it in {units[name] or 'no unit'}, with an uncertainty."
            )
    extra = [n for n in submission.parameters if n not in answer.parameters]
    naming, words = _naming(set(answer.effects), submission)
    return Check(
        group=answer.group,
        naming=naming,
        words=words,
        parameters=tuple(
            _one(name, units[name], answer, submission, float(tolerance), named)
            for name in (*answer.parameters, *extra)
        ),
        tolerance=float(tolerance),
    )


def _units(answer: Answer, submission: Submission, who: str, catalogue: tuple[Effect, ...]) -> dict[str, str]:
    """Units of all parameters that a submission may give, by name."""
    units = dict(answer.units)
    for names in (submission.effects, *submission.alternatives):
        with naming(f"the {who}"):
            effects = resolve(names, catalogue=catalogue)
        units |= {f"{e.name}.{q.name}": q.unit for e in effects for q in e.parameters}
    return units


def _plain(unit: str) -> str:
    """A unit without its dots, superscripts and blanks, so that N*s/m, N s/m and N·s/m are one."""
    for old, new in (("²", "2"), ("³", "3"), ("·", ""), ("*", ""), ("^", ""), (" ", ""), ("⋅", "")):
        unit = unit.replace(old, new)
    return unit


def _refuse_wrong(submission: Submission, units: dict[str, str], who: str) -> None:
    for name, given in submission.parameters.items():
        if name not in units:
            near = get_close_matches(name, units, n=1, cutoff=0.4)
            hint = f"Did you mean {near[0]!r}? " if near else ""
            raise InputError(
                f"the {who} gives {name!r}, which is no parameter of this plant or of an effect that it names",
                f"{hint}There are: {', '.join(units)}.",
            )
        if _plain(given.unit) != _plain(units[name]):
            raise InputError(
                f"the {who} gives {name} in {given.unit or 'no unit'}",
                f"Give it in {units[name]}." if units[name] else "Give it without a unit.",
            )
        if given.uncertainty == 0:
            raise InputError(
                f"the {who} gives {name} an uncertainty of zero",
                "Give a standard uncertainty above zero; null says that the records do not determine the value.",
            )


def _naming(truth: set[str], submission: Submission) -> tuple[Naming, str]:
    said = set(submission.effects)
    hidden, named = in_words(sorted(truth)), in_words(sorted(said))
    others = [set(a) for a in submission.alternatives if set(a) != said]
    if said == truth and not others:
        return "right", f"Right: {hidden} hidden." if truth else "Right: nothing is hidden, and nothing was named."
    if truth in (said, *others):
        return "among", f"Right, among {1 + len(others)} that the group could not tell apart: {hidden} hidden."
    if said & truth:
        missed, extra = truth - said, said - truth
        parts = [f"{in_words(sorted(missed))} missed"] if missed else []
        parts += [f"{in_words(sorted(extra))} not in the plant"] if extra else []
        return "partly", f"Partly right: {in_words(sorted(said & truth))} found, {', '.join(parts)}."
    return "wrong", f"Wrong: {hidden} hidden, {named} named."


def _one(
    name: str, unit: str, answer: Answer, submission: Submission, tolerance: float, named: set[str]
) -> ParameterCheck:
    truth, given = answer.parameters.get(name), submission.parameters.get(name)
    value, spread = (None, None) if given is None else (given.value, given.uncertainty)
    off, inside, close = None, False, False
    owner = name.partition(".")[0]
    effect = in_words([owner])
    if truth is None:
        words = f"the plant has no {effect}"
    elif value is None:
        words = f"not given: {effect} was not {'fitted' if owner in named else 'named'}"
    else:
        away = value - truth
        away = math.remainder(away, 2 * math.pi) if unit == "rad" else away
        off = abs(away) if unit == "rad" or truth == 0 else abs(away / truth)
        best = answer.attainable.get(name, 0.0)
        close = off <= tolerance or best is None or abs(away) <= _REACH * best
        inside = spread is not None and abs(away) <= 1.96 * spread
        words = _verdict(None if spread is None else abs(away) / spread, inside=inside, close=close)
    return ParameterCheck(
        name=name,
        unit=unit,
        value=value,
        uncertainty=spread,
        truth=truth,
        off=off,
        inside=inside,
        close=close,
        words=words,
    )


def _verdict(sigmas: float | None, *, inside: bool, close: bool) -> str:
    if sigmas is None:
        return f"stated as undetermined; the value is {'close' if close else 'far off'}"
    if inside:
        return "right" if close else "interval holds the truth, but only because it is wide"
    miss = f"{sigmas:.2g} standard uncertainties away" if sigmas < 100 else "more than 100 standard uncertainties away"
    return f"close, but {miss}: uncertainty too small" if close else f"off, {miss}"
