"""Time the page of `stepid app` in a real browser: the first page, reading ten runs, hovering, zooming.

    python benchmarks/app.py [--repeats 5]

Needs Playwright and /usr/bin/chromium. The first page is cold for the first window and warm for those after it.
Hovering and zooming are timed in the browser, from the event to the next frame that is drawn.
"""

from __future__ import annotations

import argparse
import os
import re
import statistics
import subprocess
import sys
import time
from typing import Any

import numpy as np
from playwright.sync_api import sync_playwright

WAIT = 60_000  # ms
RUNS, SAMPLES = 10, 2000
_FIND = """
const find = (root) => {
  for (const e of root.querySelectorAll('*')) {
    if (e.classList.contains('js-plotly-plot') && e.querySelector('.nsewdrag')) return e;
    const inner = e.shadowRoot && find(e.shadowRoot);
    if (inner) return inner;
  }
  return null;
};
const frame = () => new Promise((done) => requestAnimationFrame(() => setTimeout(done, 0)));
"""
_WHERE = (
    f"() => {{ {_FIND} const p = find(document); if (!p) return null;"
    """
  p.scrollIntoView({block: 'center'});
  const r = p.querySelector('.nsewdrag').getBoundingClientRect(); return [r.x, r.y, r.width, r.height]; }"""
)
_HOVER = (
    f"async ([x, y]) => {{ {_FIND} const p = find(document); await frame(); const begin = performance.now();"
    """
  p.querySelector('.nsewdrag').dispatchEvent(new MouseEvent('mousemove', {clientX: x, clientY: y, bubbles: true}));
  await frame(); return performance.now() - begin; }"""
)
_LISTEN = (
    f"() => {{ {_FIND} const p = find(document);"
    """
  p.on('plotly_relayout', async () => { await frame(); window.zoomed = performance.now(); });
  window.addEventListener('mouseup', () => { window.released = performance.now(); }, true); }"""
)


def recordings() -> list[dict[str, Any]]:
    """Ten step responses of 2,000 samples as CSV files."""
    time_ = 0.0025 * np.arange(SAMPLES)
    files = []
    for i in range(RUNS):
        mass = 1.0 + 0.2 * i
        half = 2.0 / mass
        swing = np.sqrt(300.0 / mass - half**2)
        x = 8 * (1 - np.exp(-half * time_) * (np.cos(swing * time_) + half / swing * np.sin(swing * time_)))
        rows = "\n".join(f"{t:.4f},{v:.4f},0.5" for t, v in zip(time_, x, strict=True))
        name = f"run {i + 1} {0.2 * i:.1f}kg.csv"
        files.append(
            {"name": name, "mimeType": "text/csv", "buffer": f"time_s,position_mm,voltage_V\n{rows}\n".encode()}
        )
    return files


def hover(page: Any) -> float:
    """Milliseconds from a move of the mouse over a picture to the frame after it."""
    x, y, width, height = page.evaluate(_WHERE)
    return float(page.evaluate(_HOVER, [x + width / 3, y + height / 2]))


def zoom(page: Any) -> float:
    """Milliseconds from the end of a drag over a picture to the frame that shows its zoom."""
    x, y, width, height = page.evaluate(_WHERE)
    page.mouse.move(x + 0.3 * width, y + height / 2)
    page.mouse.down()
    page.mouse.move(x + 0.7 * width, y + height / 2, steps=4)
    page.mouse.up()
    page.wait_for_function("() => window.zoomed > window.released", timeout=WAIT)
    took = float(page.evaluate("() => window.zoomed - window.released"))
    page.mouse.dblclick(x + width / 2, y + height / 2)
    page.wait_for_timeout(500)
    return took


def report(what: str, times: list[float]) -> None:
    print(f"{what}: {statistics.median(times):.0f} ms, at most {max(times):.0f} ms (asked 250)")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeats", type=int, default=5)
    repeats = parser.parse_args().repeats
    command = [sys.executable, "-u", "-m", "stepid", "app", "--no-browser"]
    begin = time.perf_counter()
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as serving, sync_playwright() as playwright:
        assert serving.stdout is not None
        found = re.search(r"http://[\d.:]+", serving.stdout.readline())
        assert found is not None
        print(f"server ready: {time.perf_counter() - begin:.2f} s")
        sandbox = [] if os.geteuid() else ["--no-sandbox"]
        browser = playwright.chromium.launch(executable_path="/usr/bin/chromium", args=sandbox)
        first = []
        for _ in range(repeats):
            page = browser.new_page()
            begin = time.perf_counter()
            page.goto(found[0])
            page.get_by_role("button", name="Try the example").wait_for(timeout=WAIT)
            first.append(time.perf_counter() - begin)
        print(f"first page: cold {first[0]:.2f} s, warm {statistics.median(first[1:] or first):.2f} s (asked 6 and 3)")
        begin = time.perf_counter()
        page.locator("input[type=file]").first.set_input_files(recordings())
        page.get_by_text(f"{RUNS} runs read.").wait_for(timeout=WAIT)
        print(f"{RUNS} runs of {SAMPLES} samples read: {time.perf_counter() - begin:.2f} s")
        page.get_by_text("Measured against simulated").first.wait_for(timeout=WAIT)
        page.locator("h3").first.scroll_into_view_if_needed()
        page.wait_for_function(_WHERE, timeout=WAIT)
        report("hover", [hover(page) for _ in range(repeats)])
        page.evaluate(_LISTEN)
        report("zoom", [zoom(page) for _ in range(repeats)])
        browser.close()
        serving.terminate()


if __name__ == "__main__":
    main()
