"""Pictures: each function draws into axes and returns them; the only room that imports matplotlib."""

from stepid.errors import MissingExtraError

try:
    import matplotlib as _matplotlib  # noqa: F401
except ImportError as error:  # a clear message in the place of a bare one; the cause stays attached
    raise MissingExtraError("drawing needs matplotlib", "Install it with: pip install 'stepid[plot]'.") from error

from stepid.plot.paper import paper_figure
from stepid.plot.style import save
from stepid.plot.verification import residual, response, verification, verification_grid

__all__ = ["paper_figure", "residual", "response", "save", "verification", "verification_grid"]
