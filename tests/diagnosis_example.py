"""A diagnosis made by hand from four runs of the made-up lab campaign: what the texts and pictures are tested on."""

from __future__ import annotations

from functools import cache

import numpy as np

import stepid
from stepid.diagnosis.locate import locate, phases_of
from stepid.diagnosis.result import Diagnosis, Gap, Ranked, RunGap
from stepid.effects import resolve
from stepid.fitting.covariance import estimates
from stepid.fitting.fit import unpack
from stepid.fitting.levenberg_marquardt import minimize
from stepid.fitting.noise_floor import noise_floor
from stepid.fitting.problem import build, fit_linear, start_local
from stepid.simulation.records import lay_out

RUNS = ("case 4", "case 5", "case 6", "case 7")
LEVEL = 0.3  # N, hidden in the campaign


def campaign(*, runs: tuple[str, ...] = RUNS) -> stepid.Campaign:
    """Four runs with different added masses, or others."""
    lab = stepid.datasets.lab_campaign()
    return stepid.Campaign(name="cases 4 to 7", experiments=tuple(lab[name] for name in runs))


def rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


@cache
def named(*, runs: tuple[str, ...] = RUNS) -> Diagnosis:
    """Coulomb friction named, without a search: fitted from its true level."""
    measured = campaign(runs=runs)
    records = lay_out(measured)
    floor = noise_floor(records)
    linear = fit_linear(records)
    assert linear is not None
    effects = resolve(["coulomb_friction"])
    problem = build(records, effects)
    final = minimize(problem, np.append(linear.shared, LEVEL), start_local(problem, linear))
    assert final is not None
    phases = phases_of(records, linear, floor)
    gaps = []
    for run, piece in zip(records.runs, records.pieces(), strict=True):
        y, before, after = records.position[piece], linear.residual[piece], final.residual[piece]
        gaps.append(
            RunGap(
                name=run.name,
                time=records.time[piece],
                measured=y,
                linear=y - before,
                model=y - after,
                before=rms(before),
                after=rms(after),
                held_out_before=1.1 * rms(before),
                held_out_after=1.1 * rms(after),
                phases=phases[run.name],
                explained=1 - (rms(after) / rms(before)) ** 2,
            )
        )
    explained = 1 - (final.rms / linear.rms) ** 2
    return Diagnosis(
        campaign=measured.name,
        verdict="named",
        effects=("coulomb_friction",),
        advice={"coulomb_friction": resolve(["coulomb_friction"])[0].advice},
        gap=Gap(
            before=linear.rms,
            after=final.rms,
            noise=floor,
            held_out_before=1.1 * linear.rms,
            held_out_after=1.1 * final.rms,
        ),
        parameters=estimates(final, effects, floor)[0],
        linear_parameters=estimates(linear, (), floor)[0],
        where=locate(records, linear, floor),
        reasons=("With Coulomb friction the gap is at the floor.",),
        ranking=(
            Ranked(effects=("coulomb_friction",), rms=final.rms, evidence=0.0, probability=0.996, explained=explained),
            Ranked(
                effects=("quadratic_damping", "input_delay"),
                deviations=("start_time",),
                rms=0.4 * linear.rms,
                evidence=12.4,
                probability=0.004,
                explained=0.84,
            ),
            Ranked(effects=(), rms=linear.rms, evidence=123456.0),
        ),
        explained=explained,
        left=0.25,
        probability=0.98,
        runs=tuple(gaps),
        model=unpack(final, effects),
        linear_model=unpack(linear, ()),
        data=measured,
    )


def changed(d: Diagnosis, **fields: object) -> Diagnosis:
    """A diagnosis with other values of some fields."""
    return Diagnosis(**{name: getattr(d, name) for name in Diagnosis.model_fields} | fields)


def adequate() -> Diagnosis:
    """Nothing missing: the same numbers, with all the gap taken for noise."""
    d = named()
    return Diagnosis(
        campaign=d.campaign,
        verdict="adequate",
        effects=(),
        gap=Gap(before=d.gap.before, after=d.gap.before, noise=d.gap.before),
        parameters=d.linear_parameters,
        linear_parameters=d.linear_parameters,
        where=d.where,
        runs=tuple(RunGap(**r.model_dump() | {"model": r.linear, "after": r.before}) for r in d.runs),
        model=d.linear_model,
        linear_model=d.linear_model,
    )


def ambiguous() -> Diagnosis:
    """Two that cannot be told apart."""
    return changed(
        named(),
        verdict="ambiguous",
        alternatives=(("load_proportional_friction",),),
        next_experiment="record with more mass",
        notes=("The fit did not converge.",),
    )
