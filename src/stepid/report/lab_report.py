"""A lab report to be finished by its authors: a template in Markdown or LaTeX, filled from a diagnosis."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any
from urllib.parse import quote

from jinja2 import StrictUndefined, TemplateError
from jinja2.loaders import DictLoader, PackageLoader
from jinja2.sandbox import SandboxedEnvironment

from stepid.core.latex import escaped
from stepid.core.quantities import quantities_of
from stepid.diagnosis.headline import advice_beside, answer
from stepid.diagnosis.result import Diagnosis
from stepid.diagnosis.wording import effect_names
from stepid.effects import CATALOGUE
from stepid.errors import InputError
from stepid.report.chapter import Table
from stepid.report.hand import Hand
from stepid.report.markdown import markdown_table, plain
from stepid.report.provenance import Provenance
from stepid.report.story import tell

_WIDE = 78  # letters of a row of a LaTeX table, beyond which it is made to fit the line
_LATEX = {
    "block_start_string": "((*",
    "block_end_string": "*))",
    "variable_start_string": "(((",
    "variable_end_string": ")))",
    "comment_start_string": "((=",
    "comment_end_string": "=))",
}


class _Typeset(str):
    """Text that is markup already."""


def lab_report(
    d: Diagnosis,
    hand: Hand,
    provenance: Provenance,
    *,
    kind: str,
    files: Mapping[str, str],
    template: str | None = None,
) -> str:
    """Fill the template of a lab report.

    Parameters
    ----------
    d : Diagnosis
    hand : HandMethod, IdentificationError or None
    provenance : Provenance
    kind : ".md" or ".tex"
    files : mapping
        Name of a still picture to its file beside the text; for LaTeX without spaces and signs.
    template : str, optional
        A jinja2 template in place of stepid's own. In LaTeX it writes ``((* … *))`` for blocks and ``((( … )))`` for
        values.

    Returns
    -------
    str

    Raises
    ------
    stepid.errors.InputError
        If the template is wrong.
    """
    name = f"lab-report{kind}.j2"
    latex = kind == ".tex"
    environment = SandboxedEnvironment(
        loader=PackageLoader("stepid.report", ".") if template is None else DictLoader({name: template}),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        finalize=lambda value: value if isinstance(value, _Typeset) else (escaped if latex else plain)(str(value)),
        keep_trailing_newline=True,
        **(_LATEX if latex else {}),
    )
    environment.filters["table"] = _latex_table if latex else lambda table: _Typeset(markdown_table(table))
    linked = files if latex else {picture: quote(file) for picture, file in files.items()}
    try:
        return environment.get_template(name).render(_values(d, hand, provenance, linked))
    except (TemplateError, TypeError) as error:
        where = f", line {line}" if (line := getattr(error, "lineno", None)) else ""
        raise InputError(f"the template of the lab report{where}: {error}", "Correct the template.") from None


def _values(d: Diagnosis, hand: Hand, provenance: Provenance, files: Mapping[str, str]) -> dict[str, Any]:
    """What a template can use."""
    own = quantities_of(d)
    laws = {effect.name: _Typeset(own.formula(effect.formula)) for effect in CATALOGUE}
    return {
        "d": d,
        "campaign": d.campaign,
        "answer": own.text(answer(d)),
        "advice": own.text(advice_beside(d)),
        "say": lambda words: _Typeset(own.text(words)),
        "formula": lambda latex: _Typeset(own.formula(latex)),
        "effects": effect_names(d.effects),
        "laws": [(effect_names((name,)), laws[name]) for name in d.effects if name in laws],
        "chapters": {chapter.name: chapter for chapter in tell(d, hand, provenance)},
        "pictures": {name: _Typeset(file) for name, file in files.items()},
        "parameters": _Typeset(d.to_latex()),
    }


def _latex_table(table: Table) -> _Typeset:
    columns = "".join("l" if i == 0 or i in table.words else "r" for i in range(len(table.header)))
    rows = [" & ".join(map(escaped, cells)) + r" \\" for cells in (table.header, *table.rows)]
    lines = [rf"\begin{{tabular}}{{{columns}}}", r"\hline", rows[0], r"\hline", *rows[1:], r"\hline", r"\end{tabular}"]
    widths = (max(map(len, cells)) for cells in zip(table.header, *table.rows, strict=True))
    if sum(widths) + 2 * len(columns) > _WIDE:
        lines = [r"\resizebox{\linewidth}{!}{%", *lines, "}"]
    head = [r"\begin{table}[htbp]", r"\centering", rf"\caption{{{escaped(table.caption)}}}"]
    return _Typeset("\n".join([*head, *lines, r"\end{table}"]))
