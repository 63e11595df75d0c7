"""A page in a window of the browser."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

# Tabulator's grid has its empty notice among its children, and a filler column without a title
OF_TABULATOR = {"aria-required-children", "empty-table-header"}
STILL = 6  # looks at a button, between which it keeps its place


class Visit:
    """A page that was opened, with everything it complained of and asked the network for."""

    def __init__(self, page: Any) -> None:
        self.page = page
        self.complaints: list[str] = []
        self.requests: list[str] = []
        page.on("console", lambda m: self.complaints.append(m.text) if m.type in ("error", "warning") else None)
        page.on("pageerror", lambda error: self.complaints.append(str(error)))
        page.on("request", lambda request: self.requests.append(request.url))

    def open(self, path: Path) -> Visit:
        self.page.goto(path.as_uri())
        self.page.wait_for_selector("html[data-ready]")
        return self

    def plot(self, name: str) -> Any:
        """Return a picture, scrolled to and drawn."""
        found = self.page.locator(f'.plot[data-picture="{name}"]')
        found.scroll_into_view_if_needed()
        found.locator(".main-svg").first.wait_for()
        return found

    def draw_all(self) -> None:
        """Unfold and scroll through the page, so that every picture is drawn."""
        self.page.evaluate("document.querySelectorAll('details').forEach((one) => (one.open = true))")
        for plot in self.page.locator(".plot:visible").all():
            plot.scroll_into_view_if_needed()
            plot.locator(".main-svg").first.wait_for(state="attached")

    def becomes(self, expression: str, wanted: Callable[[Any], bool]) -> bool:
        """Wait until a JavaScript expression has a wanted value; Playwright's own way needs what the page forbids."""
        for _ in range(100):
            if wanted(self.page.evaluate(expression)):
                return True
            self.page.wait_for_timeout(50)
        return False


def press(button: Any) -> None:
    """Scroll to a button, wait until it keeps its place, and click it.

    A click during which its button is moved away is none: what arrives moves all that is below it, and so does a
    picture that is drawn as it comes into view. The page may put another button in its place meanwhile: it is looked
    for at each look.
    """
    places: list[object] = []
    while len(places) < STILL or any(place != places[-1] for place in places[-STILL:]):
        button.evaluate("(one) => one.scrollIntoView({block: 'nearest'})")
        places.append(button.bounding_box())
        button.page.wait_for_timeout(200)
    button.click()


def serious_faults(page: Any) -> list[tuple[str, Any]]:
    """What axe finds serious or critical on a page, but for what is of Tabulator: the rule and where."""
    axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="no axe: pip install --group test")
    found = axe.Axe().run(page).response
    assert len(found["passes"]) > 20  # it did look
    serious = [one for one in found["violations"] if one["impact"] in ("serious", "critical")]
    return [
        (one["id"], node["target"])
        for one in serious
        for node in one["nodes"]
        if not (one["id"] in OF_TABULATOR and "tabulator" in str(node["target"]))
    ]
