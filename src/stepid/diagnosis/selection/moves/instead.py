"""Add one effect in the place of a condition that differs from run to run."""

from __future__ import annotations

from stepid.diagnosis.selection.moves.add import Add


class Instead(Add):
    """Add an effect to a set that does without one condition of the best: it may be what makes the runs differ.

    A drive that saturates gives large steps another gain, a delay all driven runs another start time.
    """

    name = "instead"
