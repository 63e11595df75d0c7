"""Debian's chromium, driven by Playwright: nothing is downloaded, and where there is none the tests are skipped."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from browser.visiting import Visit

CHROMIUM = Path("/usr/bin/chromium")


@pytest.fixture(scope="session")
def browser() -> Iterator[Any]:
    if not CHROMIUM.is_file():
        pytest.skip(f"no browser: there is no {CHROMIUM}; install it with: apt-get install chromium")
    api = pytest.importorskip("playwright.sync_api", reason="no Playwright: pip install --group test")
    sandbox = [] if os.geteuid() else ["--no-sandbox"]  # chromium refuses to sandbox for root
    with api.sync_playwright() as playwright:
        opened = playwright.chromium.launch(executable_path=str(CHROMIUM), args=sandbox)
        yield opened
        opened.close()


@pytest.fixture
def visit(browser: Any) -> Iterator[Callable[..., Visit]]:
    """Give a window: theme "light" or "dark", width in pixels."""
    contexts = []

    def window(*, theme: str = "light", width: int = 1280, scripts: bool = True) -> Visit:
        view = {"width": width, "height": 900}
        contexts.append(browser.new_context(viewport=view, color_scheme=theme, java_script_enabled=scripts))
        return Visit(contexts[-1].new_page())

    yield window
    for context in contexts:
        context.close()
