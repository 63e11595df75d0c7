"""Golden images of all figures: pictures without words, and the words. ``python tests/golden_images.py`` makes them.

Words are compared exactly, as text. What is left of a picture without them (curves, dots, bars, ticks, spines) lies
where the data say, not where a font leaves room: text is hidden, tick labels are emptied and the layout is that of the
grid. So no font decides, and matplotlib 3.8 to 3.11 with freetype 2.6 to 2.14 draw the same, to the last level.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib import image
from matplotlib import pyplot as plt
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.ticker import NullFormatter

from figure_cases import CASES

FOLDER = Path(__file__).parent / "golden"
WORDS = FOLDER / "words.json"
DOTS = 72  # an inch
TILE = 16  # pixels
TOLERANCE = 2.0  # levels of 255: an edge that moves by a fiftieth of a pixel; a missing curve leaves 4.5 and more


def words(figure: Figure) -> list[object]:
    """Everything written in a figure but the numbers at its ticks."""

    def legend(of: Axes | Figure) -> list[list[str]]:
        found = of.legends if isinstance(of, Figure) else [of.get_legend()] if of.get_legend() else []
        return [[text.get_text() for text in one.get_texts()] for one in found]

    out: list[object] = [{"title": figure.get_suptitle(), "legend": legend(figure)}]
    for one in figure.axes:
        said = {
            "title": one.get_title(loc="left").strip(),
            "x": one.get_xlabel(),
            "y": one.get_ylabel(),
            "legend": legend(one),
            "texts": [text.get_text() for text in one.texts],
        }
        out.append({key: value for key, value in said.items() if value})
    return out


def pixels(figure: Figure) -> np.ndarray:
    """A figure without its words as gray levels and colors from 0 to 255, shape (height, width, 3)."""
    figure.set_layout_engine("none")
    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_formatter(NullFormatter())
            axis.set_minor_formatter(NullFormatter())
        if axes.get_legend() is not None:
            axes.get_legend().set_visible(False)
    for legend in figure.legends:
        legend.set_visible(False)
    for text in figure.findobj(Text):
        text.set_visible(False)
    figure.set_dpi(DOTS)
    return render(figure)


def render(figure: Figure) -> np.ndarray:
    """A figure as it is, shape (height, width, 3)."""
    figure.canvas.draw()
    return np.asarray(figure.canvas.buffer_rgba())[..., :3].astype(float)  # type: ignore[attr-defined]


def difference(one: np.ndarray, two: np.ndarray) -> float:
    """Largest RMS difference of two pictures, in levels of 255, over tiles of 16 pixels; infinite where sizes differ.

    Over the whole picture a thin curve would drown in the white around it.
    """
    if one.shape != two.shape:
        return np.inf
    square = ((one - two) ** 2).mean(axis=2)
    rows, columns = (np.arange(0, n, TILE) for n in square.shape)
    sums = np.add.reduceat(np.add.reduceat(square, rows, axis=0), columns, axis=1)
    count = np.add.reduceat(np.add.reduceat(np.ones_like(square), rows, axis=0), columns, axis=1)
    return float(np.sqrt((sums / np.maximum(count, TILE**2 / 2)).max()))


def drawn(figure: Figure) -> Iterator[tuple[str, Artist]]:
    """Every curve, bar, band and error bar of a figure, with a name."""
    for place, axes in enumerate(figure.axes):
        for kind in ("lines", "patches", "collections"):
            for number, artist in enumerate(getattr(axes, kind)):
                yield f"axes {place} {kind} {number}", artist


def golden(name: str) -> Path:
    return FOLDER / f"{name.replace(' ', '-')}.png"


def load(name: str) -> np.ndarray:
    return np.round(255 * image.imread(golden(name))[..., :3]).astype(float)


def main() -> None:
    mpl.use("Agg")
    FOLDER.mkdir(exist_ok=True)
    said = {}
    for name, make in CASES.items():
        figure = make()
        said[name] = words(figure)
        image.imsave(golden(name), pixels(figure).astype(np.uint8), pil_kwargs={"optimize": True})
        plt.close(figure)
    WORDS.write_text(json.dumps(said, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    print(f"{len(CASES)} pictures, {sum(p.stat().st_size for p in FOLDER.glob('*.png')) / 1e3:.0f} kB")


if __name__ == "__main__":
    main()
