"""How fast the page of `stepid app` is: until it is there, pointing at curves, zooming, turning a knob, progress.

Needs Debian's chromium and Playwright. ``python benchmarks/app.py``
"""

from __future__ import annotations

import os
import re
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from playwright.sync_api import sync_playwright

import stepid

CHROMIUM = "/usr/bin/chromium"
REPEATS = 15
# time until two frames were drawn after an event, ms
PAINTED = """(plot, act) => new Promise((done) => {
  const place = plot.querySelector(".drawn"), box = place.getBoundingClientRect();
  const began = performance.now();
  const end = () => requestAnimationFrame(() => requestAnimationFrame(() => done(performance.now() - began)));
  if (act.zoom) window.Plotly.relayout(place, { "xaxis.range": act.zoom }).then(end);
  else {
    const drag = place.querySelector(".nsewdrag");
    const at = { bubbles: true, composed: true, clientX: box.left + act.at * box.width, clientY: box.top + 80 };
    drag.dispatchEvent(new MouseEvent("mouseover", at));
    drag.dispatchEvent(new MouseEvent("mousemove", at));
    end();
  }
})"""


def campaign(runs: int, samples: int = 2000) -> stepid.Campaign:
    """Runs of a made-up cart with dry friction, with noise."""
    lab = stepid.datasets.lab_campaign()
    model = stepid.fit(lab[["case 4", "case 5", "case 6"]], effects="coulomb_friction").model
    time_, rng = np.arange(samples) * 0.003, np.random.default_rng(1)
    volts = np.where((time_ > 0.1) & (time_ < 3.1), 0.5, 0.0)
    (base, spring, damper) = (next(iter(labels)) for labels in (model.base_mass, model.stiffness, model.damping))
    made = [
        stepid.Experiment(
            name=f"run {i + 1}", time=time_, position=0 * time_, input=volts, added_mass=0.2 * i, spring=spring,
            damper=damper, base=base,
        )
        for i in range(runs)
    ]  # fmt: skip
    bare = stepid.Campaign(name="many samples", experiments=tuple(made))
    found = stepid.simulate(model.model_copy(update={"runs": {e.name: stepid.RunState() for e in made}}), bare)
    noisy = [e.model_copy(update={"position": found[e.name] + 1e-5 * rng.standard_normal(samples)}) for e in made]
    return stepid.Campaign(name="many samples", experiments=tuple(noisy))


@contextmanager
def served(folder: Path | None) -> Iterator[str]:
    """The command in a process of its own."""
    command = [sys.executable, "-u", "-m", "stepid", "app", "--no-browser", *([str(folder)] if folder else [])]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        line = process.stdout.readline()
        yield re.search(r"http://[\d.:]+", line)[0]  # type: ignore[index]
        process.terminate()


def first_page(browser: Any) -> tuple[float, float]:
    """Seconds from the command to the first page, and of the page alone once the server has served one."""
    began = time.perf_counter()
    with served(None) as address:
        cold = shown(browser, address, began)
        return cold, shown(browser, address, time.perf_counter())


def shown(browser: Any, address: str, began: float) -> float:
    context = browser.new_context(viewport={"width": 1280, "height": 900})
    page = context.new_page()
    page.goto(address)
    page.get_by_role("button", name="Try the example").wait_for()
    taken = time.perf_counter() - began
    context.close()
    return taken


def pointing(browser: Any, runs: int) -> None:
    """Print times of hover and zoom in the picture of the last run, of a knob, and of progress."""
    with TemporaryDirectory() as scratch:
        folder = stepid.write_campaign(campaign(runs), Path(scratch) / "lab").parent
        with served(folder) as address:
            page = browser.new_page(viewport={"width": 1280, "height": 900})
            page.goto(address)
            page.get_by_text(re.compile("RMS are left")).wait_for(timeout=120_000)
            plot = page.locator(".plot[data-drawn], .plot").nth(runs - 1)
            plot.scroll_into_view_if_needed()
            plot.locator(".main-svg").first.wait_for()
            hover = [plot.evaluate(PAINTED, {"at": 0.2 + 0.6 * i / REPEATS}) for i in range(REPEATS)]
            zoom = [plot.evaluate(PAINTED, {"zoom": [0.1 * (i % 5), 2 + 0.1 * i]}) for i in range(REPEATS)]
            tell(f"hover, {runs} run(s) of 2000 samples", hover)
            tell(f"zoom, {runs} run(s) of 2000 samples", zoom)
            tell("a knob until the curve follows", turning(page))
            if runs > 1:
                tell("longest time without progress", [progress(page)])


def turning(page: Any) -> list[float]:
    """Milliseconds from a turn of a knob to the picture that it makes."""
    knob = page.get_by_role("slider", name="stiffness")
    knob.scroll_into_view_if_needed()
    picture = page.locator(".plot").last
    picture.locator(".main-svg").first.wait_for()
    out = []
    for i in range(REPEATS):
        drawn, began = picture.get_attribute("data-drawn"), time.perf_counter()
        knob.press("ArrowRight" if i % 2 else "ArrowLeft")
        wait(lambda drawn=drawn: picture.get_attribute("data-drawn") != drawn)
        out.append(1e3 * (time.perf_counter() - began))
    return out


def progress(page: Any) -> float:
    """Longest time between two changes of what a diagnosis tells, ms."""
    page.evaluate("""() => {
      window.gaps = []; let last = performance.now();
      const inner = (at) => [...at.querySelectorAll("*")].filter((e) => e.shadowRoot).map((e) => e.shadowRoot);
      const roots = (at) => [at, ...inner(at).flatMap(roots)];
      let before = "";
      window.looking = setInterval(() => {
        const told = roots(document).map((r) => r.querySelector("dl.progress")?.textContent ?? "").join("");
        if (!told || told === before) return;
        window.gaps.push(performance.now() - last);
        [last, before] = [performance.now(), told];
      }, 20);
    }""")
    page.get_by_role("button", name="Diagnose").click()
    page.locator(".answer").wait_for(timeout=300_000)
    return float(page.evaluate("clearInterval(window.looking) || Math.max(...window.gaps.slice(1), 0)"))


def wait(met: Callable[[], bool]) -> None:
    end = time.perf_counter() + 10
    while not met() and time.perf_counter() < end:
        time.sleep(0.002)


def tell(what: str, milliseconds: list[float]) -> None:
    print(
        f"{what:<45} median {statistics.median(milliseconds):6.0f} ms, largest {max(milliseconds):6.0f} ms", flush=True
    )


def main() -> None:
    with sync_playwright() as playwright:
        sandbox = [] if os.geteuid() else ["--no-sandbox"]
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=sandbox)
        cold, warm = first_page(browser)
        print(f"first page {cold:.1f} s, from the command on; the next page {warm:.1f} s", flush=True)
        for runs in (1, 10):
            pointing(browser, runs)
        browser.close()


if __name__ == "__main__":
    main()
