"""A picture in the page: plotly's JSON, drawn in the page's colors, read by the keyboard."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import param
from panel.custom import JSComponent

_HERE = Path(__file__).parent
_STYLE = """
:host { display: block; width: 100%; min-width: 0; }
.plot { position: relative; border-radius: 4px; min-width: 0; }
.plot:focus-visible { outline: 3px solid var(--accent); outline-offset: 2px; }
.svg-container { position: relative; overflow: hidden; }
.main-svg { position: absolute; top: 0; left: 0; pointer-events: none; overflow: hidden; }
.main-svg:first-child { position: static; display: block; }
.main-svg .draglayer { pointer-events: all; }
.nsewdrag { cursor: crosshair; }
.ewdrag { cursor: ew-resize; }
.nsdrag { cursor: ns-resize; }
.select-outline { fill: none; }
.unseen { position: absolute; width: 1px; height: 1px; overflow: hidden; clip-path: inset(50%); white-space: nowrap; }
"""


class Picture(JSComponent):
    """A figure; `label` says in words what it shows."""

    figure = param.Dict(default={})
    label = param.String(default="A picture.")

    _esm = (_HERE / "picture.js").read_text(encoding="utf-8")
    _stylesheets = [_STYLE]  # noqa: RUF012  # as Panel has it


def picture(figure: dict[str, Any], label: str) -> Picture:
    """Show a figure, as wide as there is room."""
    return Picture(figure=figure, label=label, sizing_mode="stretch_width", margin=0)
