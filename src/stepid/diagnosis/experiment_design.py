"""Fifth question: which run would tell the models apart that the data cannot."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from stepid.core.base import Array
from stepid.core.experiment import Campaign, Experiment
from stepid.core.words import length
from stepid.fitting.levenberg_marquardt import Optimum
from stepid.simulation.records import Records, lay_out
from stepid.simulation.simulator import Simulator

_SAMPLES = 400


def _proposals(campaign: Campaign) -> list[tuple[str, Experiment]]:
    """Runs one could add to a campaign, each in words and as an experiment without measured positions."""
    first = max(campaign.experiments, key=lambda e: float(np.abs(e.input).max()))
    level = float(first.input[np.argmax(np.abs(first.input))])
    heaviest = max(e.added_mass for e in campaign.experiments)
    h, n = first.sample_time, _SAMPLES
    half = n // 2

    def run(name: str, levels: tuple[float, float], mass: float | None = None, step: float = h) -> Experiment:
        volts = np.where(np.arange(n) < half, levels[0], levels[1])
        volts[:4] = 0.0
        return Experiment(
            name=name,
            time=np.arange(n, dtype=np.float64) * step,
            position=np.zeros(n),
            input=volts,
            added_mass=first.added_mass if mass is None else mass,
            spring=first.spring,
            damper=first.damper,
            base=first.base,
        )

    if level == 0:
        return []
    return [
        (f"a step of {-level:g} V, the other way, and back", run("other way", (-level, 0.0))),
        (f"a step of {level:g} V with the step back to 0 V in the record", run("back", (level, 0.0))),
        (f"a step of {level / 2:g} V, half the size, and back", run("half", (level / 2, 0.0))),
        (f"a step of {1.6 * level:.3g} V, a larger one, if the travel allows", run("larger", (1.6 * level, 0.0))),
        (f"a step of {level:g} V with {heaviest + 1.0:g} kg added", run("heavier", (level, 0.0), heaviest + 1.0)),
        (f"a step of {level:g} V sampled every {h / 4 * 1e3:.3g} ms", run("faster", (level, level), None, h / 4)),
    ]


def _answers(records: Records, optimum: Optimum) -> Array:
    """What a fitted model reads in runs from rest, m, shape (S,); not finite where it runs away."""
    sim = Simulator(records, optimum.problem.simulator.effects)
    still = np.zeros((1, sim.layout.n_run, len(records.runs)))
    out: Array = sim.readings(optimum.shared[None], still)[0]
    return out


def next_experiment(
    campaign: Campaign, chosen: Optimum, rivals: list[Optimum], *, floor: float, tell: Callable[[Optimum], str]
) -> str | None:
    """Name the run on which the rival models differ most, both simulated with the parameters they were fitted with.

    Parameters
    ----------
    campaign : Campaign
    chosen, rivals : Optimum
        Fits that the data cannot tell apart.
    floor : float
        m, noise.
    tell : callable
        Names an optimum in words.
    """
    best: tuple[float, str] = (0.0, "")
    proposals = _proposals(campaign)
    if proposals:
        records = lay_out(campaign).like([experiment for _, experiment in proposals])
        base = _answers(records, chosen)
        apart = [records.centered(base - _answers(records, rival)) for rival in rivals]
        for (words, _), piece in zip(proposals, records.pieces(), strict=True):
            gaps = [float(np.sqrt(np.mean(a[piece] ** 2))) for a in apart if np.isfinite(a[piece]).all()]
            if gaps and min(gaps) > best[0]:
                best = (min(gaps), words)
    names = " or ".join(tell(r) for r in rivals)
    if best[0] < 0.5 * floor:
        return (
            f"None of the usual extra runs would tell {tell(chosen)} from {names}: in all of them the models differ by "
            "less than half the noise. Lower the noise, or sample faster."
        )
    return (
        f"To tell {tell(chosen)} from {names}, record {best[1]}. There the models differ by {length(best[0])} RMS, "
        f"{best[0] / floor:.2g} times the noise."
    )
