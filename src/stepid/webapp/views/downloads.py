"""The last section: what can be taken away."""

from __future__ import annotations

import io
from collections.abc import Callable

from stepid.report.chapter import Table
from stepid.report.file_names import file_names
from stepid.webapp import downloads
from stepid.webapp.session import Session
from stepid.webapp.views.parts import card, download, html, note, row

_LEAD = (
    "The campaign is a folder that stepid reads again; the report, once there is a diagnosis, is one page, drawn in a "
    "few seconds; the tables are CSV."
)


class DownloadView:
    """Buttons, each of use once there is what it gives."""

    def __init__(self, session: Session, tables: Callable[[], tuple[Table, ...]]) -> None:
        self._session, self._tables = session, tables
        self._campaign = download("Campaign", self._zip)
        self._report = download("Report", self._page)
        self._csv = download("Tables", self._sheets)
        self.view = card(6, "Take it with you", html(note(_LEAD)), row(self._campaign, self._report, self._csv))

    def show(self, *, complete: bool) -> None:
        """Say what there is; `complete` where the table makes a campaign."""
        stem = file_names([self._session.name])[self._session.name]
        self._campaign.filename, self._campaign.disabled = f"{stem}.zip", not complete
        self._report.filename, self._report.disabled = f"{stem}-report.html", self._session.found is None
        self._csv.filename, self._csv.disabled = f"{stem}-tables.zip", not self._tables()

    def _zip(self) -> io.BytesIO:
        return io.BytesIO(downloads.campaign_zip(self._session.campaign))

    def _page(self) -> io.BytesIO:
        assert self._session.found is not None
        return io.BytesIO(downloads.report_html(self._session.found))

    def _sheets(self) -> io.BytesIO:
        return io.BytesIO(downloads.tables_zip(self._tables()))
