"""Whole sessions on the page of `stepid app` in a browser: files in, a report out; bad files; phone, dark, keys."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from browser.visiting import Visit, press, serious_faults
from webapp_files import three

pytestmark = pytest.mark.slow
WAIT = 180_000  # ms, for what computes: the first diagnosis of an installation compiles


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    command = [sys.executable, "-u", "-m", "stepid", "app", "--no-browser"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=os.environ | {"NO_COLOR": "1"}) as serving:
        assert serving.stdout is not None
        found = re.search(r"http://127\.0\.0\.1:\d+", serving.stdout.readline())
        assert found is not None
        yield found[0]
        serving.terminate()


@pytest.fixture
def there(address: str, visit: Callable[..., Visit]) -> Callable[..., Visit]:
    def opened(**how: Any) -> Visit:
        window = visit(**how)
        window.page.goto(address)
        window.page.get_by_role("button", name="Try the example").wait_for(timeout=WAIT)
        return window

    return opened


def drop(page: Any, files: dict[str, bytes]) -> None:
    payload = [{"name": name, "mimeType": "text/csv", "buffer": data} for name, data in files.items()]
    page.locator("input[type=file]").first.set_input_files(payload)


def diagnosed(page: Any) -> None:
    press(page.get_by_role("button", name="Diagnose"))
    page.get_by_text(re.compile(r"Done in \d")).wait_for(timeout=WAIT)
    page.get_by_text("The whole answer as text").wait_for(timeout=WAIT)
    page.get_by_text("Fitting the linear plant").wait_for(state="hidden", timeout=WAIT)


def test_from_dropped_files_to_a_report(there: Callable[..., Visit], tmp_path: Path) -> None:
    page = there().page
    drop(page, three())
    page.get_by_text("3 runs read.").wait_for(timeout=WAIT)
    diagnosed(page)
    page.get_by_text("adequate", exact=False).first.wait_for()
    saved = {}
    for name in ("Report", "Campaign", "Tables"):
        with page.expect_download(timeout=WAIT) as downloading:
            press(page.get_by_text(name, exact=True).last)
        saved[name] = tmp_path / downloading.value.suggested_filename
        downloading.value.save_as(saved[name])
    report = saved["Report"].read_text(encoding="utf-8")
    assert report.lstrip().lower().startswith("<!doctype html>")
    assert "medium 0.5kg" in report.replace("_", " ")
    with zipfile.ZipFile(saved["Campaign"]) as kept:
        assert "campaign.toml" in {Path(name).name for name in kept.namelist()}
    assert saved["Tables"].stat().st_size > 100


def test_a_bad_file_is_named_and_the_page_goes_on(there: Callable[..., Visit]) -> None:
    page = there().page
    drop(page, {"notes.csv": b"dear diary\nnothing was measured\n"})
    page.locator(".said.bad").first.wait_for(timeout=WAIT)
    assert "notes.csv" in page.locator(".said.bad").first.inner_text()
    press(page.get_by_role("button", name="Try the example"))
    page.get_by_text("10 runs read.").wait_for(timeout=WAIT)


@pytest.mark.parametrize(("width", "theme"), [(1280, "light"), (390, "dark")])
def test_it_fits_and_has_no_serious_fault(there: Callable[..., Visit], width: int, theme: str) -> None:
    window = there(width=width, theme=theme)
    page = window.page
    press(page.get_by_role("button", name="Try the example"))
    page.get_by_text("10 runs read.").wait_for(timeout=WAIT)
    diagnosed(page)
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    paper = page.evaluate("getComputedStyle(document.body).backgroundColor")
    light = sum(map(int, re.findall(r"\d+", paper)[:3])) > 3 * 127
    assert light == (theme == "light")
    assert serious_faults(page) == []
    assert [c for c in window.complaints if "favicon" not in c] == []


def test_a_keyboard_is_enough(there: Callable[..., Visit]) -> None:
    page = there().page
    for wanted in ("Try the example", "Diagnose"):
        for _ in range(200):  # through a table of ten rows and the buttons of ten pictures
            page.keyboard.press("Tab")
            at = page.evaluate(
                "(() => { let e = document.activeElement;"
                " while (e && e.shadowRoot && e.shadowRoot.activeElement) e = e.shadowRoot.activeElement;"
                " return e ? e.innerText || '' : ''; })()"
            )
            if at.strip() == wanted:
                break
        else:
            pytest.fail(f"Tab does not come to {wanted!r}")
        page.keyboard.press("Enter")
        if wanted == "Try the example":  # what arrives takes the place of what is there
            page.get_by_text("Measured against simulated").first.wait_for(timeout=WAIT)
    page.get_by_text(re.compile(r"Done in \d")).wait_for(timeout=WAIT)
