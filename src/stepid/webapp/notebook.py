"""The page in a notebook, and what to say where Panel is missing."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from stepid.core.arguments import as_campaign
from stepid.core.experiment import Campaign
from stepid.errors import MissingPackageError

if TYPE_CHECKING:
    from panel import Column

_PACKAGES = ("panel", "bokeh", "param", "tornado", "plotly", "jinja2", "markupsafe", "matplotlib", "pandas")


def app(campaign: Campaign | None = None) -> Column:
    """Show the page of ``stepid app`` in a notebook: records, parameters, diagnosis, play, downloads.

    Parameters
    ----------
    campaign : Campaign, optional
        To begin with; files can be dropped, too.

    Returns
    -------
    panel.Column
        What a notebook shows where it is the last line of a cell.

    Raises
    ------
    stepid.errors.InputError
        If `campaign` is something else.
    stepid.errors.MissingPackageError
        If Panel is not installed: ``pip install "stepid[app]"``.
    """
    given = None if campaign is None else as_campaign(campaign)
    with installed():
        from stepid.webapp.session import Session
        from stepid.webapp.views.serve import viewed
    return viewed(Session(given))


@contextmanager
def installed() -> Iterator[None]:
    """Say what to install where a package of the page is missing."""
    try:
        yield
    except ModuleNotFoundError as error:
        package = (error.name or "").partition(".")[0]
        if package not in _PACKAGES:
            raise
        raise MissingPackageError(
            f"the page needs the package {package!r}", 'Install it with: pip install "stepid[app]"'
        ) from None
