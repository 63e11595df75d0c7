"""Diagnose campaigns with a known missing effect and score every line that the diagnosis has to meet.

    python benchmarks/diagnosis.py                                        the standing campaigns
    python benchmarks/diagnosis.py --single 40 --none 20 --pairs 5 --outside 5      a smoke run
    python benchmarks/diagnosis.py --catalogue old --json FILE             the same with the 20 effects of the old sets
    python benchmarks/diagnosis.py --practice FOLDER                       campaigns in files, answers.json beside them
    python benchmarks/diagnosis.py --set triples=60 --set perturbed-none=300 --salt HASH --lines FILE
                                                     any sets, one at a time; then benchmarks/score_perturbed.py FILE

The campaigns come from the hidden simulator in tests/hidden, which shares no code with the package. --skip leaves out
more of the first campaigns of each set: a fresh draw that nobody has developed against. Each failure is listed with its
number in its set: `hidden.sets.one(SET, NUMBER, SALT)` makes it again. --salt makes seeds from SHA-256 of salt, set
and number, so that the hash of a commit can draw campaigns that nobody has seen.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # one core a diagnosis, also in the linear algebra

import argparse
import json
import pickle
import sys
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import nullcontext
from functools import partial
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "tests"), str(ROOT / "benchmarks")]

import one_by_one  # noqa: E402
import practice  # noqa: E402
import report  # noqa: E402
import score  # noqa: E402
import score_perturbed  # noqa: E402
from hidden.plant import NEW  # noqa: E402
from hidden.sets import LEGACY, cached  # noqa: E402
from record import Case, diagnose_case  # noqa: E402

COUNTS = {"single": 400, "none": 200, "pairs": 100, "outside": 56, "new": 0}
CATALOGUES: dict[str, tuple[str, ...]] = {"all": (), "old": NEW}  # effects that are left out
FIRST = {"pairs": 460}  # those before were developed against


def gather(args: argparse.Namespace) -> list[Case]:
    """Campaigns from the practice folder, from pickles, or made here."""
    if args.practice:
        return list(practice.cases(args.practice))
    if args.load:
        return [(file.stem, c, t) for file in args.load for c, t in pickle.loads(file.read_bytes())]
    cases: list[Case] = []
    with ProcessPoolExecutor(args.jobs) if args.jobs > 1 else nullcontext() as executor:
        for which in LEGACY:
            count = getattr(args, which)
            told = partial(_tell, f"making {which}", count)
            skip = args.skip + FIRST.get(which, 0)
            made = cached(args.cache, which, count, skip=skip, executor=executor, progress=told) if count else []
            cases += [(which, c, t) for c, t in made]
    return cases


def _tell(what: str, total: int, done: int) -> None:
    print(f"\r{what}: {done} of {total}  ", end="\n" if done == total else "", file=sys.stderr, flush=True)


def run(cases: list[Case], jobs: int, without: Sequence[str] = ()) -> Iterator[dict[str, Any]]:
    work = partial(diagnose_case, without=without)
    if jobs == 1:
        yield from map(work, cases)
        return
    with ProcessPoolExecutor(jobs) as executor:
        yield from executor.map(work, cases, chunksize=1)


def collect(results: Iterable[dict[str, Any]], total: int) -> list[dict[str, Any]]:
    records = []
    for record in results:
        records.append(record)
        _tell("diagnosing", total, len(records))
    return records


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for which in LEGACY:
        parser.add_argument(f"--{which}", type=int, default=COUNTS[which], metavar="N")
    parser.add_argument("--skip", type=int, default=0, metavar="N", help="leave out N campaigns more of each set")
    parser.add_argument("--jobs", type=int, default=1, help="processes; times are only fair with a core for each")
    parser.add_argument("--cache", type=Path, help="folder in which made campaigns are kept")
    parser.add_argument("--load", type=Path, nargs="+", help="pickles of (campaign, truth), named after their set")
    parser.add_argument("--practice", type=Path, help="folder of campaigns with answers.json")
    parser.add_argument("--only", help="only campaigns whose name contains this")
    parser.add_argument("--json", type=Path, help="write every record and score here")
    parser.add_argument("--set", type=one_by_one.wanted, action="append", metavar="NAME=N", help="N campaigns of a set")
    parser.add_argument("--salt", default="", help="what the seeds of --set are made from")
    parser.add_argument("--first", type=int, default=0, metavar="N", help="number of the first campaign of each --set")
    parser.add_argument(
        "--lines", type=Path, help="a JSON line for each campaign of --set; what is in it is not run again"
    )
    parser.add_argument(
        "--catalogue", choices=CATALOGUES, default="all", help="candidates: every effect, or the 20 of the old sets"
    )
    args = parser.parse_args()
    if args.set:
        if args.catalogue != "all":
            parser.error("--set tries every effect: lines of a file do not say which were candidates")
        tasks = [(which, args.first + i, args.salt) for which, count in args.set for i in range(count)]
        told = partial(_tell, "diagnosing", len(tasks))
        print(score_perturbed.report(one_by_one.run(tasks, args.lines, args.jobs, told)))
        return
    cases = [c for c in gather(args) if not args.only or args.only in c[1].name]
    if cases:  # imports and caches are not the diagnosis's time
        diagnose_case(cases[0], twins=False)
    records = collect(run(cases, args.jobs, CATALOGUES[args.catalogue]), len(cases))
    lines = score.score(records)
    print(report.report(lines, records))
    print(report.failures(lines))
    if args.json:
        summary = [{"name": x.name, "asked": x.asked, "value": x.value, "count": x.count, "met": x.met} for x in lines]
        args.json.write_text(json.dumps({"lines": summary, "records": records}, indent=1), encoding="utf-8")


if __name__ == "__main__":
    main()
