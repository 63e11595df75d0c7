"""Rules by which a linear plant is enough."""

from __future__ import annotations

from stepid.core.words import length
from stepid.diagnosis.gather import EvidenceRecord
from stepid.diagnosis.rule import Answer
from stepid.diagnosis.selection.candidate import is_free
from stepid.diagnosis.verdict_words import WEIGHTS, title
from stepid.diagnosis.wording import effect_names, whole_percent


def linear_is_enough(e: EvidenceRecord) -> Answer | None:
    """The linear plant leaves nothing but noise."""
    if not e.white or (e.best.effects and e.times(e.linear) > e.faint):
        return None
    return Answer("adequate", e.linear, (), ("The residual of the linear model is as white as the readings' noise.",))


def runs_differ(e: EvidenceRecord) -> Answer | None:
    """A linear plant is enough whose conditions differ from run to run."""
    if e.best.effects or not e.at_floor(e.best):
        return None
    if not e.best.deviations:
        return Answer("adequate", e.linear, (), ("No effect earns what its parameters cost.",))
    what = effect_names(sorted(e.best.deviations))
    said: tuple[str, ...] = (f"The runs differ in {what}. With that, a linear model leaves only noise.",)
    others = [f"{title(c)} and runs that {'differ by less' if c.deviations else 'are alike'}" for c in e.rivals]
    said += tuple(f"These data do not tell that from {other}." for other in others)
    return Answer("adequate", e.best, (), said)


def weights_are_enough(e: EvidenceRecord) -> Answer | None:
    """Errors of the added masses within their uncertainty are enough, and no single effect is."""
    if e.context.by_weights is None:
        return None
    one = e.best.effects and e.best.complexity == 1 and e.at_floor(e.best) and not is_free(e.best)
    if one and not e.barred(e.best) and not e.followed(e.best):
        return None
    return Answer("adequate", e.linear, (), (WEIGHTS,))


def rest_follows_nothing(e: EvidenceRecord) -> Answer | None:
    """A linear plant, whose runs may differ, leaves little more than noise, as much where the cart rests: it is noise.

    No law of any shape takes a part of it, and effects that are fitted to it less than half on runs left out.
    """
    found = e.plain
    differs = bool(found.deviations)
    if e.times(found) >= 2 or (differs and e.systematic(found)) or not e.is_noise(found):
        return None
    fitted = {id(c): c for c in (e.best, e.lead) if c.effects}.values()
    if any(e.share(c)[0] >= 1 / 2 or not e.judges(c) for c in fitted):
        return None
    taken = 1 - found.optimum.cost / e.linear.optimum.cost
    what = effect_names(sorted(found.deviations))
    said: tuple[str, ...] = ()
    if differs:
        said = (f"The runs differ in {what}, which takes {whole_percent(taken)} of the misfit's power.",)
    said += (
        f"What is left, {length(found.optimum.rms)}, is {e.times(found):.3g} times the noise floor. It is there where "
        "the cart rests, too, follows no law, and no effect predicts it: the noise is larger than it looks.",
    )
    return Answer("adequate", found, (), said)
