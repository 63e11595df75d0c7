"""Write a report to files: whole or not at all."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryDirectory

from stepid.core.atomic_write import staged
from stepid.core.takes import described
from stepid.diagnosis.result import Diagnosis
from stepid.errors import InputError, StepidError
from stepid.io.textfile import as_path, decode, read_bytes
from stepid.report.file_names import file_names
from stepid.report.hand import Hand, by_hand, pictured
from stepid.report.markdown import markdown
from stepid.report.provenance import Provenance, of_diagnosis

_KINDS = (".md", ".tex")
_EXTRAS = {"jinja2": "report", "markupsafe": "report", "plotly": "report", "matplotlib": "plot"}


def write_html(diagnosis: Diagnosis, path: str | os.PathLike[str]) -> Path:
    """Write a diagnosis as one self-contained page; see `stepid.Diagnosis.to_html`."""
    target = as_path(path)
    with staged(target.parent) as folder, _installed():
        _put(diagnosis, of_diagnosis(diagnosis), html=folder / target.name)
    return target


def write_markdown(diagnosis: Diagnosis, path: str | os.PathLike[str]) -> Path:
    """Write a diagnosis as Markdown with pictures beside it; see `stepid.Diagnosis.to_markdown`."""
    target = as_path(path)
    with staged(target.parent) as folder, _installed():
        _put(diagnosis, of_diagnosis(diagnosis), note=folder / target.name)
    return target


def write_lab_report(
    diagnosis: Diagnosis,
    path: str | os.PathLike[str],
    *,
    template: str | os.PathLike[str] | None = None,
    overwrite: bool = False,
) -> Path:
    """Write a lab report with pictures beside it; see `stepid.Diagnosis.to_lab_report`."""
    target = as_path(path)
    if target.suffix not in _KINDS:
        raise InputError(f"{target}: a lab report ends in .md or .tex", "Choose by the ending: Markdown or LaTeX.")
    if not isinstance(overwrite, bool):
        raise InputError(f"overwrite is {described(overwrite)}", "Give True or False.")
    if not overwrite and os.path.lexists(target):
        remedy = "Choose another name, or give overwrite=True, which loses what its authors wrote in it."
        raise InputError(f"{target}: exists already", remedy)
    own = None if template is None else (file := as_path(template), decode(read_bytes(file), str(file)))[1]
    with staged(target.parent) as folder, _installed():
        from stepid.plot.book import save_all
        from stepid.report.lab_report import lab_report
        from stepid.report.still import stills

        hand = hand_of(diagnosis)
        drawn = stills(diagnosis, pictured(diagnosis, hand))
        # LaTeX reads # and % in a path as its own
        stem = file_names((target.stem,))[target.stem] if target.suffix == ".tex" else target.stem
        files = {name: f"{stem}-{name}.png" for name in drawn}
        told = of_diagnosis(diagnosis)
        text = lab_report(diagnosis, hand, told, kind=target.suffix, files=files, template=own)
        with TemporaryDirectory() as scratch:
            save_all(drawn, Path(scratch), dots={"png": 200})
            for name, picture in files.items():
                shutil.move(Path(scratch) / f"{name}.png", folder / picture)
        (folder / target.name).write_text(text, encoding="utf-8")
    return target


def write_all(diagnosis: Diagnosis, provenance: Provenance, folder: Path) -> None:
    """Write ``report.html``, ``report.md`` with its pictures, and the pictures as vectors in ``report-pictures.pdf``.

    Parameters
    ----------
    diagnosis : Diagnosis
    provenance : Provenance
    folder : pathlib.Path
        That exists.

    Raises
    ------
    stepid.errors.StepidError
        If a package that it needs is not installed.
    """
    with _installed():
        _put(
            diagnosis,
            provenance,
            html=folder / "report.html",
            note=folder / "report.md",
            pages=folder / "report-pictures.pdf",
        )


def check_installed(*packages: str) -> None:
    """Import what a report will need; StepidError says what to install where that cannot be."""
    with _installed():
        for package in packages:
            import_module(package)


def hand_of(diagnosis: Diagnosis) -> Hand:
    """Go the peak method's way on the campaign of a diagnosis; None where it is not known."""
    return None if diagnosis.data is None else by_hand(diagnosis.data)


def _put(
    diagnosis: Diagnosis,
    provenance: Provenance,
    *,
    html: Path | None = None,
    note: Path | None = None,
    pages: Path | None = None,
) -> None:
    """Write what has a path, with every still picture drawn once."""
    from stepid.plot.book import save_all
    from stepid.report.still import stills

    hand = hand_of(diagnosis)
    drawn = stills(diagnosis, pictured(diagnosis, hand))
    dots = {"webp": 150} if html is not None else {}  # the page shall stay small
    dots |= {"png": 200} if note is not None else {}
    with TemporaryDirectory() as scratch:
        widths = save_all(drawn, Path(scratch), dots=dots, pages=pages)
        if html is not None:
            from stepid.report.page import html_page, inlined

            page = html_page(diagnosis, hand, provenance, inlined(widths, Path(scratch)))
            html.write_text(page, encoding="utf-8")
        if note is not None:
            files = {name: f"{note.stem}-{name}.png" for name in drawn}
            for name, file in files.items():
                shutil.move(Path(scratch) / f"{name}.png", note.with_name(file))
            note.write_text(markdown(diagnosis, hand, provenance, files), encoding="utf-8")


@contextmanager
def _installed() -> Iterator[None]:
    """Say what to install where a package is missing."""
    try:
        yield
    except ModuleNotFoundError as error:
        package = (error.name or "").partition(".")[0]
        if package not in _EXTRAS:
            raise
        remedy = f"Install it with: pip install 'stepid[{_EXTRAS[package]}]'"
        raise StepidError(f"a report needs the package {package!r}", remedy) from None
