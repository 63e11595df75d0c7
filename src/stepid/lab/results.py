"""The checks of a whole class in one table."""

from __future__ import annotations

from collections.abc import Iterable

from stepid.core.base import Model
from stepid.core.tables import html_table, text_table
from stepid.core.takes import a, each, takes
from stepid.effects import CATALOGUE, Effect
from stepid.errors import InputError
from stepid.lab.answers import Answers, in_words
from stepid.lab.checks import Check
from stepid.lab.marking import check
from stepid.lab.submission import Submission, a_submission

_HEADER = ("group", "hidden", "named", "close", "inside", "verdict")
_TITLE = "Results"


class Results(Model):
    """The checks of a class.

    Parameters
    ----------
    checks : tuple of Check
        In the order of the groups.
    hidden, named : tuple of str
        For each check: what was hidden and what was named, in words.
    missing : tuple of str
        Groups that have handed in nothing.
    """

    checks: tuple[Check, ...]
    hidden: tuple[str, ...]
    named: tuple[str, ...]
    missing: tuple[str, ...] = ()

    def __getitem__(self, group: str) -> Check:
        """Return a group's check; InputError names the groups there are."""
        for one in self.checks:
            if one.group == group:
                return one
        raise InputError(
            f"group {group!r} has handed in nothing" if group in self.missing else f"there is no group {group!r}",
            f"Checked are: {', '.join(repr(c.group) for c in self.checks)}.",
        )

    def records(self) -> list[dict[str, str | int | bool]]:
        """Return one dictionary a group, ready for ``pandas.DataFrame(results.records())`` or a CSV writer."""
        rows: list[dict[str, str | int | bool]] = [
            {
                "group": one.group,
                "hidden": hidden,
                "named": named,
                "naming": one.naming,
                "close": one.close,
                "inside": one.inside,
                "parameters": len(one.counted),
                "passed": one.passed,
            }
            for one, hidden, named in zip(self.checks, self.hidden, self.named, strict=True)
        ]
        return rows

    def _rows(self) -> list[tuple[str, ...]]:
        rows: list[tuple[str, ...]] = [
            (
                one.group,
                hidden,
                named,
                f"{one.close}/{len(one.counted)}",
                f"{one.inside}/{len(one.counted)}",
                f"{'passed' if one.passed else 'not passed'}, naming {one.naming}",
            )
            for one, hidden, named in zip(self.checks, self.hidden, self.named, strict=True)
        ]
        return rows + [(group, "–", "–", "–", "–", "nothing handed in") for group in self.missing]

    def summary(self) -> str:
        """Return the table of the class."""
        return text_table(_HEADER, self._rows(), title=_TITLE)

    def __repr__(self) -> str:
        passed = sum(one.passed for one in self.checks)
        return f"Results({passed} of {len(self.checks)} passed, {len(self.missing)} missing)"

    __str__ = summary

    def _repr_html_(self) -> str:
        return html_table(_HEADER, self._rows(), title=_TITLE)


@takes(
    answers=a(Answers, "the Answers of stepid.lab.open_answers"),
    submissions=each(a_submission, "submissions, as stepid.lab.read_submissions returns them"),
)
def check_all(
    answers: Answers,
    submissions: Iterable[Submission],
    *,
    tolerance: float = 0.05,
    catalogue: tuple[Effect, ...] = CATALOGUE,
) -> Results:
    """Check what the groups of a class handed in.

    Parameters
    ----------
    answers : Answers
    submissions : iterable of Submission
        At most one a group.
    tolerance : float
        Relative, as in `check`.
    catalogue : tuple of Effect
        Where names of effects are looked up.

    Returns
    -------
    Results

    Raises
    ------
    stepid.errors.InputError
        If a group has handed in twice or does not exist, and for what `check` refuses.
    """
    by_group: dict[str, Submission] = {}
    for submission in submissions:
        answers[submission.group]  # refuses a group that does not exist
        if submission.group in by_group:
            raise InputError(f"group {submission.group!r} has handed in twice", "Keep the one that counts.")
        by_group[submission.group] = submission
    given = [group for group in answers.groups if group in by_group]
    return Results(
        checks=tuple(check(answers[g], by_group[g], tolerance=tolerance, catalogue=catalogue) for g in given),
        hidden=tuple(answers[g].names for g in given),
        named=tuple(in_words(by_group[g].effects) for g in given),
        missing=tuple(group for group in answers.groups if group not in by_group),
    )
