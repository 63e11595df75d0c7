"""The layout of ECP exports: where header and rows are, in every variant that is about."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stepid.core.base import Array
from stepid.core.takes import described
from stepid.errors import InputError
from stepid.io.textfile import common_width, is_number, parse_numbers

SAMPLE, TIME, COMMANDED, EFFORT = "Sample", "Time", "Commanded Pos", "Control Effort"
_KNOWN = re.compile(
    r"\b(?:(?P<sample>sample)|(?P<time>time)|(?P<commanded>commanded\s+pos(?:ition)?)"
    r"|encoder\s+(?P<encoder>\d+)\s+pos(?:ition)?|(?P<effort>control\s+effort))\b",
    re.IGNORECASE,
)
_MOST = 0.9  # of the rows: a damaged one is told by its line
AGAIN = "Export the record again, or restore the line from the original file."


def encoder_column(number: int) -> str:
    """Return the column name of an encoder."""
    return f"Encoder {number} Pos"


def is_encoder(column: str) -> bool:
    """Tell whether a column is an encoder's: "Encoder 1 Pos"."""
    return re.fullmatch(r"Encoder \d+ Pos", column) is not None


@dataclass(frozen=True)
class Export:
    """An export's rows: column names, values of shape (n, columns), file line of each row."""

    columns: tuple[str, ...]
    values: Array
    lines: Sequence[int]
    time_resolution: float  # s, the last printed digit of Time
    tabbed: bool  # the newer program: tab-separated, no brackets, effort in DAC units

    def __contains__(self, column: str) -> bool:
        return column in self.columns

    def get(self, column: str) -> Array | None:
        """Return a column, or None where it is missing."""
        return self[column] if column in self.columns else None

    def __getitem__(self, column: str) -> Array:
        values: Array = self.values[:, self.columns.index(column)]
        return values


def parse_export(lines: Sequence[str], *, columns: Sequence[str] | None, where: str) -> Export:
    """Find header and rows of an export and parse them.

    Parameters
    ----------
    lines : sequence of str
        The file.
    columns : sequence of str or None
        Column names stated by the caller; None takes them from the header.
    where : str
        The file, for errors.

    Raises
    ------
    stepid.errors.InputError
        Naming file, line and column, if the layout is not an export's, is cut off or leaves open which column is which.
    """
    preamble, rows, numbers, bracketed = _split(lines, where)
    header = next((found for line in reversed(preamble) if len(found := _names(line)) > 1), ())
    names_given = () if columns is None or not isinstance(columns, Sequence) else columns
    width = _width(rows, names_given or header)
    if columns is not None:
        names = _stated(columns, width, where)
    elif header:
        names = _matching(header, width, where)
    else:
        names = ()
    # without names the columns are numbered while parsing and recognized by their content afterwards
    labels = names or tuple(f"{i + 1}" for i in range(width))
    values = parse_numbers(rows, lines=numbers, columns=labels, where=where, remedy=AGAIN)
    names = names or _recognized(rows, values, where)
    if (huge := np.argwhere(np.abs(values) >= 1e15)).size:
        row, column = huge[0]
        raise InputError(
            f"{where}, line {numbers[row]}, column {names[column]!r}: {values[row, column]:g} is no believable reading",
            AGAIN,
        )
    resolution = _resolution([row[names.index(TIME)] for row in rows]) if TIME in names else 0.0
    tabbed = not bracketed and any("\t" in line for line in preamble)
    return Export(names, values, numbers, resolution, tabbed)


