"""Parts of the sentences that the rules of the verdict say."""

from __future__ import annotations

from stepid.core.words import capitalized, length
from stepid.diagnosis.constancy import CONDITIONS
from stepid.diagnosis.selection.candidate import Candidate
from stepid.diagnosis.wording import effect_names

OUTDONE = (
    "A second oscillation beside the plant's own halves what is left, but these data do not show one. "
    "The own oscillation changes as no law of the catalogue lets it: no effect is named."
)
WEIGHTS = "Errors of the added masses within their uncertainty explain what the linear model leaves."


def title(found: Candidate, plain: str = "nothing") -> str:
    """Name a candidate's effects; `plain` where it has none."""
    return effect_names(found.names) or plain


def what_leaves(found: Candidate) -> str:
    """Begin a sentence on what a candidate leaves."""
    verb = "leave" if len(found.names) > 1 else "leaves"
    return f"{capitalized(title(found, 'a linear model'))} {verb}"


def follows(state: str) -> str:
    """Say what a rest that a law of any shape takes does."""
    return f"changes with {state}" if state == CONDITIONS else f"follows {state}"


def as_well(lead: Candidate, rival: Candidate) -> str:
    """Say that another law does nearly as well as a lead, and that what is missing decides between them."""
    return (
        f"{what_leaves(rival)} {length(rival.optimum.rms)}, {title(lead)} {length(lead.optimum.rms)}: "
        "what is missing in both is more than what sets them apart. No effect is named."
    )


def better(state: str) -> str:
    """Say why a law of any shape refutes a lead."""
    if state == CONDITIONS:
        return "Its parameters would have to change with the added mass, the labels or the input: no effect is named."
    return f"A force of {state} whose law is none of the catalogue's does as well or better: no effect is named."
