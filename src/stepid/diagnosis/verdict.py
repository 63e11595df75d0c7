"""The verdict: small rules over the evidence, the first that answers decides."""

from __future__ import annotations

from dataclasses import replace

from stepid.core.words import capitalized, length
from stepid.diagnosis.evidence import least_share
from stepid.diagnosis.gather import EvidenceRecord
from stepid.diagnosis.rule import Answer as Answer
from stepid.diagnosis.rule import Rule
from stepid.diagnosis.rules_lead import inside, is_part, leads, only_a_lead, with_rivals
from stepid.diagnosis.rules_linear import (
    linear_is_enough,
    rest_follows_nothing,
    runs_differ,
    weights_are_enough,
)
from stepid.diagnosis.selection.candidate import is_free
from stepid.diagnosis.verdict_words import WEIGHTS, follows, title, what_leaves
from stepid.diagnosis.wording import (
    candidate_name,
    effect_names,
    parameter_words,
    per_cent,
    taken_in_words,
    whole_percent,
)


def input_is_wrong(e: EvidenceRecord) -> Answer | None:
    """What any effect would be fitted to is wrong."""
    if e.input_fault is None:
        return None
    return Answer("unexplained", e.linear, (), (e.input_fault.words,))


def scatter_is_a_law(e: EvidenceRecord) -> Answer | None:
    """The best leaves only noise where runs differ, but by what goes with a condition: that is a law, no scatter."""
    found = e.systematic(e.best) if e.at_floor(e.best) else None
    if found is None:
        return None
    said = (
        f"{what_leaves(e.best)} only noise where the {effect_names((found.kind,))} differs from "
        f"run to run, but that goes with {found.words}: it is a law, no scatter."
    )
    return only_a_lead(e, said)


def freedom_is_untested(e: EvidenceRecord) -> Answer | None:
    """The best has a freedom in every run and, with it estimated on a first part, does not predict the rest.

    As a whole, or half of what its other effects leave. What leaves only noise without such freedoms is the answer
    then, if it is a part of the best.
    """
    if not is_free(e.best) or not e.at_floor(e.best):
        return None
    whole, _ = e.share(e.best)
    share, of = whole, "the misfit's power"
    if whole >= e.criteria.lead:
        share, of = e.share_of_free(e.best), "what its other effects leave"
        if share > 1 / 2:
            return None
    part = inside(e)
    if part is not None:
        return part
    without = _first(e.without_free, RULES)
    if e.at_floor(without.shown) and is_part(without.shown, e.best) and without.verdict != "unexplained":
        return without
    noise = rest_follows_nothing(e)
    if noise is not None:
        return replace(noise, rule=rest_follows_nothing.__name__)
    said = f"{what_leaves(e.best)} only noise, but "
    said += (
        f"that is no prediction: fitted to the first part of a run that was left out, it takes "
        f"{whole_percent(max(share, 0.0))} of {of} in the rest."
        if e.judges(e.best)
        else "no run can be left out to test what is free in every run."
    )
    return Answer("unexplained", e.best, (), (said, "No effect is named."))


def shape_is_patched(e: EvidenceRecord) -> Answer | None:
    """The best is a sum of laws of one state, three or two that cancel: that describes another law, and names none."""
    state = e.patchwork(e.best) if e.at_floor(e.best) else ""
    if not state:
        return None
    said = (
        f"{what_leaves(e.best)} only noise, but together such forces of {state} can follow a law of any shape.",
        f"A force of {state} is missing, whose law is none of the catalogue's.",
    )
    return Answer("unexplained", e.best, (), said)


def rest_follows_the_motion(e: EvidenceRecord) -> Answer | None:
    """What the best leaves is as small as the noise, but follows the motion: the law is another or not alone."""
    state = e.followed(e.best) if e.at_floor(e.best) else ""
    if not state:
        return None
    whose = "a" if len(e.best.effects) > 1 else "its"
    said = (
        f"{what_leaves(e.best)} {length(e.best.optimum.rms)}, {e.times(e.best):.3g} times the noise floor, "
        f"but what is left {follows(state)}: {whose} law is another, or more is missing."
    )
    return only_a_lead(e, said)


