"""Diagnose campaigns with a known missing effect and score every line that the diagnosis has to meet.

    python benchmarks/diagnosis.py --page docs/diagnosis-benchmark.md        the whole benchmark, and its page
    python benchmarks/diagnosis.py --single 40 --none 20 --pairs 5 --outside 5      a smoke run
    python benchmarks/diagnosis.py --practice FOLDER                       campaigns in files, answers.json beside them

The campaigns come from the hidden simulator in tests/hidden, which shares no code with the package. --skip leaves out
more of the first campaigns of each set: a fresh draw that nobody has developed against. Each failure is listed with its
number in its set: `hidden.sets.one(SET, NUMBER)` makes it again.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # one core a diagnosis, also in the linear algebra

import argparse
import json
import pickle
import sys
import time
from collections.abc import Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import nullcontext
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "tests"), str(ROOT / "benchmarks")]

import page  # noqa: E402
import practice  # noqa: E402
import score  # noqa: E402
import stepid  # noqa: E402
from hidden.sets import SETS, cached  # noqa: E402

Case = tuple[str, stepid.Campaign, dict[str, Any]]
COUNTS = {"single": 400, "none": 200, "pairs": 100, "outside": 56, "new": 0}
FIRST = {"pairs": 460}  # those before were developed against


def diagnose_case(case: Case, *, twins: bool = True) -> dict[str, Any]:
    """One plain record: truth, answer, gap, parameters, time."""
    which, campaign, truth = case
    record: dict[str, Any] = {
        "set": which,
        "name": campaign.name,
        "number": truth.get("number", truth["seed"]),
        "kind": truth["kind"],
        "runs": len(campaign.experiments),
        "truth": list(truth["effects"]),
        "outside": truth["outside"],
        "r0": truth["r0"],
        "noise": truth["noise_rms"],
        "variants": list(truth["variants"]),
        "true_parameters": truth["parameters"],
    }
    start, cpu = time.perf_counter(), time.process_time()
    try:
        d = stepid.diagnose(campaign)
    except Exception as error:  # the benchmark reports every failure, also those that nobody foresaw
        record |= {"seconds": time.process_time() - cpu, "waited": time.perf_counter() - start}
        return record | {"error": f"{type(error).__name__}: {error}"}
    record |= {
        "seconds": time.process_time() - cpu,  # one thread: what it takes where nobody else computes
        "waited": time.perf_counter() - start,
        "verdict": d.verdict,
        "effects": list(d.effects),
        "alternatives": [list(a) for a in d.alternatives],
        "before": d.gap.before,
        "after": d.gap.after,
        "told_noise": d.gap.noise,
        "held_out_after": d.gap.held_out_after,
        "parameters": {name: (e.value, e.uncertainty) for name, e in d.parameters.items()},
        "next_experiment": None if d.next_experiment is None else str(d.next_experiment),
    }
    if twins and record["truth"] and truth["r0"] >= 2 and not (score.first_right(record) and d.verdict == "named"):
        record["twins"] = find_twins(campaign, truth, record)
        record["inseparable"] = bool(record["twins"])
    return record


def find_twins(campaign: stepid.Campaign, truth: dict[str, Any], record: dict[str, Any]) -> list[list[str]]:
    """Answers that, fitted to data made from the truth without noise, leave Δχ² < 10: nobody can tell them apart."""
    if "exact" not in truth:
        return []
    clean = stepid.Campaign(
        name=campaign.name,
        experiments=tuple(
            e.model_copy(update={"position": np.asarray(x), "counts_per_meter": None})
            for e, x in zip(campaign.experiments, truth["exact"], strict=True)
        ),
    )
    total = sum(e.time.size for e in campaign.experiments)
    twins = []
    for other in {tuple(record["effects"]), *map(tuple, record["alternatives"])}:
        if set(other) == set(truth["effects"]) or not other:
            continue
        try:
            left = stepid.fit(clean, effects=other).rms
        except Exception:  # what cannot be fitted is no twin, and loses no other case
            continue
        if total * left**2 / truth["noise_rms"] ** 2 < 10:
            twins.append(list(other))
    return twins


def gather(args: argparse.Namespace) -> list[Case]:
    """Campaigns from the practice folder, from pickles, or made here."""
    if args.practice:
        return list(practice.cases(args.practice))
    if args.load:
        return [(file.stem, c, t) for file in args.load for c, t in pickle.loads(file.read_bytes())]
    cases: list[Case] = []
    with ProcessPoolExecutor(args.jobs) if args.jobs > 1 else nullcontext() as executor:
        for which in SETS:
            count = getattr(args, which)
            told = partial(_tell, f"making {which}", count)
            skip = args.skip + FIRST.get(which, 0)
            made = cached(args.cache, which, count, skip=skip, executor=executor, progress=told) if count else []
            cases += [(which, c, t) for c, t in made]
    return cases


def _tell(what: str, total: int, done: int) -> None:
    print(f"\r{what}: {done} of {total}  ", end="\n" if done == total else "", file=sys.stderr, flush=True)


def run(cases: list[Case], jobs: int) -> Iterator[dict[str, Any]]:
    if jobs == 1:
        yield from map(diagnose_case, cases)
        return
    with ProcessPoolExecutor(jobs) as executor:
        yield from executor.map(diagnose_case, cases, chunksize=1)


def collect(results: Iterable[dict[str, Any]], total: int) -> list[dict[str, Any]]:
    records = []
    for record in results:
        records.append(record)
        _tell("diagnosing", total, len(records))
    return records


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for which in SETS:
        parser.add_argument(f"--{which}", type=int, default=COUNTS[which], metavar="N")
    parser.add_argument("--skip", type=int, default=0, metavar="N", help="leave out N campaigns more of each set")
    parser.add_argument("--jobs", type=int, default=1, help="processes; times are only fair with a core for each")
    parser.add_argument("--cache", type=Path, help="folder in which made campaigns are kept")
    parser.add_argument("--load", type=Path, nargs="+", help="pickles of (campaign, truth), named after their set")
    parser.add_argument("--practice", type=Path, help="folder of campaigns with answers.json")
    parser.add_argument("--only", help="only campaigns whose name contains this")
    parser.add_argument("--json", type=Path, help="write every record and score here")
    parser.add_argument("--page", type=Path, help="write the Markdown page here")
    args = parser.parse_args()
    cases = [c for c in gather(args) if not args.only or args.only in c[1].name]
    if cases:  # imports and caches are not the diagnosis's time
        diagnose_case(cases[0], twins=False)
    records = collect(run(cases, args.jobs), len(cases))
    lines = score.score(records)
    print(page.report(lines, records))
    print(page.failures(lines))
    if args.json:
        summary = [{"name": x.name, "asked": x.asked, "value": x.value, "count": x.count, "met": x.met} for x in lines]
        args.json.write_text(json.dumps({"lines": summary, "records": records}, indent=1), encoding="utf-8")
    if args.page:
        args.page.write_text(page.markdown(lines, records), encoding="utf-8")


if __name__ == "__main__":
    main()
