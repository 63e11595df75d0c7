"""What can be taken away: the campaign as a folder, the report, the tables."""

from __future__ import annotations

import csv
import io
import zipfile
from pathlib import Path
from tempfile import TemporaryDirectory

from stepid.core.experiment import Campaign
from stepid.diagnosis.result import Diagnosis
from stepid.io.campaign_files import write_campaign
from stepid.report.chapter import Table
from stepid.report.file_names import file_names
from stepid.report.write import write_html


def campaign_zip(campaign: Campaign) -> bytes:
    """Write a campaign as `stepid.write_campaign` does, into one zip file."""
    with TemporaryDirectory() as scratch:
        folder = write_campaign(campaign, Path(scratch) / "campaign").parent
        return _zipped({path.name: path.read_bytes() for path in sorted(folder.iterdir())})


def report_html(diagnosis: Diagnosis) -> bytes:
    """Write the report of a diagnosis."""
    with TemporaryDirectory() as scratch:
        return write_html(diagnosis, Path(scratch) / "report.html").read_bytes()


def tables_zip(tables: tuple[Table, ...]) -> bytes:
    """Write tables as CSV, one a file, with the texts that the page shows."""
    files = file_names(table.caption for table in tables)
    return _zipped({f"{files[table.caption]}.csv": _csv(table) for table in tables})


def _csv(table: Table) -> bytes:
    text = io.StringIO(newline="")
    csv.writer(text).writerows((table.header, *table.rows))
    return text.getvalue().encode("utf-8-sig")  # spreadsheets take it for the local encoding without the mark


def _zipped(files: dict[str, bytes]) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return out.getvalue()
