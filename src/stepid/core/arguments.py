"""Arguments of public functions that are easily something else."""

from __future__ import annotations

from stepid.core.experiment import Campaign, Experiment
from stepid.core.takes import a, article, described
from stepid.errors import InputError


def as_campaign(given: object) -> Campaign:
    """Return a campaign as it is; InputError says how to make one of a list, a data frame or a file."""
    if isinstance(given, Campaign):
        return given
    raise InputError(
        f"a Campaign is needed here, not {article(type(given).__name__)}",
        "Make one: stepid.Campaign(name=…, experiments=[…]) of experiments, Campaign.from_dataframe(frame, name=…) of a"
        " data frame, stepid.read_campaign(path) of files.",
    )


def as_experiment(given: object) -> Experiment:
    """Return an experiment as it is; InputError says how to come by one."""
    if isinstance(given, Experiment):
        return given
    raise InputError(
        f"an Experiment is needed here, not {article(type(given).__name__)}",
        "Give one run: campaign[name] of a campaign, stepid.Experiment.from_dataframe(frame, …) of a data frame, "
        "stepid.read_table(path, …) or stepid.read_ecp(path, …) of a file.",
    )


def as_workers(given: object) -> int:
    """Return a number of threads as it is; InputError where it is none."""
    if isinstance(given, int) and not isinstance(given, bool) and given >= 1:
        return given
    raise InputError(f"workers = {described(given)} is no number of threads", "Give a whole number, 1 or more.")


a_run = a((str, Experiment), "the name of a run, or the run itself: campaign[name]")
"""Check of an argument `run`."""
