"""Records that are the same, sample for sample, which no two measurements are."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

import numpy as np
import numpy.typing as npt

from stepid.core.experiment import Experiment
from stepid.core.samples import EVEN

_SAID = ("added_mass", "spring", "damper", "base", "input_between")


def copies(runs: Iterable[Experiment]) -> dict[str, str]:
    """Find runs that hold the record of another: all but the first of equal labels, all of different labels.

    Parameters
    ----------
    runs : iterable of Experiment

    Returns
    -------
    dict
        Name of a run that is to be left out to the reason, in words.
    """
    groups: dict[bytes, list[Experiment]] = {}
    for run in runs:
        groups.setdefault(run.position.tobytes(), []).append(run)
    left_out: dict[str, str] = {}
    for first, *others in groups.values():
        if not others:
            continue
        names = ", ".join(repr(run.name) for run in (first, *others))
        if all(are_repeats(first, run) for run in others):
            why = f"Runs {names} hold the same record, sample for sample: copies, no repeats; one of them is used."
            left_out |= {run.name: why for run in others}
        else:
            why = (
                f"Runs {names} hold the same record under different labels: at most one of them is what it says, "
                "and they are left out. Check their files."
            )
            left_out |= {run.name: why for run in (first, *others)}
    return left_out


def are_repeats(one: Experiment, other: Experiment, *, within: float = 0.0) -> bool:
    """Tell whether two runs have in common what repeats have: labels, added mass, clock and input.

    Inputs `within` so much of their range of each other count as one: what is measured never is the same.
    """
    if one.input.size != other.input.size or not have_one_label(one, other):
        return False
    late = np.abs((one.time - one.time[0]) - (other.time - other.time[0])).max()
    apart = max(np.abs(one.input - other.input).max(), abs(one.input_before - other.input_before))
    return bool(late <= EVEN * one.sample_time and apart <= within * np.ptp(one.input))


def have_one_label(one: Experiment, other: Experiment) -> bool:
    """Tell whether two runs are said to be of one plant: labels and added mass."""
    return all(getattr(one, name) == getattr(other, name) for name in _SAID)


def grouped(
    runs: Sequence[Experiment], alike: Callable[[Experiment, Experiment], bool] = are_repeats
) -> list[list[int]]:
    """Indices of runs in groups, each of those that are `alike` its first; the groups in the order of their firsts."""
    groups: list[list[int]] = []
    for i, run in enumerate(runs):
        known = next((group for group in groups if alike(runs[group[0]], run)), None)
        if known is None:
            groups.append([i])
        else:
            known.append(i)
    return groups


def group_of_each(runs: Sequence[Experiment], alike: Callable[[Experiment, Experiment], bool]) -> npt.NDArray[np.intp]:
    """Number of the group of each run, shape (R,); see `grouped`."""
    out = np.zeros(len(runs), dtype=np.intp)
    for number, group in enumerate(grouped(runs, alike)):
        out[group] = number
    return out
