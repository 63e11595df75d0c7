"""The gallery of the effects: its page is made from the effect classes, its pictures exist, are small and show."""

from __future__ import annotations

import re
import runpy
from pathlib import Path

import numpy as np
import pytest
from matplotlib import image
from matplotlib.mathtext import MathTextParser

from stepid.effects import CATALOGUE, Effect

DOCS = Path(__file__).resolve().parents[2] / "docs"
TEXT = (DOCS / "gallery.md").read_text(encoding="utf-8")
MADE = runpy.run_path(str(DOCS / "make_gallery.py"))
REMEDY = "run python docs/make_gallery.py"


def test_the_page_is_made_from_the_classes() -> None:
    said = MADE["residuals_on"](TEXT)
    assert sorted(said) == sorted(effect.name for effect in CATALOGUE)
    assert MADE["page"](TEXT, said) == TEXT, REMEDY


@pytest.mark.parametrize("effect", CATALOGUE, ids=lambda e: e.name)
def test_every_effect_has_its_entry_and_small_pictures(effect: Effect) -> None:
    part = TEXT.split(f"(effect-{effect.name.replace('_', '-')})=")[1].split("\n(effect-")[0]
    for words in (effect.formula, effect.seen, effect.advice):
        assert words
        assert words in part
    assert TEXT.count(f":link: effect-{effect.name.replace('_', '-')}\n") == 1
    for name, least in ((f"{effect.name}.png", 900), (f"{effect.name}-icon.png", 150)):
        path = MADE["PICTURES"] / name
        assert path.stat().st_size < 40_000
        pixels = image.imread(path)
        assert pixels.shape[1] > least
        assert pixels[..., :3].std() > 0.05


@pytest.mark.parametrize("effect", CATALOGUE, ids=lambda e: e.name)
def test_formula_is_sound_and_names_every_parameter(effect: Effect) -> None:
    MathTextParser("path").parse(f"${effect.formula}$")  # raises where the LaTeX is no formula
    assert len(effect.symbols) == len(effect.parameters) + len(effect.run_parameters)
    for symbol in effect.symbols:
        assert re.search(rf"(?<![a-zA-Z\\]){re.escape(symbol)}(?![a-zA-Z_])", effect.formula), symbol


def test_names_in_pictures_stand_for_what_was_simulated() -> None:
    (coulomb,) = [e for e in CATALOGUE if e.name == "coulomb_friction"]
    shown = MADE["show"](coulomb)
    assert MADE["words"](shown) == MADE["residuals_on"](TEXT)[coulomb.name], REMEDY
    assert "jumps" in MADE["words"](shown)
    level = MADE["SIZES"][coulomb.name][0]
    forward = shown.where.velocity_force[shown.where.velocity_levels > 0]
    assert np.median(forward) == pytest.approx(-level, rel=0.1)
    assert np.abs(shown.record - shown.without).max() > 3e-3


@pytest.mark.slow
def test_what_the_page_says_about_residuals_is_true() -> None:
    said = MADE["residuals_on"](TEXT)
    assert {e.name: MADE["words"](MADE["show"](e)) for e in CATALOGUE} == said, REMEDY
