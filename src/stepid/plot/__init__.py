"""Pictures: each function draws into axes and returns them; the only room that imports matplotlib."""

from stepid.plot.causes import candidates, force_against_position, force_against_velocity, phase_bars
from stepid.plot.diagnosis_page import diagnosis
from stepid.plot.gap import gap_bars, gap_residual, gap_response, gap_runs
from stepid.plot.paper import paper_figure
from stepid.plot.records import records
from stepid.plot.responses import residual, response, verification, verification_grid
from stepid.plot.ring_down import ring_down
from stepid.plot.style import save
from stepid.plot.trend_panels import trend, trends

__all__ = [
    "candidates",
    "diagnosis",
    "force_against_position",
    "force_against_velocity",
    "gap_bars",
    "gap_residual",
    "gap_response",
    "gap_runs",
    "paper_figure",
    "phase_bars",
    "records",
    "residual",
    "response",
    "ring_down",
    "save",
    "trend",
    "trends",
    "verification",
    "verification_grid",
]
