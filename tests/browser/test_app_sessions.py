"""What a page of `stepid app` keeps to itself and leaves behind; what is typed, told, and read by keys."""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest

import stepid
import webapp_files as files
from browser.visiting import Visit, press, serious_faults
from webapp_server import serving

pytestmark = pytest.mark.slow
FOCUSED = """() => {
  let at = document.activeElement;
  while (at?.shadowRoot?.activeElement) at = at.shadowRoot.activeElement;
  return at?.getAttribute("aria-label") || at?.closest("label")?.textContent || at?.textContent || "";
}"""


@pytest.fixture(scope="module")
def sessions() -> list[Any]:
    """Sessions of all pages, in the order in which they were opened."""
    return []


@pytest.fixture(scope="module")
def address(sessions: list[Any]) -> Iterator[str]:
    from stepid.webapp.views import serve

    class Seen(serve.Session):
        def __init__(self, campaign: stepid.Campaign | None = None) -> None:
            super().__init__(campaign)
            sessions.append(self)

    with pytest.MonkeyPatch.context() as patch, serving() as made:
        patch.setattr(serve, "Session", Seen)
        yield f"http://127.0.0.1:{made.port}/"


@pytest.fixture
def at(visit: Callable[..., Visit], address: str) -> Callable[..., Visit]:
    def window(*, example: bool = False, **look: Any) -> Visit:
        opened = visit(**look)
        opened.page.goto(address)
        button = opened.page.get_by_role("button", name="Try the example")
        button.wait_for()
        if example:
            press(button)
            opened.page.get_by_text("What runs share").wait_for()  # Table 2's numbers come by themselves
        return opened

    return window


def drop(at: Visit, dropped: dict[str, bytes]) -> None:
    at.page.locator("input[type=file]").first.set_input_files(
        [{"name": name, "mimeType": "text/csv", "buffer": content} for name, content in dropped.items()]
    )


def cell(at: Visit, row: int, field: str) -> Any:
    return at.page.locator(f'.tabulator-row .tabulator-cell[tabulator-field="{field}"]').nth(row)


def write(at: Visit, row: int, field: str, text: str) -> None:
    place = cell(at, row, field)
    box = place.locator("input")
    for _ in range(10):  # a table that was just filled is drawn once more
        place.focus()  # opens the editor
        at.page.wait_for_timeout(300)
        if box.count():
            break
        place.blur()
    box.fill(text)
    box.press("Enter")


def to(at: Visit, name: str, most: int = 300) -> None:
    """Press Tab until what has the focus is called so."""
    for _ in range(most):
        at.page.keyboard.press("Tab")
        if name in at.page.evaluate(FOCUSED):
            return
    raise AssertionError(f"Tab does not lead to {name!r}")


def endless(campaign: stepid.Campaign, *, effort: Any = None, progress: Callable[[stepid.Progress], None]) -> None:
    while True:
        time.sleep(0.02)
        progress(stepid.Progress("power_damping", best=("coulomb_friction",), left=7, promise=0.2))


def test_masses_are_typed_and_nothing_is_asked_of_the_network(at: Any) -> None:
    page = at()
    drop(page, files.three(named=False))
    page.page.get_by_role("alert").filter(has_text="run 1, run 2, run 3").wait_for()
    for row, mass in enumerate(("0", "0,5", "1")):
        write(page, row, "added_mass", mass)
    page.page.get_by_text("What runs share").wait_for()
    assert cell(page, 1, "added_mass").text_content() == "0,5"  # as it was typed
    write(page, 0, "added_mass", "-1")
    page.page.get_by_role("alert").filter(has_text="0 or more").wait_for()
    assert page.becomes("1", lambda _: cell(page, 0, "added_mass").text_content() == "0")
    assert page.page.get_by_text("What runs share").is_visible()  # a refusal leaves all as it was
    assert [url for url in page.requests if not re.match(r"http://127\.0\.0\.1:|data:|blob:", url)] == []
    assert page.complaints == []


def test_names_are_text(at: Any) -> None:
    page = at(example=True)
    name = "<img src=x onerror=alert(1)>"
    write(page, 0, "name", name)
    page.page.get_by_role("heading", name=name).nth(1).wait_for()  # of the record, and of the verification
    assert page.page.locator("img[src=x]").count() == 0
    assert page.complaints == []


def test_progress_is_told_every_second_and_cancel_ends_it(at: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stepid, "diagnose", endless)
    page = at(example=True)
    press(page.page.get_by_role("button", name="Diagnose"))
    told = page.page.locator("dl.progress dd")
    told.filter(has_text="power damping").wait_for()  # the first second says only that it starts
    assert told.all_text_contents()[:3] == [
        "power damping",
        "Coulomb friction",
        "7; the most promising may explain 20 % of the remaining misfit",
    ]
    seconds = {told.last.text_content() for _ in range(30) if not page.page.wait_for_timeout(100)}
    assert len(seconds) >= 3
    press(page.page.get_by_role("button", name="Cancel"))
    page.page.get_by_text("Canceled.").wait_for()
    assert page.page.get_by_role("button", name="Diagnose").is_enabled()


def test_a_closed_page_ends_its_work_and_leaves_no_file(
    at: Any, sessions: list[Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(stepid, "diagnose", endless)
    page = at()
    drop(page, files.three())
    cell(page, 2, "name").wait_for()
    page.page.get_by_text("What runs share").wait_for()
    press(page.page.get_by_role("button", name="Diagnose"))
    page.page.locator("dl.progress dd").first.wait_for()
    session = sessions[-1]
    work, folder = session.work, session.inbox.folder
    assert len(list(folder.iterdir())) == 3
    assert work.status.running
    page.page.close()
    assert work.wait(5)
    assert work.status.canceled
    end = time.monotonic() + 40
    while folder.exists() and time.monotonic() < end:
        time.sleep(0.1)
    assert not folder.exists()


def test_two_pages_with_campaigns_of_their_own(at: Any) -> None:
    one, two = at(example=True), at()
    drop(two, files.three())
    cell(two, 2, "name").wait_for()
    write(two, 0, "name", "mine")
    one.page.wait_for_timeout(500)
    assert two.page.locator(".tabulator-row").count() == 3
    assert one.page.locator(".tabulator-row").count() == 10
    assert cell(one, 0, "name").text_content() == "case 1"


def test_pictures_are_read_and_knobs_turned_by_keys(at: Any) -> None:
    page = at(example=True)
    left = page.page.locator(".said").filter(has_text="RMS are left")
    left.wait_for()
    to(page, "Position and input of case 1 against")
    for _ in range(5):
        page.page.keyboard.press("ArrowRight")
    reading = page.page.locator(".reading").filter(has_text="→").first
    reading.wait_for(state="attached")
    assert re.fullmatch(r"position: [\d.]+ s → [\d.-]+ mm", reading.text_content())
    to(page, "stiffness [N/m]")
    before = left.text_content()
    for _ in range(10):
        page.page.keyboard.press("ArrowRight")
    assert page.becomes("1", lambda _: left.text_content() != before)
    assert page.complaints == []


def test_axe_finds_nothing_but_what_is_of_widgets(at: Any) -> None:
    page = at(example=True, theme="dark")
    page.page.get_by_text("RMS are left").wait_for()
    assert serious_faults(page.page) == []