def complete_but_open(e: EvidenceRecord) -> Answer | None:
    """The best leaves only noise, but a parameter is open, or an effect not seen or imitated: others are as good.

    Or a simpler law inside it that leads: what the general one has beyond it is open, and what it leaves follows that.
    """
    if not (e.at_floor(e.best) and e.barred(e.best)):
        return None
    sure = [c for c in e.rivals if e.at_floor(c)] or list(e.simpler)
    sure = [c for c in sure if not (e.at_floor(c) and e.followed(c)) and not e.barred(c)]
    but = ["the data do not determine " + ", ".join(map(parameter_words, e.undetermined))] if e.undetermined else []
    but += [f"{effect_names((name,))} cannot be told from {what} here" for name, what in e.imitators(e.best).items()]
    said = f"{what_leaves(e.best)} only noise, but {', and '.join(but)}."
    if not sure:
        found = inside(e)
        if found is None:
            return Answer("unexplained", e.best, (), (said, "No effect is named."))
        return replace(found, reasons=(*found.reasons, said))
    first = sure[0]
    words = (said, f"{what_leaves(first)} {length(first.optimum.rms)}, {e.times(first):.3g} times the noise floor.")
    if e.unseen(e.best):
        return with_rivals(e, first, tuple(sure[1:]), words) or Answer("named", first, (), words)
    return Answer("ambiguous", first, (*sure[1:], e.best), words)


def complete(e: EvidenceRecord) -> Answer | None:
    """The best leaves only noise, and no other does."""
    if not e.at_floor(e.best):
        return None
    said: tuple[str, ...] = (
        f"With {title(e.best)} the model leaves {length(e.best.optimum.rms)}, as much as the noise.",
    )
    sized = e.limited(e.best).items()
    said += tuple(f"The data limit {parameter_words(name)} on one side only: {size}." for name, size in sized)
    return with_rivals(e, e.best, e.rivals, said) or Answer(
        "named", e.best, (), (*said, "No other candidate that is as simple comes near.")
    )


def unexplained(e: EvidenceRecord) -> Answer | None:
    """Nothing explains it, and that is said."""
    best = e.best if e.best.effects else e.lead
    nearest = best if best.effects else e.likeliest  # which may not be named
    if not nearest.effects:
        return Answer("unexplained", best, (), ("No candidate explains the misfit.",))
    left = f"leaves {length(nearest.optimum.rms)}, {e.times(nearest):.3g} times the noise floor"
    if e.times(nearest) <= e.criteria.near:
        left += ", but no white noise"
    whose = candidate_name(nearest.names, sorted(nearest.deviations))
    said: tuple[str, ...] = (f"The {'best' if best.effects else 'likeliest'} candidate, {whose}, {left}.",)
    imitated = e.imitators(e.likeliest)
    said += tuple(
        f"{capitalized(effect_names((name,)))} cannot be told from {what} here." for name, what in imitated.items()
    )
    return Answer("unexplained", best, (), (*said, *_too_little(e)))


def _too_little(e: EvidenceRecord) -> tuple[str, ...]:
    """What takes most of the misfit on runs left out, and less than a name needs."""
    if not e.lead.effects or e.open(e.lead):
        return ()
    share, _ = e.share(e.lead)
    least = least_share(e.criteria, len(e.lead.effects))
    if not 0.5 < share < least:
        return ()
    return (f"{taken_in_words(e.lead.names, share)}: less than the {per_cent(least)} that a name needs.",)


RULES: tuple[Rule, ...] = (
    input_is_wrong,
    linear_is_enough,
    weights_are_enough,
    scatter_is_a_law,
    runs_differ,
    freedom_is_untested,
    shape_is_patched,
    rest_follows_the_motion,
    complete_but_open,
    complete,
    leads,
    rest_follows_nothing,
    unexplained,
)


def judge(evidence: EvidenceRecord, rules: tuple[Rule, ...] = RULES) -> Answer:
    """Ask the rules in turn; the first that answers decides."""
    linear = evidence.linear.optimum.rms
    times = (
        f"The linear model leaves {length(linear)}, {evidence.times(evidence.linear):.3g} times the noise floor of "
        f"{length(evidence.context.floor)}."
    )
    answer = _first(evidence, rules)
    return _beside_weights(evidence, replace(answer, reasons=(times, *answer.reasons)))


def _first(e: EvidenceRecord, rules: tuple[Rule, ...]) -> Answer:
    """The answer of the first rule that has one."""
    for rule in rules:
        answer = rule(e)
        if answer is not None:
            return replace(answer, rule=answer.rule or rule.__name__)
    raise AssertionError("the last rule answers always")


def _beside_weights(e: EvidenceRecord, answer: Answer) -> Answer:
    """A name is in doubt where errors of the weights within their uncertainty would do as well."""
    if e.context.by_weights is None or answer.verdict != "named":
        return answer
    reasons = (*answer.reasons, WEIGHTS)
    return replace(answer, verdict="ambiguous", reasons=reasons, rule=complete_but_open.__name__)
