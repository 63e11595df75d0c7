"""Folders as labs leave them: what `stepid init` gets right unasked, how many answers it takes, and a diagnosis.

`python -m benchmarks.folders --count 20` and `python -m benchmarks.folders --count 10 --held-out --diagnose`, with
tests/ on the path; `--styles` for ten more, each in a style of its own. The words of the folders that are held out
were written before the code, and are not for tuning.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

from folder_score import judge
from lab_folders import make_folder
from lab_person import SOURCE, check_campaign, person
from lab_styles import STYLES, make_styled_folder


def diagnosed(folder: Path) -> str:
    """The verdict of the second command."""
    done = subprocess.run(
        [sys.executable, "-m", "stepid", "diagnose", "campaign.toml", "--effort", "quick", "--json"],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": SOURCE},
        capture_output=True,
        text=True,
        check=False,
    )
    return json.loads(done.stdout)["verdict"] if done.returncode == 0 else done.stderr.strip()[-200:]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=30)
    kind = parser.add_mutually_exclusive_group()
    kind.add_argument("--held-out", action="store_true")
    kind.add_argument("--styles", action="store_true", help="ten folders, each in a style of its own")
    parser.add_argument("--diagnose", action="store_true")
    chosen = parser.parse_args()
    total: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as scratch:
        for seed in range(len(STYLES) if chosen.styles else chosen.count):
            folder = Path(scratch) / str(seed)
            if chosen.styles:
                truths = make_styled_folder(folder, seed)
            else:
                truths = make_folder(folder, seed, held_out=chosen.held_out)
            try:
                count, trouble = judge(truths, folder)
                total += count
                answers, _ = person(folder, truths)
                check_campaign(folder, truths)
                end = diagnosed(folder) if chosen.diagnose else "campaign"
            except Exception as error:  # one folder's failure is a result
                count, trouble, answers, end = Counter(), [], -1, f"{type(error).__name__}: {str(error)[-300:]}"
                total["failed folders"] += 1
            total[f"{answers} answers"] += 1
            print(seed, dict(count), f"{answers} answers", end, sorted(set(trouble))[:6], flush=True)
    fields = total["right"] + total["asked"] + total["wrong"]
    print(f"{total['right'] / fields:.1%} of {fields} fields right unasked; {dict(total)}")


if __name__ == "__main__":
    main()
