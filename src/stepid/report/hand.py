"""The paper's peak method on the campaign of a diagnosis: stacked system, solution, verification, or why not."""

from __future__ import annotations

from stepid.core.base import Model
from stepid.core.experiment import Campaign
from stepid.core.quantities import in_own_quantities
from stepid.diagnosis.result import Diagnosis
from stepid.errors import IdentificationError
from stepid.identification.identify import identify_with_system
from stepid.identification.parameters import IdentifiedParameters, StackedSystem
from stepid.identification.transfer.verification import Verification
from stepid.identification.transfer.verify import verify


class HandMethod(Model):
    """What the peak method makes of a campaign.

    Parameters
    ----------
    system : StackedSystem
        Eq. 10, corrected, of the runs that it can use.
    found : IdentifiedParameters
    verified : Verification
    """

    system: StackedSystem
    found: IdentifiedParameters
    verified: Verification


Hand = HandMethod | IdentificationError | None
"""What the peak method makes of a diagnosis, or why nothing; None where the diagnosis does not know its campaign."""


@in_own_quantities
def by_hand(campaign: Campaign) -> HandMethod | IdentificationError:
    """Go the paper's way: characteristics, stacked system, solution, verification.

    Parameters
    ----------
    campaign : Campaign

    Returns
    -------
    HandMethod or IdentificationError
        The error says why the method cannot use the campaign.
    """
    try:
        system, found = identify_with_system(campaign)
        return HandMethod(system=system, found=found, verified=verify(found, campaign))
    except IdentificationError as error:
        return error


def used_all_the_same(d: Diagnosis, found: IdentifiedParameters) -> str:
    """Say which runs the peak method uses although the diagnosis left them out, '' where there are none."""
    used = {run.name for run in d.runs}
    still = [name for name in found.masses if name not in used]
    return f"The peak method, which screens no records, uses {', '.join(still)} all the same." if still else ""


def pictured(d: Diagnosis, hand: Hand) -> Verification | None:
    """Keep the verified runs that the diagnosis rests on, None where there is none: what is left out has no picture."""
    if not isinstance(hand, HandMethod):
        return None
    used = {run.name for run in d.runs}
    runs = tuple(run for run in hand.verified.runs if run.name in used)
    return Verification(runs=runs) if runs else None
