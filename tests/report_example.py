"""Pages of ready-made diagnoses, written once for all tests that read or open them."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from tempfile import mkdtemp

import matplotlib as mpl

import diagnosis_example as example
from stepid.diagnosis.result import Diagnosis

NINE = tuple(f"case {number}" for number in range(1, 10))


@cache
def page() -> Path:
    """The page of four runs."""
    return _written(example.named())


@cache
def page_of_nine() -> Path:
    return _written(example.named(runs=NINE))


def _written(d: Diagnosis) -> Path:
    mpl.use("Agg")
    return d.to_html(Path(mkdtemp(prefix="stepid-report-")) / "report.html")
