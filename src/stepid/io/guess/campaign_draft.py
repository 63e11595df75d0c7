"""A campaign in the making: what was understood of recordings, what is open, and the way on."""

from __future__ import annotations

import os
import warnings
from dataclasses import dataclass
from html import escape
from pathlib import Path

from stepid.core.experiment import Campaign
from stepid.core.tables import html_table, text_table
from stepid.errors import InputError
from stepid.io.guess.draft import Draft
from stepid.io.guess.questions import open_questions
from stepid.io.guess.read import campaign_of_drafts, folder_of
from stepid.io.guess.sources import doubts_of, is_unsure, understood
from stepid.io.guess.write import write_draft
from stepid.io.textfile import as_path

MANIFEST = "campaign.toml"
UNSURE = "What ends in ? no file says: it is taken by its size, or as usual. Check it."


def argument(key: str) -> str:
    """How an answer is given to `stepid.draft_campaign`."""
    return f"{key}=…"


@dataclass(frozen=True, repr=False)
class CampaignDraft:
    """Recordings as far as stepid understands them; made by `stepid.draft_campaign`.

    Parameters
    ----------
    name : str
        Of the campaign.
    runs : tuple of Draft
        What was found of each run, for other programs.
    left_out : tuple of str
        Which files hold no table, and why.
    """

    name: str
    runs: tuple[Draft, ...]
    left_out: tuple[str, ...] = ()

    @property
    def questions(self) -> tuple[str, ...]:
        """What no file says and nobody has said, each with the argument of `draft_campaign` that says it."""
        return tuple(f"{one.text} Give {argument(one.key)}." for one in open_questions(self.runs))

    def campaign(self) -> Campaign:
        """Read the recordings as a campaign.

        Returns
        -------
        Campaign

        Raises
        ------
        stepid.errors.InputError
            Naming all that the recordings do not say, with the arguments that say it; or the file, row and column
            that cannot be read.

        Warns
        -----
        UserWarning
            Where something of the recordings is in doubt, or files were left out.
        """
        campaign = campaign_of_drafts(
            self.runs, call=argument, name=self.name, otherwise="fill in the campaign.toml that write() makes"
        )
        if doubts := doubts_of(self.runs, self.left_out):
            warnings.warn(". ".join(doubts), UserWarning, stacklevel=2)
        return campaign

    def write(self, path: str | os.PathLike[str] | None = None) -> Path:
        """Write a commented ``campaign.toml``, as `stepid init` does; what is not known is marked ``"?"`` in it.

        Parameters
        ----------
        path : path-like, optional
            A file, or a folder for a ``campaign.toml``; beside the recordings by default.

        Returns
        -------
        pathlib.Path
            Where it was written. `stepid.read_campaign` reads it; with ``allow_outside=True`` where the recordings are
            elsewhere.

        Raises
        ------
        stepid.errors.InputError
            If there is such a file already, it cannot be written, or a name is not text.
        """
        target = folder_of(self.runs) if path is None else as_path(path)
        target = target / MANIFEST if target.is_dir() else target
        if os.path.lexists(target):
            raise InputError(f"{target}: exists already", "Give another path, or remove it first.")
        write_draft(self.runs, self.name, target)
        return target

    def summary(self) -> str:
        """Return what was understood as a table, a row a run, and below it what to check and what to say."""
        return "\n".join([text_table(*self._table(), title=self._title()), *self._remarks()])

    def __repr__(self) -> str:
        open_ = len(open_questions(self.runs))
        return f"CampaignDraft({self.name!r}, {len(self.runs)} runs, {f'{open_} open' if open_ else 'complete'})"

    __str__ = summary

    def _repr_html_(self) -> str:
        remarks = "".join(f"<p>{escape(one)}</p>" for one in self._remarks())
        return html_table(*self._table(), title=self._title()) + remarks

    def _title(self) -> str:
        return f"Recordings of campaign {self.name!r}"

    def _table(self) -> tuple[list[str], list[tuple[str, ...]]]:
        columns = understood(self.runs)
        return list(columns), list(zip(*columns.values(), strict=True))

    def _remarks(self) -> list[str]:
        doubts = doubts_of(self.runs, self.left_out)
        return [*([UNSURE] if is_unsure(self.runs) else []), *doubts, *self.questions]
