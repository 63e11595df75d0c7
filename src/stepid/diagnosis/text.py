"""A diagnosis in text and tables: the five questions in order."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from html import escape
from typing import TYPE_CHECKING

from stepid.core.estimate import Estimate
from stepid.core.mass_offset import known_in_words
from stepid.core.tables import Rows, html_table, text_table
from stepid.core.words import digits, length
from stepid.diagnosis.headline import advice_beside, answer
from stepid.diagnosis.wording import candidate_name, chance, effect_names, per_cent

if TYPE_CHECKING:
    from stepid.diagnosis.result import Diagnosis, Gap, Ranked, RunGap

SHOWN = 8
"""Candidates in the ranking."""
QUESTIONS = (
    "1. What is the noise floor?",
    "2. Where does the linear model disagree?",
    "3. Which candidates explain it?",
    "4. Is one of them it?",
    "5. What next?",
)


def one_line(d: Diagnosis) -> str:
    """What `repr` shows."""
    what = f": {', '.join(d.effects)}" if d.effects else ""
    gap = f"RMS {length(d.gap.before)}"
    if d.effects:
        gap += f" → {length(d.gap.after)}"
    return f"Diagnosis({d.campaign!r}, {d.verdict}{what}, {gap}, noise {length(d.gap.noise)})"


def standing(d: Diagnosis) -> tuple[str, ...]:
    """How far the answer goes: what it explains where it was not fitted, what is left of the motion, how sure it is."""
    said = []
    if d.effects and d.explained is not None:
        share = per_cent(d.explained) if d.explained > 0 else "none"  # what leaves more there takes less than nothing
        said.append(f"On runs left out of the fit it explains {share} of the linear model's misfit.")
    model = "The final model" if d.gap.after != d.gap.before else "The linear model"
    said.append(f"{model} leaves {d.left:.2g} % of the motion, in RMS.")
    if d.probability is not None:
        which = "one of these answers is right" if d.alternatives else "this answer is right"
        said.append(f"The probability that {which} is {chance(d.probability)}.")
    return (*said, *_of_weights(d))


def _of_weights(d: Diagnosis) -> tuple[str, ...]:
    """What the uncertainties come from, where it is mostly the weights, which nobody may have been asked about."""
    base = next((e for name, e in d.parameters.items() if name.startswith("base_mass")), None)
    if d.data is None or base is None or not base.uncertainty:
        return ()
    if base.parts.get("weights", 0.0) < base.uncertainty / math.sqrt(2):
        return ()
    heaviest = max(run.added_mass for run in d.data)
    return (
        f"Most of the base mass's uncertainty of {per_cent(base.uncertainty / base.value)} comes from the weights. "
        f"{known_in_words(heaviest, d.data.weight_uncertainty)}, by the campaign's "
        f"weight_uncertainty of {d.data.weight_uncertainty:.2g} kg. Stiffness, damping and forces share it.",
    )


def gap_rows(d: Diagnosis) -> list[tuple[str, ...]]:
    """The gap before and after: all runs, then run by run, fitted and held out."""

    def cell(value: float | None) -> str:
        return "–" if value is None else digits(1e6 * value)

    gaps: list[tuple[str, Gap | RunGap]] = [("all runs", d.gap), *((run.name, run) for run in d.runs)]
    return [
        (
            name,
            cell(gap.before),
            cell(gap.after),
            digits(gap.after / d.gap.noise) if d.gap.noise else "–",
            _taken(gap) if d.gap.after != d.gap.before else "–",
            cell(gap.held_out_before),
            cell(gap.held_out_after),
        )
        for name, gap in gaps
    ]


def _taken(gap: Gap | RunGap) -> str:
    """Share of the misfit's power that the final model takes."""
    return per_cent(1.0 - (gap.after / gap.before) ** 2) if gap.before > 0 else "–"


GAP_HEADER = (
    "RMS",
    "linear [µm]",
    "final model [µm]",
    "final/noise",
    "explained",
    "held out: linear [µm]",
    "held out: final [µm]",
)


def parameter_rows(d: Diagnosis) -> list[tuple[str, ...]]:
    """Every parameter, of the linear fit and of the final model, value ± standard uncertainty."""

    def cell(estimate: Estimate | None) -> str:
        return "–" if estimate is None else estimate.shown[0]

    return [
        (name, cell(d.linear_parameters.get(name)), *([cell(found)] if d.effects else []), found.shown[1] or "–")
        for name, found in d.parameters.items()
    ]


