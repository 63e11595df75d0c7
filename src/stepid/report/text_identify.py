"""The text of `stepid identify`."""

from __future__ import annotations

from itertools import pairwise

from stepid.core.experiment import Campaign
from stepid.core.quantities import in_own_quantities
from stepid.identification.parameters import IdentifiedParameters
from stepid.identification.transfer.verification import Verification
from stepid.identification.trends import Trends
from stepid.report.section import Section


@in_own_quantities
def identify_report(
    campaign: Campaign, parameters: IdentifiedParameters, verified: Verification, trends: Trends
) -> tuple[Section, ...]:
    """Write what the paper's method finds in a campaign.

    Parameters
    ----------
    campaign : Campaign
    parameters : IdentifiedParameters
        From `stepid.identify`.
    verified : Verification
        From `stepid.verify`.
    trends : Trends
        From `stepid.find_trends`.

    Returns
    -------
    tuple of Section
    """
    return (
        Section(title=f"Campaign {campaign.name!r}", body=_found(parameters)),
        Section(title="Verification responses", body=verified.summary()),
        Section(title="Trends", body=trends.summary()),
    )


def _found(parameters: IdentifiedParameters) -> str:
    # the paper's case 3: what the moving parts of a damper weigh shows between two bases
    differences = [
        f"base {heavy!r} minus base {light!r}: {parameters.base_difference(light, heavy)}"
        for light, heavy in pairwise(sorted(parameters.base_mass, key=lambda base: parameters.base_mass[base]))
    ]
    return "\n\n".join([parameters.summary(), *differences])
