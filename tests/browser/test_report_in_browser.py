"""The report as a person meets it: in a browser, light and dark, wide and narrow, with a mouse, keys or neither."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from typing import Any

import pytest

import diagnosis_example as example
import report_example
from browser.visiting import Visit

pytestmark = pytest.mark.slow

SIZES = [("light", 1280), ("light", 390), ("dark", 1280), ("dark", 390)]
FIRST = [("light", 1280), ("dark", 390)]
Window = Callable[..., Any]
CUT = """[...document.querySelectorAll(".plot")].flatMap((plot) => {
  const room = plot.getBoundingClientRect();
  const inside = (box) => box.left >= room.left - 1 && box.right <= room.right + 1
    && box.top >= room.top - 1 && box.bottom <= room.bottom + 1;
  return [...plot.querySelectorAll(".main-svg text")].filter((text) => !inside(text.getBoundingClientRect()))
    .map((text) => `${plot.dataset.picture}: ${text.textContent}`);
})"""


@pytest.fixture(scope="module")
def at(browser: Any) -> Iterator[Any]:
    """The page of four runs, wide and light, all drawn; every test leaves all runs shown."""
    context = browser.new_context(viewport={"width": 1280, "height": 900})
    visit = Visit(context.new_page()).open(report_example.page())
    visit.draw_all()
    yield visit
    context.close()


def shown(visit: Any, name: str) -> list[bool]:
    js = f"""document.querySelector('.plot[data-picture="{name}"] .drawn').data.map(trace => trace.visible)"""
    return visit.page.evaluate(js)


@pytest.mark.parametrize(("theme", "width"), FIRST)
def test_opens_without_a_complaint_or_a_request(visit: Window, theme: str, width: int) -> None:
    page = report_example.page()
    at = visit(theme=theme, width=width).open(page)
    at.draw_all()
    assert at.complaints == []
    assert at.requests == [page.as_uri()]
    assert at.page.evaluate("document.documentElement.scrollWidth") == width  # nothing hangs over the edge
    assert at.page.evaluate(CUT) == []
    assert at.page.locator("img.still:visible").count() == 0
    drawn = at.page.locator(".plot .main-svg").count()
    assert drawn >= 8 + 2 * len(example.RUNS)
    colors = (
        "[getComputedStyle(document.body).backgroundColor, getComputedStyle(document.querySelector('.xtitle')).fill]"
    )
    back, ink = (sum(map(int, re.findall(r"\d+", color)[:3])) for color in at.page.evaluate(colors))
    assert (back > ink) == (theme == "light")


def test_the_numbers_of_candidates_are_seen_on_a_phone_without_scrolling(visit: Window) -> None:
    at = visit(width=390).open(report_example.page())
    last = at.page.get_by_role("columnheader", name="probability")
    box = last.bounding_box()
    assert 0 < box["x"] < box["x"] + box["width"] <= 390


def test_a_run_is_shown_and_hidden_in_all_pictures(at: Any) -> None:
    assert shown(at, "records") == shown(at, "residuals") == [True] * 4
    box = at.page.get_by_role("checkbox", name="case 5")
    box.focus()
    at.page.keyboard.press("Space")
    assert not box.is_checked()
    assert shown(at, "records") == shown(at, "residuals") == [True, False, True, True]
    figures = at.page.locator('.facets figure[data-run="1"]')
    assert figures.count() == 2
    assert not any(figure.is_visible() for figure in figures.all())
    assert at.page.locator('.facets figure[data-run="0"]').first.is_visible()
    at.page.get_by_text("case 5", exact=True).first.click()  # its entry in the legend
    assert box.is_checked()
    assert shown(at, "records") == [True] * 4
    assert all(figure.is_visible() for figure in figures.all())
    at.page.get_by_role("button", name="none").click()
    assert shown(at, "records") == [False] * 4
    at.page.get_by_role("button", name="all").click()
    assert shown(at, "records") == [True] * 4
    assert at.complaints == []


def test_pointing_at_a_curve_tells_its_values(at: Any) -> None:
    d = example.named()
    plot = at.plot("run-0")
    box = plot.bounding_box()
    at.page.mouse.move(box["x"] + 0.4 * box["width"], box["y"] + 90)
    plot.locator(".hoverlayer .legend, .hoverlayer .hovertext").first.wait_for()
    said = plot.locator(".hoverlayer").text_content()
    time = float(re.search(r"^([\d.]+) s", said)[1])  # type: ignore[index]
    sample = abs(d.runs[0].time - time).argmin()
    for name, curve in (("measured", d.runs[0].measured), ("linear", d.runs[0].linear)):
        value = float(re.search(rf"{name} : ([\d.−-]+) mm", said)[1].replace("−", "-"))  # type: ignore[index]
        assert value == pytest.approx(1e3 * curve[sample], rel=2e-3)
    assert "with effect" in said
    assert at.complaints == []


def test_values_can_be_read_without_a_mouse(at: Any) -> None:
    d = example.named()
    plot = at.plot("records")
    plot.focus()
    for _ in range(40):
        at.page.keyboard.press("ArrowRight")
    at.page.keyboard.press("ArrowDown")
    run = d.runs[1]
    said = plot.locator(".reading").text_content()
    name, time, value = re.fullmatch(r"(.+): ([\d.]+) s → ([\d.-]+) mm", said).groups()  # type: ignore[union-attr]
    assert name == run.name
    assert float(time) == pytest.approx(run.time[39], rel=1e-3)
    assert float(value) == pytest.approx(1e3 * run.measured[39], rel=1e-3)
    for other, unit in (("gap", "µm"), ("candidates", "µm"), ("velocity", "N"), ("pull", "%"), ("run-2", "mm")):
        plot = at.plot(other)
        plot.focus()
        at.page.keyboard.press("Home")
        assert re.search(rf"→ [\d.-]+ {unit}", plot.locator(".reading").text_content()), other
    assert at.complaints == []


def test_the_theme_follows_the_system(at: Any) -> None:
    plot = at.plot("records")
    color = "document.querySelector('.plot[data-picture=records] .drawn').data[3].line.color"
    light = at.page.evaluate(color)
    at.page.emulate_media(color_scheme="dark")
    assert at.becomes(color, lambda found: found != light)
    assert plot.is_visible()
    at.page.emulate_media(color_scheme="light")
    assert at.becomes(color, lambda found: found == light)
    assert at.complaints == []


def test_paper_and_browsers_without_scripts_get_still_pictures(visit: Window, at: Any) -> None:
    at.page.emulate_media(media="print", color_scheme="dark")
    assert at.page.locator("img.still:visible").count() == 7
    assert at.page.locator(".plot:visible, .runs:visible, nav:visible").count() == 0
    assert at.page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"
    assert at.page.pdf(prefer_css_page_size=True).startswith(b"%PDF")
    at.page.emulate_media(media="screen", color_scheme="light")
    bare = visit(scripts=False)
    bare.page.goto(report_example.page().as_uri())
    for folded in bare.page.locator("summary").all():
        folded.click()
    assert bare.page.locator("img.still:visible").count() == 7
    assert bare.page.locator(".plot:visible, .runs:visible").count() == 0
    sizes = bare.page.evaluate("[...document.querySelectorAll('img.still')].map(image => image.naturalWidth)")
    assert min(sizes) > 500


def check_accessibility(at: Any) -> None:
    axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="no axe: pip install --group test")
    found = axe.Axe().run(at.page)
    assert len(found.response["passes"]) > 20  # it did look
    assert found.violations_count == 0, found.generate_report()


def test_axe_finds_no_violation(at: Any) -> None:
    check_accessibility(at)


@pytest.mark.parametrize(("theme", "width"), SIZES)
def test_nine_runs(visit: Window, theme: str, width: int) -> None:
    page = report_example.page_of_nine()
    assert page.stat().st_size <= 3_000_000
    at = visit(theme=theme, width=width).open(page)
    at.draw_all()
    check_accessibility(at)
    assert at.complaints == []
    assert at.requests == [page.as_uri()]
    assert at.page.evaluate("document.documentElement.scrollWidth") == width
