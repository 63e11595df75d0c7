"""A made-up campaign over the paper's Table 1, with Coulomb friction hidden in it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from stepid.core.base import Finite, Model, Positive
from stepid.core.experiment import Campaign
from stepid.io.campaign_files import read_campaign
from stepid.simulation.model import parameter_unit

_FOLDER = Path(__file__).parent / "lab"


class LabTruth(Model):
    """What was put into the made-up campaign.

    Parameters
    ----------
    base_mass, stiffness, damping : mapping of str to float
        kg, N/m and N·s/m by label.
    force_gain : float
        N/V.
    effects : tuple of str
        Canonical names of the hidden effects.
    parameters : mapping of str to float
        Their parameters, SI units.
    noise_rms : float
        m, sensor noise and rounding to counts together.
    """

    base_mass: Mapping[str, Finite]
    stiffness: Mapping[str, Finite]
    damping: Mapping[str, Finite]
    force_gain: Finite
    effects: tuple[str, ...]
    parameters: Mapping[str, Finite]
    noise_rms: Positive

    def _unit(self, field: str, key: str = "") -> str:
        return parameter_unit(key) if field == "parameters" else super()._unit(field, key)


def lab_campaign() -> Campaign:
    """Return a **made-up** campaign over the nine cases of the paper's Table 1, case 3 in both its configurations.

    No plant was measured: the records were computed, with friction, noise and an encoder's rounding, by a simulator
    that shares no code with stepid's own, and written as ECP exports. Each run is a 0.5 V step and the step back.

    Returns
    -------
    Campaign
        Ten runs at 8.8542 ms and 226600 counts/m. Case 3 has the damper taken off (base "cart, no damper"), case 3b has
        it connected with the plug removed.

    See Also
    --------
    lab_truth : what is in it.

    Notes
    -----
    Table 1 of Burchett's paper gives the added masses, dampers and springs; the plant's values are of the size in
    Table 2.
    """
    return read_campaign(_FOLDER / "campaign.toml")


def lab_truth() -> LabTruth:
    """Return what is hidden in the made-up campaign of `lab_campaign`: look after you have guessed.

    Returns
    -------
    LabTruth
    """
    return LabTruth.model_validate_json((_FOLDER / "truth.json").read_text(encoding="utf-8"))
