"""Campaigns of any set made and diagnosed one at a time, a JSON line for each as it ends; it can be taken up again."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from typing import Any

from hidden.sets import SETS, one
from record import diagnose_case, with_efforts

Task = tuple[str, int, str]  # set, number, salt
EVERY = 5  # campaigns of which one is diagnosed with other efforts, too


def wanted(text: str) -> tuple[str, int]:
    """`NAME=N` from the command line."""
    which, _, count = text.partition("=")
    if which not in SETS or not count.isdigit():
        raise ValueError(f"{text!r} is not NAME=N with NAME one of {', '.join(SETS)}")
    return which, int(count)


def run_task(task: Task) -> dict[str, Any]:
    which, number, salt = task
    campaign, truth = one(which, number, salt)
    record = diagnose_case((which, campaign, truth)) | {"salt": salt}
    if number % EVERY == 0 and "error" not in record:
        record["efforts"] = with_efforts(campaign)
    return record


def warm() -> None:
    """Imports, compiled code and caches are not the diagnosis's time."""
    diagnose_case(("none", *one("none", 0)), twins=False)


def read(file: Path) -> list[dict[str, Any]]:
    """Records of a file of lines; a last line that was cut off is left out."""
    records = []
    for text in file.read_text(encoding="utf-8").splitlines() if file.exists() else ():
        try:
            records.append(json.loads(text))
        except json.JSONDecodeError:
            continue
    return records


def key(record: dict[str, Any]) -> Task:
    return record["set"], record["number"], record.get("salt", "")


def run(
    tasks: list[Task], file: Path | None, jobs: int, told: Callable[[int], object] = lambda done: None
) -> list[dict[str, Any]]:
    """Records of all tasks, in their order; those that stand in the file are taken from it."""
    found = {key(r): r for r in ([] if file is None else read(file))}
    waiting = [task for task in tasks if task not in found]
    if file is not None:
        file.parent.mkdir(parents=True, exist_ok=True)
        if file.exists() and not file.read_text(encoding="utf-8").endswith("\n") and file.stat().st_size:
            file.write_text("".join(json.dumps(r) + "\n" for r in found.values()), encoding="utf-8")
    for record in _records(waiting, jobs):
        found[key(record)] = record
        if file is not None:
            with file.open("a", encoding="utf-8") as lines:
                lines.write(json.dumps(record) + "\n")
        told(sum(task in found for task in tasks))
    return [found[task] for task in tasks]


def _records(tasks: list[Task], jobs: int) -> Iterator[dict[str, Any]]:
    if not tasks:
        return
    if jobs == 1:
        warm()
        yield from map(run_task, tasks)
        return
    with ProcessPoolExecutor(jobs, initializer=warm) as executor:
        for future in as_completed([executor.submit(run_task, task) for task in tasks]):
            yield future.result()
