"""A diagnosis written to files."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, cast

from stepid.core.base import Model

if TYPE_CHECKING:
    from stepid.diagnosis.result import Diagnosis


class Written(Model):
    """The part of a diagnosis that writes it; what makes the pages is loaded when it is called."""

    def to_html(self, path: str | os.PathLike[str]) -> Path:
        """Write the whole story as one page with pictures to point into, which needs no network.

        Parameters
        ----------
        path : path-like

        Returns
        -------
        pathlib.Path
            Where it was written.

        Raises
        ------
        stepid.errors.InputError
            If the file cannot be written.
        stepid.errors.StepidError
            If a package that it needs is not installed.
        """
        from stepid.report.write import write_html

        return write_html(cast("Diagnosis", self), path)

    def to_markdown(self, path: str | os.PathLike[str]) -> Path:
        """Write the whole story as Markdown for a lab notebook, with its pictures as PNG files beside it.

        Parameters
        ----------
        path : path-like

        Returns
        -------
        pathlib.Path
            Where the text was written.

        Raises
        ------
        stepid.errors.InputError
            If a file cannot be written.
        stepid.errors.StepidError
            If a package that it needs is not installed.
        """
        from stepid.report.write import write_markdown

        return write_markdown(cast("Diagnosis", self), path)

    def to_lab_report(
        self,
        path: str | os.PathLike[str],
        *,
        template: str | os.PathLike[str] | None = None,
        overwrite: bool = False,
    ) -> Path:
        """Write a lab report to be finished by its authors, in Markdown or LaTeX, with its pictures beside it.

        Model, measurements, tables, pictures and where they come from are filled in; questions stand where the authors
        have to think.

        Parameters
        ----------
        path : path-like
            Ends in ``.md`` or ``.tex``.
        template : path-like, optional
            A jinja2 template of your own; see the page on reports.
        overwrite : bool
            Replace the file if there is one, with all that its authors wrote in it.

        Returns
        -------
        pathlib.Path
            Where the text was written.

        Raises
        ------
        stepid.errors.InputError
            If the path has another ending, exists already or cannot be written, or the template is wrong.
        stepid.errors.StepidError
            If a package that it needs is not installed.
        """
        from stepid.report.write import write_lab_report

        return write_lab_report(cast("Diagnosis", self), path, template=template, overwrite=overwrite)
