"""The answer of a diagnosis in a sentence or two: what is missing, how large it is, and what would tell it apart."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from stepid.core.words import capitalized, listed
from stepid.diagnosis.wording import candidate_name, effect_names

if TYPE_CHECKING:
    from stepid.diagnosis.result import Diagnosis, Ranked

_MOST = 4  # sizes that a sentence bears


def answer(d: Diagnosis, *, sizes: bool = True) -> str:
    """The verdict as a sentence; an open choice begins with what is most likely, and its size.

    Without `sizes` effects that are named stand alone, as in the title of a picture.
    """
    if d.verdict == "adequate":
        return "A linear model is adequate."
    if d.verdict == "named":
        found = _sized(d) if sizes else effect_names(d.effects)
        return f"A linear model is not adequate: {found}{_verb(d, found, 'is', 'are')} missing."
    if d.verdict == "ambiguous":
        return _open_choice(d)
    if d.wrong_inputs:
        runs = listed([repr(name) for name in d.wrong_inputs], "and")
        return f"No model can be judged: the input of run {runs} is not what the record says."
    if any(one.effects and leaves_noise(d, one) for one in d.ranking):
        return "A linear model is not adequate, and these data do not tell which effect is missing."
    if any(one.effects and one.explained >= d.criteria.lead for one in d.ranking):
        return "A linear model is not adequate, and nothing in the catalogue explains all of what it leaves."
    return "A linear model is not adequate, and nothing in the catalogue explains why."


def leaves_noise(d: Diagnosis, one: Ranked) -> bool:
    """Tell whether a candidate leaves little more than noise."""
    return one.rms <= d.criteria.near * d.gap.noise


def found_sizes(d: Diagnosis) -> list[tuple[str, str, str]]:
    """What the effects of the answer measure: effect and parameter in words, value ± standard uncertainty, its unit."""
    if d.verdict not in ("named", "ambiguous"):
        return []
    own = [(name.partition("."), found) for name, found in d.parameters.items() if "." in name]
    return [
        (effect_names((effect,)), parameter.replace("_", " "), str(found))
        for (effect, _, parameter), found in own
        if effect in d.effects
    ]


def advice_beside(d: Diagnosis) -> str:
    """What to measure to close an open choice, to stand beside it; empty where nothing is known to."""
    if d.verdict != "ambiguous" or d.next_experiment is None:
        return ""
    return capitalized(d.next_experiment.rstrip(".")) + "."


def _open_choice(d: Diagnosis) -> str:
    found, one = _sized(d), len(d.effects) == 1
    if not d.alternatives:
        return (
            f"{capitalized(found)}{_verb(d, found, 'explains', 'explain')} the misfit; errors of the added "
            "masses within their uncertainty would, too."
        )
    likely = "Most likely" if _is_likeliest(d) else "Possibly"
    others = [candidate_name(names) for names in d.alternatives]
    return f"{likely} {found}; these data do not tell {'it' if one else 'them'} from {listed(others, 'or')}."


def _verb(d: Diagnosis, found: str, one: str, several: str) -> str:
    """The verb behind the effects, with the comma that closes a size between commas."""
    comma = "," if found.startswith(f"{effect_names(d.effects)}, ") else ""
    return f"{comma} {one if len(d.effects) == 1 else several}"


def _sized(d: Diagnosis) -> str:
    """The effects of the answer, each with its sizes, as far as they are few."""
    sizes = found_sizes(d)
    if len(d.effects) == len(sizes) == 1:
        return f"{effect_names(d.effects)}, {sizes[0][2]}"
    return " and ".join(_with_sizes(effect_names((name,)), sizes) for name in d.effects)


def _with_sizes(effect: str, sizes: Sequence[tuple[str, str, str]]) -> str:
    own = [(parameter, size) for of, parameter, size in sizes if of == effect]
    if not own or len(sizes) > _MOST:
        return effect
    told = [size for _, size in own] if len(own) == 1 else [f"{parameter} {size}" for parameter, size in own]
    return f"{effect} ({', '.join(told)})"


def _is_likeliest(d: Diagnosis) -> bool:
    """Whether the evidence is for the answer more than for any of its alternatives."""

    def loss(names: Sequence[str]) -> float | None:
        return min((one.evidence for one in d.ranking if set(one.effects) == set(names)), default=None)

    own = loss(d.effects)
    others = [found for names in d.alternatives if (found := loss(names)) is not None]
    return own is not None and own <= min(others, default=own)
