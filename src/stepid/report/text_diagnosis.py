"""The text of `stepid diagnose`."""

from __future__ import annotations

from stepid.core.quantities import in_own_quantities
from stepid.diagnosis.result import Diagnosis
from stepid.errors import StepidError
from stepid.identification.parameters import IdentifiedParameters
from stepid.report.hand import used_all_the_same
from stepid.report.pull import hand_method_table
from stepid.report.section import Section


@in_own_quantities
def diagnosis_report(diagnosis: Diagnosis, identified: IdentifiedParameters | StepidError) -> tuple[Section, ...]:
    """Write a diagnosis, and the peak method beside it.

    Parameters
    ----------
    diagnosis : Diagnosis
        From `stepid.diagnose`.
    identified : IdentifiedParameters or StepidError
        From `stepid.identify`, or why it refused.

    Returns
    -------
    tuple of Section
    """
    if isinstance(identified, StepidError):
        beside = f"The peak method cannot use this campaign: {identified.cause}."
    else:
        beside = hand_method_table(diagnosis, identified)
        if still := used_all_the_same(diagnosis, identified):
            beside = f"{beside}\n\n{still} The diagnosis left that out: its numbers are of the other runs."
    return (
        Section(title="Diagnosis", body=diagnosis.summary()),
        Section(title="The peak method beside it", body=beside),
    )
