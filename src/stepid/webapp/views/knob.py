"""A knob in the page."""

from __future__ import annotations

from pathlib import Path

import param
from panel.custom import JSComponent

from stepid.webapp import play

_STYLE = """
:host { display: block; min-width: 0; }
label { display: block; font-size: 0.92rem; color: var(--ink); }
span { display: block; }
output { font-weight: 650; font-variant-numeric: tabular-nums; }
input { width: 100%; margin: 0.2rem 0; accent-color: var(--accent); height: 1.4rem; cursor: pointer; }
input:focus-visible { outline: 3px solid var(--accent); outline-offset: 1px; border-radius: 3px; }
"""


class Knob(JSComponent):
    """A slider with its name and its value, which is shown divided by `scale`."""

    label = param.String(default="")
    start = param.Number(default=0.0)
    end = param.Number(default=1.0)
    step = param.Number(default=0.01)
    value = param.Number(default=0.0)
    scale = param.Number(default=1.0)

    _esm = Path(__file__).with_suffix(".js").read_text(encoding="utf-8")
    _stylesheets = [_STYLE]  # noqa: RUF012  # as Panel has it


def knob(one: play.Knob) -> Knob:
    """Show a knob."""
    return Knob(
        label=one.label,
        start=one.low,
        end=one.high,
        step=one.step,
        value=one.value,
        scale=one.scale,
        sizing_mode="stretch_width",
        margin=0,
    )