def _split(lines: Sequence[str], where: str) -> tuple[list[str], list[list[str]], list[int], bool]:
    """The lines that may hold the header, the rows and their line numbers, and whether brackets enclose the rows."""
    start = next((i for i, line in enumerate(lines) if _opens(line)), None)
    if start is None:
        return *_split_bare(lines, where), False
    bracket = lines[start].partition("%")[0].rindex("[")
    before, first = lines[start][:bracket], lines[start][bracket + 1 :]
    preamble = [*lines[:start], before]
    for number, line in enumerate(preamble, 1):
        if _numeric(line):
            raise InputError(f"{where}, line {number}: numbers before the opening bracket", AGAIN)
    remarks, rows, end = _enclosed([first, *lines[start + 1 :]], start + 1, where)
    for number, line in enumerate(lines[end:], end + 1):
        if _numeric(line) or _opens(line):
            raise InputError(
                f"{where}, line {number}: numbers after the closing bracket of line {end}", "Keep one record a file."
            )
    if not rows:
        raise InputError(f"{where}, line {start + 1}: no rows between the brackets", AGAIN)
    return [*preamble, *remarks], list(rows.values()), list(rows), True


def _enclosed(lines: Sequence[str], opening: int, where: str) -> tuple[list[str], dict[int, list[str]], int]:
    """Comments and header from the opening bracket to the closing one, the rows by line number, the closing line."""
    remarks: list[str] = []
    rows: dict[int, list[str]] = {}
    for number, line in enumerate(lines, opening):
        body, _, comment = line.partition("%")
        if comment:
            remarks.append(comment)
        elif not rows and len(_names(body)) > 1:  # the header may have slipped behind the bracket
            remarks.append(body)
            continue
        body, closing, rest = body.strip().partition("]")
        if rest.strip(" \t;"):
            raise InputError(f"{where}, line {number}: {rest.strip()[:24]!r} follows the closing bracket", AGAIN)
        if row := body.strip().removesuffix(";").split():
            rows[number] = row
        if closing:
            return remarks, rows, number
    raise InputError(f"{where}, line {max(rows, default=opening)}: no closing bracket; cut off", AGAIN)


def _split_bare(lines: Sequence[str], where: str) -> tuple[list[str], list[list[str]], list[int]]:
    header = next((i for i, line in enumerate(lines) if len(_names(line)) > 1), -1)
    body = [(i + 1, text) for i in range(header + 1, len(lines)) if (text := lines[i].partition("%")[0].strip())]
    if header < 0:  # at most a file name or `name =` may stand above rows without a header
        body = body[1:] if body and not _numeric(body[0][1]) and len(body[0][1].split()) < 3 else body
    for number, text in body:
        if "]" in text or "[" in text:
            raise InputError(f"{where}, line {number}: a bracket without its partner; the start is cut off", AGAIN)
    if not any(_numeric(text) for _, text in body):
        raise InputError(
            f"{where}: holds no rows of numbers",
            "Give an ECP export; for CSV or another table use read_table, or "
            'format = "table" in the run of the manifest with its columns.',
        )
    rows = [text.removesuffix(";").split() for _, text in body]
    return list(lines[: header + 1]), rows, [number for number, _ in body]


def _opens(line: str) -> bool:
    before, bracket, after = line.partition("%")[0].rpartition("[")
    alone = not before.strip() or before.rstrip().endswith("=") or not after.strip()
    return bool(bracket) and (alone or _numeric(after))


def _numeric(line: str) -> bool:
    tokens = line.replace("[", " ").replace("]", " ").replace(";", " ").split()
    return len(tokens) > 2 and is_number(tokens[0]) and is_number(tokens[1])


def _names(line: str) -> tuple[str, ...]:
    """Column names of a header line; empty where no known name is in it."""
    line = line.strip().lstrip("%").strip()
    if "/" in line or "\\" in line or not _KNOWN.search(line):  # a file name may hold such words, too
        return ()
    names: list[str] = []
    end = 0
    for match in _KNOWN.finditer(line):
        names += _unknown(line[end : match.start()])
        names.append(_canonical(match))
        end = match.end()
    return (*names, *_unknown(line[end:]))


def _unknown(text: str) -> list[str]:
    return [name.strip() for name in re.split(r"\t|\s{2,}", text) if name.strip()]


def _canonical(match: re.Match[str]) -> str:
    if match["encoder"]:
        return encoder_column(int(match["encoder"][:9]))
    return {"sample": SAMPLE, "time": TIME, "commanded": COMMANDED, "effort": EFFORT}[match.lastgroup or ""]


