"""Every figure function of stepid.plot on data of closed form, at the width of a journal column or of a page."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import stepid
from stepid import plot
from stepid.diagnosis.result import Diagnosis, Gap, Ranked, RunGap, Where
from stepid.identification.transfer.verification import Verification, VerificationRun
from stepid.identification.trends import Trend, Trends
from stepid.plot.layout import new_figure
from stepid.plot.style import COLUMN, figure_of

TIME = 0.01 * np.arange(240)


def step(mass: float, damping: float) -> np.ndarray:
    """Response [m] of a plant of 216 N/m to a force of 3.9 N at 0.1 s, underdamped."""
    rate, natural = damping / (2 * mass), np.sqrt(216.0 / mass)
    swing = np.sqrt(natural**2 - rate**2)
    t = np.maximum(TIME - 0.1, 0.0)
    return 3.9 / 216.0 * (1 - np.exp(-rate * t) * (np.cos(swing * t) + rate / swing * np.sin(swing * t)))


def ripple(size: float, rate: float) -> np.ndarray:
    """What stands for noise: the same on every machine."""
    return size * np.sin(rate * np.arange(TIME.size) ** 1.5)


def verified(name: str, mass: float) -> VerificationRun:
    model = step(mass, 14.0)
    measured = step(mass, 16.0) + ripple(2e-5, 0.7)
    peak = float(TIME[int(np.argmax(measured))])
    return VerificationRun(
        name=name, time=TIME, measured=measured, simulated=model, fit_percent=94.2, rms=4e-4, peak_time=peak
    )


def measured() -> stepid.Campaign:
    def run(number: int, mass: float) -> stepid.Experiment:
        level = 0.5 - 0.12 * number
        given = {"added_mass": mass - 0.95, "spring": "medium", "damper": "1/2 turn"}
        u = np.where(0.1 + 0.05 * number <= TIME, level, 0.0)
        return stepid.Experiment(
            name=f"case {number + 4}", time=TIME, position=2 * level * step(mass, 14.0), input=u, **given
        )

    return stepid.Campaign(name="cases 4 to 7", experiments=[run(i, m) for i, m in enumerate((0.95, 1.45, 2.45, 2.95))])


def verification() -> Verification:
    return Verification(runs=tuple(verified(f"case {i + 4}", m) for i, m in enumerate((0.95, 1.45, 2.45, 2.95))))


def trends() -> Trends:
    def run(name: str, added: float, spring: str, damper: str, *values: float) -> stepid.Characteristics:
        peak, overshoot, settling, gain = values
        spread = stepid.CharacteristicsUncertainty(
            peak_time=0.01, overshoot=0.02, settling_time=0.05, static_gain=0.0006
        )
        return stepid.Characteristics(
            name=name,
            added_mass=added,
            spring=spring,
            damper=damper,
            peak_time=peak,
            overshoot=overshoot,
            settling_time=settling,
            static_gain=gain,
            uncertainty=spread,
        )

    runs = [
        run(f"case {i}", m, "medium", "1/2 turn", 0.24 + 0.05 * i, 0.15 + 0.06 * i, 0.6 + 0.1 * i, 0.036 + 0.001 * i)
        for i, m in enumerate((0.0, 0.5, 1.5, 2.0))
    ]
    loose = run("case 8", 0.5, "medium", "plug removed", 0.27, 0.5, 1.4, 0.0365)
    return Trends(
        trends=(
            Trend(varies="mass", held="medium spring, damper 1/2 turn", runs=tuple(runs)),
            Trend(varies="damping", held="medium spring, 0.5 kg", runs=(loose, runs[1])),
        )
    )


def diagnosis() -> Diagnosis:
    """Coulomb friction named in four runs; every number follows from closed forms."""
    runs = []
    for i, mass in enumerate((0.95, 1.45, 2.45, 2.95)):
        model, linear = step(mass, 14.0), step(mass * 1.02, 14.0 + 1.5 * (i + 1))
        measured = model + ripple(8e-5, 0.7 + 0.1 * i)
        before, after = (float(np.sqrt(np.mean((measured - y) ** 2))) for y in (linear, model))
        runs.append(
            RunGap(
                name=f"case {i + 4}",
                time=TIME,
                measured=measured,
                linear=linear,
                model=model,
                before=before,
                after=after,
                phases={"overshoot": before},
            )
        )
    v, x = np.linspace(-0.17, 0.17, 20), np.linspace(-0.02, 0.03, 20)
    where = Where(
        phases={"before": 2e-5, "rise": 4e-4, "overshoot": 5.5e-4, "ring-down": 7e-4, "rest": 6e-4},
        velocity_levels=v,
        velocity_force=-0.3 * np.sign(v) - 0.02 * np.cos(60 * v),
        position_levels=x,
        position_force=0.05 * np.sin(300 * x),
        runs={run.name: run.before for run in runs},
        trends={},
        sentences=("largest in the ring-down",),
        jump=-0.6,
    )
    plain = stepid.PlantModel(
        base_mass={"cart": 0.95}, stiffness={"medium": 216.0}, damping={"1/2 turn": 14.0}, force_gain=7.8
    )
    return Diagnosis(
        campaign="cases 4 to 7",
        verdict="named",
        effects=("coulomb_friction",),
        gap=Gap(before=6e-4, after=6.2e-5, noise=6e-5, held_out_before=7e-4, held_out_after=6.5e-5),
        parameters={},
        linear_parameters={},
        where=where,
        ranking=(
            Ranked(effects=("coulomb_friction",), rms=6.2e-5, evidence=0.0, explained=0.989, probability=0.97),
            Ranked(
                effects=("quadratic_damping", "input_delay"),
                deviations=("start_time",),
                rms=2.4e-4,
                evidence=7.1,
                explained=0.84,
                probability=0.03,
            ),
            Ranked(
                effects=("load_proportional_friction", "position_dependent_damping"),
                rms=3e-4,
                evidence=21.0,
                explained=0.75,
            ),
            Ranked(effects=(), rms=6e-4, evidence=123456.0),
        ),
        runs=tuple(runs),
        model=plain,
        linear_model=plain,
    )


def column(draw: Callable[[Axes], object]) -> Figure:
    """One axes in a figure one column wide."""
    figure = new_figure(width=COLUMN, height=2.4)
    draw(figure.subplots())
    return figure


D = diagnosis()
COLUMN_CASES: dict[str, Callable[[], Figure]] = {
    "response": lambda: column(lambda a: plot.response(verified("case 6", 2.45), axes=a)),
    "residual": lambda: column(lambda a: plot.residual(verified("case 6", 2.45), axes=a)),
    "verification": lambda: figure_of(plot.verification(verified("case 6", 2.45))[0]),
    **{
        f"paper_figure {one.figure.removeprefix('Fig. ')}": lambda one=one: figure_of(plot.paper_figure(one)[0])  # type: ignore[misc]
        for one in stepid.rebuild_paper().responses
    },
    "gap_response": lambda: column(lambda a: plot.gap_response(D, "case 7", axes=a)),
    "gap_residual": lambda: column(lambda a: plot.gap_residual(D, "case 7", axes=a)),
    "gap_bars": lambda: column(lambda a: plot.gap_bars(D, axes=a)),
    "force_against_velocity": lambda: column(lambda a: plot.force_against_velocity(D, axes=a)),
    "force_against_position": lambda: column(lambda a: plot.force_against_position(D.where, axes=a)),
    "phase_bars": lambda: column(lambda a: plot.phase_bars(D, axes=a)),
    "candidates": lambda: column(lambda a: plot.candidates(D, axes=a)),
    "ring_down": lambda: column(lambda a: plot.ring_down(D, axes=a)),
}
PAGE_CASES: dict[str, Callable[[], Figure]] = {
    "records": lambda: figure_of(plot.records(measured())[0]),
    "verification_grid": lambda: figure_of(plot.verification_grid(verification(), columns=2)[0, 0]),
    "trend": lambda: figure_of(plot.trend(trends().trends[0])[0]),
    "trends": lambda: figure_of(plot.trends(trends())[0, 0]),
    "gap_runs": lambda: figure_of(plot.gap_runs(D, columns=2)[0, 0]),
    "diagnosis": lambda: figure_of(plot.diagnosis(D)["gap"]),
}
CASES = COLUMN_CASES | PAGE_CASES
plt.switch_backend("Agg")
