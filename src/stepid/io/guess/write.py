"""Drafts as a file: a commented campaign.toml, whole or not at all."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from stepid.core.atomic_write import staged
from stepid.errors import InputError
from stepid.io.guess.draft import Draft
from stepid.io.guess.manifest_text import manifest_text


def manifest_bytes(drafts: Sequence[Draft], name: str, folder: Path) -> bytes:
    """Content of a manifest in `folder`; InputError where a name is no text, as old file systems have them."""
    try:
        return manifest_text(drafts, name, folder).encode()
    except UnicodeEncodeError as error:
        names = [name, *(text for d in drafts for text in (d.file.name, d.name, *d.titles.values(), *d.choices))]
        odd = next((text for text in names if text != text.encode(errors="replace").decode()), str(drafts[0].file))
        raise InputError(f"{odd!r}: a name is not text ({error.reason})", "Rename it.") from None


def write_draft(drafts: Sequence[Draft], name: str, target: Path) -> None:
    """Write a manifest; one that is there is replaced when the new one is on the disk.

    Parameters
    ----------
    drafts : sequence of Draft
    name : str
        Of the campaign.
    target : pathlib.Path
        In a folder that exists.

    Raises
    ------
    stepid.errors.InputError
        If a name is not text, or the file cannot be written.
    """
    content = manifest_bytes(drafts, name, target.parent)
    if not target.parent.is_dir():
        raise InputError(f"{target}: cannot be written (there is no such folder)", "Make it, or give another path.")
    with staged(target.parent) as folder:
        (folder / target.name).write_bytes(content)