def _width(rows: Sequence[Sequence[str]], names: Sequence[str]) -> int:
    # a damaged row must not pass for the layout: the header's width counts as soon as one row agrees with it
    return len(names) if any(len(row) == len(names) for row in rows) else common_width(rows)


def _stated(columns: Sequence[str], width: int, where: str) -> tuple[str, ...]:
    listed = isinstance(columns, Sequence) and not isinstance(columns, str | bytes)
    if not listed or not all(isinstance(name, str) for name in columns):
        raise InputError(f"{where}: columns is {described(columns)}", "Give a tuple of column names, one a column.")
    matches = [(name, _KNOWN.fullmatch(name.strip())) for name in columns]
    names = tuple(_canonical(match) if match else name.strip() for name, match in matches)
    if len(names) != width:
        raise InputError(
            f"{where}: columns states {len(names)} names, the rows hold {width} numbers", "Name every column in order."
        )
    return _distinct(names, where)


def _matching(header: tuple[str, ...], width: int, where: str) -> tuple[str, ...]:
    if len(header) != width:
        raise InputError(
            f"{where}: its header names {len(header)} columns ({', '.join(header)}) over {width} numbers a row",
            f"Which columns are there? State all {width} with columns=('Sample', 'Time', …).",
        )
    return _distinct(header, where)


def _distinct(names: tuple[str, ...], where: str) -> tuple[str, ...]:
    twice = [name for name in names if names.count(name) > 1]
    if twice:
        raise InputError(f"{where}: column {twice[0]!r} is named twice", "State the columns with columns=(…).")
    return names


def _recognized(rows: Sequence[Sequence[str]], values: Array, where: str) -> tuple[str, ...]:
    """Names of the columns of a file without header, where its content leaves no doubt about them.

    It leaves none where, in a known set of columns, Sample counts up, encoders read whole counts, and Commanded Pos
    visibly repeats Encoder 1; Control Effort is the one that is printed with decimals.
    """
    width = values.shape[1]
    effort = all("." in row[-1] for row in rows)
    known = {
        (5, True): (SAMPLE, TIME, COMMANDED, encoder_column(1), EFFORT),
        (6, True): (SAMPLE, TIME, COMMANDED, encoder_column(1), encoder_column(2), EFFORT),
        (6, False): (SAMPLE, TIME, COMMANDED, *map(encoder_column, (1, 2, 3))),
    }.get((width, effort))
    if known is None or not _fits(known, values):
        raise InputError(
            f"{where}: no header says what its {width} columns are",
            f"State all {width} with columns=('Sample', 'Time', …); positions in other units than counts "
            "are for read_table.",
        )
    return known


def _fits(known: Sequence[str], values: Array) -> bool:
    """Say whether columns hold what an export's do: any table of this width may have two columns that are alike."""
    columns = dict(zip(known, values.T, strict=True))
    sample, time, encoder = (columns[name] for name in (SAMPLE, TIME, encoder_column(1)))
    if np.unique(encoder).size <= 10:  # it hardly moves, or there is one row
        return False
    counted = [sample, *(readings for name, readings in columns.items() if is_encoder(name))]
    whole = all(np.mean(readings == np.rint(readings)) > _MOST for readings in counted)
    rises = np.mean(np.diff(sample) > 0) > _MOST and np.mean(np.diff(time) >= 0) > _MOST
    return bool(whole and rises and repeats(columns[COMMANDED], encoder))


def repeats(commanded: Array, encoder: Array) -> bool:
    """Say whether Commanded Pos only repeats the encoder, within a sample's travel and two counts."""
    low = np.minimum(encoder[1:], encoder[:-1]) - 2
    high = np.maximum(encoder[1:], encoder[:-1]) + 2
    return bool(np.mean((commanded[1:] >= low) & (commanded[1:] <= high)) > _MOST)


def _resolution(tokens: Sequence[str]) -> float:
    # exponents do not occur in exports; were one to, its mantissa's digits say nothing, so claim no rounding
    decimals = max(15 if "e" in token.lower() else len(token.partition(".")[2]) for token in tokens)
    return float(10.0 ** -min(decimals, 15))
