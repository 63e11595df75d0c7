"""Public functions with arguments that are right: models, what identifies and fits, readers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

import stepid
from stepid import lab
from stepid.effects import resolve

Call = tuple[Callable[..., Any], Mapping[str, Any]]
COUNTS = 226600.0


def record(name: str, added: float, *, volts: float = 0.5, seed: int = 0) -> stepid.Experiment:
    """A step response with the noise of an encoder."""
    time = 0.0088542 * np.arange(300)
    mass, stiffness, damping = 0.95 + added, 216.0, 7.0
    since = np.maximum(time - time[20], 0)
    decay = damping / 2 / mass
    turn = np.sqrt(stiffness / mass - decay**2)
    swing = 1 - np.exp(-decay * since) * (np.cos(turn * since) + decay / turn * np.sin(turn * since))
    noise = 15e-6 * np.random.default_rng(seed).standard_normal(time.size)
    return stepid.Experiment(
        name=name,
        time=time,
        position=np.round((7.8 * volts / stiffness * swing + noise) * COUNTS) / COUNTS,
        input=np.where(time >= time[20], volts, 0.0),
        added_mass=added,
        spring="medium",
        damper="half",
        counts_per_meter=COUNTS,
    )


def made(folder: Path) -> SimpleNamespace:
    """What the calls are made of."""
    runs = [record("case 1", 0.0), record("case 2", 1.0, seed=1), record("case 3", 2.0, volts=-0.5, seed=2)]
    campaign = stepid.Campaign(name="four", experiments=tuple(runs))
    stepid.write_campaign(campaign, folder / "lab")
    frame = campaign.to_dataframe()
    one = runs[0].to_dataframe()
    table = folder / "table.csv"
    table.write_text("t,x,u\n" + "".join(f"{t},{x},{u}\n" for t, x, u in one.itertuples(index=False)))
    side = folder / "side.csv"
    side.write_text("t,x1,x2,u\n" + "".join(f"{t},{x},{x},{u}\n" for t, x, u in one.itertuples(index=False)))
    export = next((folder / "lab").glob("*.txt"))
    found = stepid.characterize_each(runs[0])
    every = [stepid.characterize(run) for run in runs]
    parameters = stepid.identify(campaign)
    system = stepid.assemble(every, campaign.mass_offsets)
    verified = stepid.verify(parameters, campaign)
    fitted = stepid.fit(campaign)
    diagnosis = stepid.diagnose(campaign, effort=stepid.Effort.quick())
    answers = lab.make(seed="a sentence for the benchmark", groups=("A",), effects=("coulomb_friction",))
    submission = lab.Submission(group="A", parameters=fitted.parameters, effects=())
    submission.write(folder / "a.json")
    answers.write(folder / "class", passphrase="correct horse")
    catalogue = resolve(["coulomb_friction", "cubic_stiffness"])
    response = stepid.to_time_response(runs[0])
    system_of = stepid.nonlinear_system(fitted.model, runs[0])
    axes = plt.figure().add_subplot()
    fields = {n: getattr(runs[0], n) for n in type(runs[0]).model_fields}
    paper = stepid.rebuild_paper()
    labels = {"name": "a", "added_mass": 0.0, "spring": "s", "damper": "d"}
    scales = {"time_scale": 1.0, "position_scale": 1.0, "input_scale": 1.0}
    return SimpleNamespace(**locals())


def of_models(m: SimpleNamespace) -> list[Call]:
    """Constructors of models."""
    every = (
        m.found[0],
        m.every[0].uncertainty,
        m.campaign,
        m.campaign.mass_offsets[0],
        m.system,
        m.parameters,
        m.fitted,
        m.fitted.model,
        m.diagnosis,
        stepid.Criteria(),
        stepid.Effort(),
        stepid.StepInput(level=1.0),
        m.submission,
        lab.Rig(),
        lab.Draw(),
        m.answers.answers.answers[0],
        m.fitted.parameters["base_mass"],
        m.verified,
        stepid.WeightedLeastSquares(),
    )
    return [(type(one), {n: getattr(one, n) for n in type(one).model_fields}) for one in every]


def of_methods(m: SimpleNamespace) -> list[Call]:
    """What identifies, fits and diagnoses."""
    return [
        (m.runs[0].slice, {"first": 0, "last": 100, "name": "x"}),
        (m.runs[0].slice, {"after": 0.1, "until": 1.5}),
        (m.campaign.__getitem__, {"name": "case 1"}),
        (stepid.characterize, {"experiment": m.runs[0], "peak": stepid.InterpolatedPeak()}),
        (stepid.characterize_all, {"experiment": m.runs[0], "peak": None}),
        (stepid.characterize_each, {"experiment": m.runs[0], "peak": None}),
        (stepid.assemble, {"characteristics": m.every, "mass_offsets": m.campaign.mass_offsets}),
        (stepid.identify, {"campaign": m.campaign, "peak": None, "solver": None}),
        (stepid.find_trends, {"runs": m.every}),
        (stepid.split_releases, {"experiment": m.runs[0]}),
        (stepid.fit, {"campaign": m.campaign, "effects": (), "catalogue": m.catalogue, "workers": 1}),
        (stepid.simulate, {"model": m.fitted.model, "campaign": m.campaign, "catalogue": m.catalogue}),
        (
            stepid.diagnose,
            {
                "campaign": m.campaign,
                "catalogue": m.catalogue,
                "criteria": None,
                "effort": stepid.Effort.quick(),
                "progress": None,
                "workers": 1,
            },
        ),
        (
            stepid.diagnose_many,
            {"campaigns": [], "catalogue": m.catalogue, "criteria": None, "effort": None, "executor": None},
        ),
        (stepid.Effort().scaled, {"times": 2}),
        (stepid.write_campaign, {"campaign": m.campaign, "folder": m.folder / "new"}),
        (resolve, {"effects": ("coulomb_friction",), "catalogue": m.catalogue}),
        (m.parameters.run_stiffness, {"name": "case 1"}),
        (m.parameters.base_difference, {"from_base": "cart", "to_base": "cart"}),
        (m.parameters.correlation, {"one": "case 1", "two": "case 2"}),
        (stepid.StepInput(level=1.0).values, {"time": m.runs[0].time, "before": 0.0}),
        (m.diagnosis.to_html, {"path": m.folder / "r"}),
    ]


def of_readers(m: SimpleNamespace) -> list[Call]:
    """What reads and writes."""
    labels, scales = m.labels, m.scales
    return [
        (stepid.Experiment, m.fields),
        (
            stepid.Experiment.from_dataframe,
            {
                "frame": m.one,
                **labels,
                "time": "time",
                "position": "position",
                "input": "input",
                **scales,
                "counts_per_meter": None,
                "input_before": 0.0,
                "base": "b",
                "input_between": "held",
                "starts": "auto",
            },
        ),
        (stepid.Campaign.from_dataframe, {"frame": m.frame, "name": "c", "weight_uncertainty": 0.005, **scales}),
        (stepid.read_campaign, {"path": m.folder / "lab", "allow_outside": False}),
        (
            stepid.read_ecp,
            {
                "path": m.export,
                "counts_per_meter": COUNTS,
                "encoder": 1,
                "input": None,
                "input_before": 0.0,
                "input_between": "held",
                "starts": "auto",
                "sample_time": None,
                "columns": None,
                "effort_scale": None,
                **labels,
                "base": "cart",
            },
        ),
        (
            stepid.read_table,
            {
                "paths": m.table,
                "position": "x",
                "time": "t",
                "input": "u",
                **scales,
                "sample_time": None,
                **labels,
                "base": "b",
                "counts_per_meter": None,
                "input_before": 0.0,
                "input_between": "held",
                "starts": "auto",
                "delimiter": None,
                "decimal": ".",
                "skiprows": 0,
                "start": 0,
                "stop": None,
            },
        ),
        (
            stepid.read_tables,
            {
                "paths": m.side,
                "position": "x",
                "time": "t",
                "input": "u",
                "runs": None,
                "name": None,
                "added_mass": 0.0,
                "spring": "s",
                "damper": "d",
                "base": "b",
                "delimiter": None,
                "decimal": ".",
                "skiprows": 0,
                "sample_time": None,
                "position_scale": 1.0,
            },
        ),
    ]
