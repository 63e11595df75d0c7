"""Write a report to files: whole or not at all."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from stepid.diagnose.result import Diagnosis
from stepid.errors import StepidError
from stepid.report.folder import staged
from stepid.report.hand import HandMethod, by_hand
from stepid.report.markdown import markdown
from stepid.report.provenance import Provenance, of_data
from stepid.report.story import Hand
from stepid.textfile import as_path

if TYPE_CHECKING:
    from stepid.report.still import Stills

_EXTRAS = {"jinja2": "report", "markupsafe": "report", "plotly": "report", "matplotlib": "plot"}


def write_html(diagnosis: Diagnosis, path: str | os.PathLike[str]) -> Path:
    """Write a diagnosis as one self-contained page; see `stepid.Diagnosis.to_html`."""
    target = as_path(path)
    with staged(target.parent) as folder, _installed():
        _put_html(diagnosis, hand_of(diagnosis), of_data(diagnosis), folder / target.name)
    return target


def write_markdown(diagnosis: Diagnosis, path: str | os.PathLike[str]) -> Path:
    """Write a diagnosis as Markdown with pictures beside it; see `stepid.Diagnosis.to_markdown`."""
    target = as_path(path)
    with staged(target.parent) as folder, _installed():
        _put_markdown(diagnosis, hand_of(diagnosis), of_data(diagnosis), folder / target.name)
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
    hand = hand_of(diagnosis)
    with _installed():
        _put_html(diagnosis, hand, provenance, folder / "report.html")
        _put_markdown(diagnosis, hand, provenance, folder / "report.md")
        from stepid.plot.book import save_pages

        drawn = _stills(diagnosis, hand).values()
        save_pages(drawn, folder / "report-pictures.pdf", title=f"{diagnosis.campaign}: diagnosis")


def hand_of(diagnosis: Diagnosis) -> Hand:
    """Go the hand method's way on the campaign of a diagnosis; None where it is not known."""
    return None if diagnosis.data is None else by_hand(diagnosis.data)


def _put_html(diagnosis: Diagnosis, hand: Hand, provenance: Provenance, path: Path) -> None:
    from stepid.report.page import html_page

    path.write_text(html_page(diagnosis, hand, provenance), encoding="utf-8")


def _put_markdown(diagnosis: Diagnosis, hand: Hand, provenance: Provenance, path: Path) -> None:
    from stepid import plot

    drawn = _stills(diagnosis, hand)
    files = {name: plot.save(draw(), path.with_name(f"{path.stem}-{name}.png")).name for name, draw in drawn.items()}
    path.write_text(markdown(diagnosis, hand, provenance, files), encoding="utf-8")


def _stills(diagnosis: Diagnosis, hand: Hand) -> Stills:
    from stepid.report.still import stills

    return stills(diagnosis, hand.verified if isinstance(hand, HandMethod) else None)


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
