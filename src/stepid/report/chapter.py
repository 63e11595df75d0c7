"""What a report is made of: chapters of sentences, pictures and tables, the same on a page and in Markdown."""

from __future__ import annotations

from stepid.core.base import Label, Model


class Table(Model):
    """A table; the first column names the row.

    Parameters
    ----------
    caption : str
    header : tuple of str
        With units.
    rows : tuple of tuple of str
    words : tuple of int
        Columns that hold words, not numbers; the first one always does.
    """

    caption: Label
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    words: tuple[int, ...] = ()


class Picture(Model):
    """A picture that one can point into, with a still one in its place on paper.

    Parameters
    ----------
    name : str
        Of the interactive picture, or what those of the runs begin with.
    title : str
    alt : str
        What it shows, in words.
    still : str
        Name of the still picture, empty where another picture of the chapter stands for it.
    runs : tuple of str
        Where there is one picture a run.
    beside : tuple of str
        The figures of each run in a few letters.
    said : tuple of str
        What each of those pictures shows.
    key : tuple of tuple of str
        Sort of line and what it means, where the picture itself does not say so.
    wide : bool
        Needs the whole width of the page.
    """

    name: Label
    title: Label
    alt: Label
    still: str = ""
    runs: tuple[str, ...] = ()
    beside: tuple[str, ...] = ()
    said: tuple[str, ...] = ()
    key: tuple[tuple[str, str], ...] = ()
    wide: bool = True


class Chapter(Model):
    """One part of the story.

    Parameters
    ----------
    name : str
        For links.
    title : str
    lead : str
        First sentences.
    points : tuple of str
        Further ones, as a list.
    pictures : tuple of Picture
    tables : tuple of Table
    folded : bool
        Details that a page shows when they are asked for.
    """

    name: Label
    title: Label
    lead: str = ""
    points: tuple[str, ...] = ()
    pictures: tuple[Picture, ...] = ()
    tables: tuple[Table, ...] = ()
    folded: bool = False
