"""The report as one page that needs nothing else: no network, no other file."""

from __future__ import annotations

import base64
import gzip
import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from jinja2 import Environment, PackageLoader, StrictUndefined, select_autoescape
from markupsafe import Markup, escape
from plotly.offline import get_plotlyjs

from stepid.core.quantities import quantities_of
from stepid.core.words import capitalized, digits, length
from stepid.diagnosis.headline import advice_beside, answer, found_sizes
from stepid.diagnosis.result import Diagnosis
from stepid.diagnosis.text import standing
from stepid.diagnosis.wording import effect_names
from stepid.report.axes import run_line
from stepid.report.equation import equation, numbers
from stepid.report.hand import Hand, pictured
from stepid.report.pictures import pictures
from stepid.report.provenance import Provenance
from stepid.report.story import tell

_SIZES = 4  # of the named effects


def html_page(d: Diagnosis, hand: Hand, provenance: Provenance, stills: Mapping[str, Still]) -> str:
    """Write a diagnosis as one self-contained page.

    Parameters
    ----------
    d : Diagnosis
    hand : HandMethod, IdentificationError or None
    provenance : Provenance
    stills : mapping of str to Still

    Returns
    -------
    str
        HTML with its style, script and pictures inside.
    """
    verified = pictured(d, hand)
    environment = Environment(
        loader=PackageLoader("stepid.report", "."),
        autoescape=select_autoescape(enabled_extensions=("j2", "html")),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["typeset"] = _typeset
    environment.filters["symbols"] = _symbols
    drawn = json.dumps(pictures(d, verified.runs if verified else ()), separators=(",", ":"))
    page = environment.get_template("page.html.j2").render(
        d=d,
        answer=answer(d),
        advice=advice_beside(d),
        reasons=(*d.reasons, *standing(d)),
        equation=equation(d),
        numbers=numbers(d),
        chapters=tell(d, hand, provenance),
        tiles=_tiles(d),
        stills=stills,
        places={run.name: i for i, run in enumerate(d.runs)},
        run_line=run_line,
        plotly=_packed(get_plotlyjs()),
        pictures=_packed(drawn),
        provenance=provenance,
    )
    return quantities_of(d).keeping(source.name for source in provenance.sources).html(page)


def _typeset(text: str) -> Markup:
    """Escape, keep a number, its uncertainty and its unit on one line, and set ω_d with a low d."""
    kept = re.sub(r"(?<=\d) (?=(?:µm|mm|µrad|mrad|rad|kg|ms|s|V|A|N|%)(?:\W|$))", "\u00a0", str(escape(text)))
    return Markup(kept.replace(" ± ", "\u00a0±\u00a0").replace("ω_d", "ω<sub>d</sub>"))


def _symbols(text: str) -> Markup:
    """Escape, and set K_f with a low f."""
    return Markup(re.sub(r"_(\w)\b", r"<sub>\1</sub>", str(escape(text))))


def _packed(text: str) -> str:
    return base64.b64encode(gzip.compress(text.encode(), 9, mtime=0)).decode()


class Still(NamedTuple):
    """A still picture: its data URL, and its width in CSS pixels, 96 an inch."""

    url: str
    width: int


def inlined(widths: Mapping[str, float], folder: Path) -> dict[str, Still]:
    """Read still pictures, written as WebP, by name.

    Parameters
    ----------
    widths : mapping of str to float
        Name to width, inches.
    folder : pathlib.Path

    Returns
    -------
    dict of str to Still
    """
    found = {}
    for name, width in widths.items():
        content = base64.b64encode((folder / f"{name}.webp").read_bytes()).decode()
        found[name] = Still(f"data:image/webp;base64,{content}", round(96 * width))
    return found


def _parted(value: str) -> tuple[str, str]:
    """What stands large, and beside it; a value with its uncertainty is long for one line."""
    number, plus_minus, rest = value.partition(" ± ")
    if not plus_minus or value.startswith("("):  # with an exponent for both
        return value, ""
    spread, _, unit = rest.partition(" ")
    return f"{number} {unit}".rstrip(), f"± {spread} {unit}".rstrip()


def _of(effect: str, parameter: str) -> str:
    """A parameter of an effect, by its effect alone where that says it."""
    title = effect if effect.endswith(f" {parameter}") else f"{effect}, {parameter}"
    return capitalized(title)


def _tiles(d: Diagnosis) -> list[tuple[str, str, str]]:
    """The figures to remember: what, how much, and beside what."""

    def times(rms: float) -> str:
        return f"{digits(rms / d.gap.noise)} × noise" if d.gap.noise else ""

    sizes = [(_of(effect, parameter), *_parted(value)) for effect, parameter, value in found_sizes(d)[:_SIZES]]
    tiles = [*sizes, ("Gap, linear model", length(d.gap.before), times(d.gap.before))]
    if d.effects:
        tiles.append((f"Gap, with {effect_names(d.effects)}", length(d.gap.after), times(d.gap.after)))
        if d.gap.held_out:
            before, after = map(length, d.gap.held_out)
            tiles.append(("On runs held out", after, f"{before} before"))
    return [*tiles, ("Noise", length(d.gap.noise), f"{len(d.runs)} runs")]
