"""A plan in words and tables."""

from __future__ import annotations

import math
from collections import Counter
from html import escape
from typing import TYPE_CHECKING

from stepid.core.mass_offset import WEIGHT
from stepid.core.tables import Rows, html_table, text_table
from stepid.core.words import capitalized
from stepid.diagnosis.wording import effect_names, parameter_words
from stepid.lab.design.candidate import Design
from stepid.lab.design.separation import NEEDED, VISIBLE

if TYPE_CHECKING:
    from stepid.lab.design.result import Plan

_BEYOND_REACH = 10.0  # times too uncertain: a hundred times as many runs
_TITLE = "Best design for each number of runs (standard uncertainties)"


def one_line(plan: Plan) -> str:
    """What `repr` shows."""
    told = "suffices" if plan.suffices else "does not suffice"
    return f"Plan({len(plan.designs)} designs, advice: {plan.advice.runs} runs, {told})"


def as_text(plan: Plan) -> str:
    """The summary."""
    header, rows = _table(plan)
    return "\n".join([*sentences(plan), "", text_table(header, rows, title=_TITLE)])


def as_html(plan: Plan) -> str:
    """The summary for notebooks."""
    header, rows = _table(plan)
    return "".join(f"<p>{escape(words)}</p>" for words in sentences(plan)) + html_table(header, rows, title=_TITLE)


def sentences(plan: Plan) -> list[str]:
    """The advice, one idea a sentence."""
    design = plan.advice
    out = []
    if plan.suffices:
        out.append(f"{design.runs} runs give what is wanted.")
    else:
        out.append(
            f"None of the {len(plan.designs)} designs gives all that is wanted; {design.runs} runs come nearest."
        )
    out += [_runs(design), _sampling(design)]
    out += [_parameter(plan, design, name, limit) for name, limit in plan.wanted.items()]
    if plan.pair:
        out += _separation(plan, design)
    if not plan.suffices:
        out += _remedies(plan, design)
    return out


def per_cent(share: float) -> str:
    """A share in per cent with two digits."""
    return "not determined" if math.isinf(share) else f"{100 * share:.2g} %"


def chi_square(value: float) -> str:
    """A χ² with two digits or in whole numbers."""
    return f"{value:.0f}" if value >= 10 else f"{value:.1f}"


def words(design: Design) -> list[str]:
    """Each different run of a design, with how often it is made."""
    counted = Counter(zip(design.added_masses, design.levels, strict=True))
    return [
        f"{mass:g} kg with {level:+g} V".replace("-", "−") + (f" ({count} times)" if count > 1 else "")
        for (mass, level), count in sorted(counted.items())
    ]


def _runs(design: Design) -> str:
    return f"Runs: {', '.join(words(design))}."


def _sampling(design: Design) -> str:
    back = ", with the step back to 0 V halfway" if design.back else ""
    return f"Record each for {design.duration:.2g} s, a sample every {design.sample_time * 1e3:.3g} ms{back}."


def _parameter(plan: Plan, design: Design, name: str, limit: float) -> str:
    share = plan.relative(design, name)
    said = parameter_words(name)
    reach = "is not determined" if math.isinf(share) else f"within {per_cent(share)}"
    told = f"{capitalized(said)} {reach}, wanted {per_cent(limit)}"
    parts = design.from_noise[name], design.from_weights[name]
    if math.isfinite(share) and parts[0] is not None and parts[1] is not None:
        size = abs(plan.values[name])
        told += f" (noise {per_cent(parts[0] / size)}, weights {per_cent(parts[1] / size)})"
    return told + "."


def _separation(plan: Plan, design: Design) -> list[str]:
    pair = " and ".join(effect_names((effect.name,)) for effect in plan.pair)
    misfit, chi = design.misfit or 1.0, design.separation
    seen = "is seen" if misfit >= VISIBLE else "is not surely seen"
    out = [f"What is missing {seen}: without either effect a fit leaves {misfit:.2f} times the noise."]
    if chi is not None:
        verb = "are told apart" if chi >= NEEDED else "are not surely told apart"
        out.append(f"{pair} {verb}: the wrong one leaves {chi_square(chi)} more in χ²; {chi_square(NEEDED)} suffice.")
    return [capitalized(words) for words in out]


def _remedies(plan: Plan, design: Design) -> list[str]:
    out = []
    for name, limit in plan.wanted.items():
        weights, size = design.from_weights[name], abs(plan.values[name])
        if weights is not None and size and weights / size > limit:
            out.append(
                f"The weights alone leave {per_cent(weights / size)} of {parameter_words(name)}. Know them better than "
                f"{plan.weight_uncertainty:.2g} kg in {WEIGHT:g} kg, or add more."
            )
    if not out:
        worst = plan.shortfall(design)
        if worst < _BEYOND_REACH:
            out.append(f"It would take {worst:.2g} times less noise, or {math.ceil(worst**2)} times as many runs.")
        else:
            out.append("Other steps are needed: more of these would not do. Try other levels, masses or sample times.")
    return out


def _table(plan: Plan) -> tuple[list[str], Rows]:
    header = ["runs", "added [kg]", "levels [V]", "back", "every [ms]", *plan.wanted]
    if plan.pair:
        header += ["left/noise", "χ² apart"]
    rows = []
    for runs in sorted({design.runs for design in plan.designs}):
        design = plan.best(runs)
        row = [
            f"{runs}",
            " ".join(f"{mass:g}" for mass in sorted(set(design.added_masses))),
            " ".join(f"{level:g}" for level in sorted(set(design.levels))),
            "yes" if design.back else "no",
            f"{design.sample_time * 1e3:.3g}",
            *(per_cent(plan.relative(design, name)) for name in plan.wanted),
        ]
        if plan.pair:
            row += [f"{design.misfit or 1.0:.2f}", chi_square(design.separation or 0.0)]
        rows.append(row)
    return header, rows