def parameter_header(d: Diagnosis) -> tuple[str, ...]:
    """Header of the parameter table; the linear model stands alone where nothing was added."""
    return ("parameter", "linear", "final model", "unit") if d.effects else ("parameter", "linear", "unit")


def shown_candidates(d: Diagnosis) -> list[Ranked]:
    """The best candidates, best first, and the plain linear model."""
    return [one for i, one in enumerate(d.ranking) if i < SHOWN or not (one.effects or one.deviations)]


def ranking_rows(d: Diagnosis) -> list[tuple[str, ...]]:
    """Of each candidate shown: what it explains of the linear model's misfit, what it leaves, and its probability.

    That only where one leaves little more than noise: a weight among candidates that all miss something is none.
    """
    rows = [
        (
            candidate_name(one.effects, one.deviations),
            per_cent(one.explained),
            digits(1e6 * one.rms),
            chance(one.probability),
        )
        for one in shown_candidates(d)
    ]
    return [row[: len(ranking_header(d))] for row in rows]


def ranking_header(d: Diagnosis) -> tuple[str, ...]:
    """Header of that table."""
    header = ("candidate", "explained", "RMS [µm]", "probability")
    return header if d.reaches_noise else header[:-1]


PHASE_HEADER = ("phase", "RMS [µm]")


def phase_rows(d: Diagnosis) -> list[tuple[str, ...]]:
    """RMS of the linear model's residual by phase."""
    return [(phase, digits(1e6 * rms)) for phase, rms in d.where.phases.items()]


def next_steps(d: Diagnosis) -> tuple[str, ...]:
    """What to measure next, and what to do about the effects that were named."""
    steps = () if d.next_experiment is None else (d.next_experiment,)
    if d.verdict == "adequate" and not steps:
        return ("Nothing more shows at this noise. Less noise or larger steps would show smaller effects.",)
    if d.verdict != "named":
        return steps
    advice = tuple(f"{effect_names((name,))}: {said}." for name, said in d.advice.items())
    return (*steps, *advice) or ("Keep the effect in the model.",)


_Table = Callable[[Sequence[str], Rows], str]


def _answers(d: Diagnosis, table: _Table) -> tuple[tuple[Sequence[str], Sequence[str]], ...]:
    """To each question: sentences, then tables ready to show."""
    times = f", {digits(d.gap.before / d.gap.noise)} times as much" if d.gap.noise else ""
    floor = f"{length(d.gap.noise)} RMS. The linear joint fit leaves {length(d.gap.before)}{times}."
    return (
        ((floor,), ()),
        (d.where.sentences, (table(PHASE_HEADER, phase_rows(d)),)),
        ((), (table(ranking_header(d), ranking_rows(d)),) if d.ranking else ()),
        ((*d.reasons, *standing(d)), (table(GAP_HEADER, gap_rows(d)), table(parameter_header(d), parameter_rows(d)))),
        ((*next_steps(d), *(f"Note: {note}" for note in d.notes)), ()),
    )


def as_text(d: Diagnosis) -> str:
    """What `summary` returns."""
    head = [f"Diagnosis of campaign {d.campaign!r}: {d.verdict}", answer(d), advice_beside(d)]
    parts = ["\n".join(filter(None, head))]
    for question, (said, tables) in zip(QUESTIONS, _answers(d, text_table), strict=True):
        lines = [f"   - {sentence}" for sentence in said] or ([] if tables else ["   - nothing to say"])
        parts.append("\n".join([question, *lines]))
        parts += ["\n".join(f"   {line}".rstrip() for line in table.splitlines()) for table in tables]
    return "\n\n".join(parts)


def as_html(d: Diagnosis) -> str:
    """The same for notebooks."""
    head = "<br>".join(map(escape, filter(None, (answer(d), advice_beside(d)))))
    parts = [f"<p><b>Diagnosis of campaign {escape(repr(d.campaign))}: {d.verdict}</b><br>{head}</p>"]
    for question, (said, tables) in zip(QUESTIONS, _answers(d, html_table), strict=True):
        parts.append(f"<p><b>{escape(question)}</b></p>")
        if said:
            parts.append("<ul>" + "".join(f"<li>{escape(sentence)}</li>" for sentence in said) + "</ul>")
        parts += tables
    return "".join(parts)
