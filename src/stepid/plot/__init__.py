"""Pictures: each function draws into axes and returns them; the only room that imports matplotlib."""

from stepid.plot.paper import paper_figure
from stepid.plot.responses import residual, response, verification, verification_grid
from stepid.plot.style import save
from stepid.plot.trend_panels import trend, trends

__all__ = ["paper_figure", "residual", "response", "save", "trend", "trends", "verification", "verification_grid"]
