"""Small results of most kinds: what saving is tested on, and what the files of a version are made from.

``python tests/saved_example.py`` writes the files of this version into ``tests/golden``; they are kept for good.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import diagnosis_example as example
import stepid
from stepid.core.base import Model
from stepid.diagnosis.result import Diagnosis, RunGap
from stepid.fitting.fit import Fit

GOLDEN = Path(__file__).parent / "golden"


@cache
def results() -> dict[str, Model]:
    """A name to a result; the campaign is read from files."""
    with TemporaryDirectory() as folder:
        campaign = stepid.read_campaign(stepid.write_campaign(example.campaign(), folder))
    parameters = stepid.identify(campaign)
    characteristics = [stepid.characterize(run) for run in campaign.experiments]
    return {
        "campaign": stepid.Campaign(name="short", experiments=tuple(run.slice(0, 60) for run in campaign.experiments)),
        "experiment": campaign["case 4"].slice(0, 40),
        "characteristics": characteristics[0],
        "system": stepid.assemble(characteristics, campaign.mass_offsets),
        "parameters": parameters,
        "trends": stepid.find_trends(characteristics),
        "fit": _fit(),
        "diagnosis": _short(example.named()),
        "verification": stepid.verify(parameters, stepid.Campaign(name="one", experiments=campaign.experiments[:1])),
        "estimate": stepid.Estimate(value=1.0, uncertainty=0.1, unit="kg"),
        "effort": stepid.Effort.quick(),
    }


def _fit() -> Fit:
    """A fit as the diagnosis has it, without fitting again."""
    d = example.named()
    return Fit(
        parameters=d.parameters,
        model=d.model,
        rms=d.gap.after,
        noise=d.gap.noise,
        run_rms={run.name: run.after for run in d.runs},
        correlation=[[1.0, 0.5], [0.5, 1.0]],
        converged=True,
        notes=("A note with µm and “quotes”.",),
    )


def _short(d: Diagnosis) -> Diagnosis:
    """A diagnosis with every fiftieth sample of its runs."""
    fields = ("time", "measured", "linear", "model")
    runs = tuple(RunGap(**r.model_dump() | {f: getattr(r, f)[::50] for f in fields}) for r in d.runs)
    return example.changed(d, runs=runs, data=None)


if __name__ == "__main__":
    target = GOLDEN / f"saved-{stepid.__version__}"
    for name, result in results().items():
        print(result.save(target / f"{name}.json").relative_to(GOLDEN))
