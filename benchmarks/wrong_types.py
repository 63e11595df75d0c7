"""Calls of every public function with one argument of a wrong type or value: only stepid's own errors may come out.

python benchmarks/wrong_types.py [calls] [seed]
"""

from __future__ import annotations

import random
import sys
import tempfile
import time
import warnings
from collections import Counter
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np

mpl.use("Agg")
import matplotlib.pyplot as plt

import stepid
from stepid import lab, plot
from stepid.core.takes import described
from stepid.effects import resolve
from stepid.errors import StepidError

SLOWEST = 5.0  # s
COUNTS = 226600.0
Call = tuple[Callable[..., Any], Mapping[str, Any]]


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


def wrong_values(own: Any) -> list[Any]:
    """What an argument is not; some may be right by chance."""
    masked = np.ma.masked_greater(np.linspace(0, 1, 300), 0.9)
    return [
        None, 0, -1, 3, 1.5, -2.5, float("nan"), float("inf"), 10**400, True, 1j, "", "x", "coulomb_friction", "\0",
        "../x", b"x", (), [], {}, [None], ["x"], (1, 2), {"a": 1}, {"case 1": None}, set(), frozenset({1}), object(),
        type, int, len, lambda: 1, iter(()), np.array(1.0), np.zeros(300), np.full(300, np.nan), np.zeros((3, 3)), masked,
        np.array(["a"]), np.float32(1), np.int64(-3), Path("nowhere"), stepid.WeightedLeastSquares,
        stepid.InterpolatedPeak, stepid.StepInput(level=1.0), slice(3), range(3), ValueError("x"), 10**5000, own,
    ]  # fmt: skip


def calls(folder: Path) -> list[Call]:
    """Each public function with arguments that are right."""
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
    models: list[Call] = [
        (type(m), {n: getattr(m, n) for n in type(m).model_fields})
        for m in (
            found[0], every[0].uncertainty, campaign, campaign.mass_offsets[0], system, parameters, fitted, fitted.model,
            diagnosis, stepid.Criteria(), stepid.Effort(), stepid.StepInput(level=1.0), submission, lab.Rig(), lab.Draw(),
            answers.answers.answers[0], fitted.parameters["base_mass"], verified, stepid.WeightedLeastSquares(),
        )
    ]  # fmt: skip
    return [
        *models,
        (stepid.Experiment, fields),
        (stepid.Experiment.from_dataframe, {"frame": one, **labels, "time": "time", "position": "position", "input": "input", **scales, "counts_per_meter": None, "input_before": 0.0, "base": "b", "input_between": "held", "starts": "auto"}),
        (stepid.Campaign.from_dataframe, {"frame": frame, "name": "c", "weight_uncertainty": 0.005, **scales}),
        (runs[0].slice, {"first": 0, "last": 100, "name": "x"}),
        (runs[0].slice, {"after": 0.1, "until": 1.5}),
        (campaign.__getitem__, {"name": "case 1"}),
        (stepid.characterize, {"experiment": runs[0], "peak": stepid.InterpolatedPeak()}),
        (stepid.characterize_all, {"experiment": runs[0], "peak": None}),
        (stepid.characterize_each, {"experiment": runs[0], "peak": None}),
        (stepid.assemble, {"characteristics": every, "mass_offsets": campaign.mass_offsets}),
        (stepid.solve, {"system": system, "solver": None}),
        (stepid.identify, {"campaign": campaign, "peak": None, "solver": None}),
        (stepid.find_trends, {"runs": every}),
        (stepid.verify, {"parameters": parameters, "campaign": campaign}),
        (stepid.split_releases, {"experiment": runs[0]}),
        (stepid.fit, {"campaign": campaign, "effects": (), "catalogue": catalogue, "workers": 1}),
        (stepid.simulate, {"model": fitted.model, "campaign": campaign, "catalogue": catalogue}),
        (stepid.diagnose, {"campaign": campaign, "catalogue": catalogue, "criteria": None, "effort": stepid.Effort.quick(), "progress": None, "workers": 1}),
        (stepid.diagnose_many, {"campaigns": [], "catalogue": catalogue, "criteria": None, "effort": None, "executor": None}),
        (stepid.Effort().scaled, {"times": 2}),
        (stepid.read_campaign, {"path": folder / "lab", "allow_outside": False}),
        (stepid.write_campaign, {"campaign": campaign, "folder": folder / "new"}),
        (stepid.read_ecp, {"path": export, "counts_per_meter": COUNTS, "encoder": 1, "input": None, "input_before": 0.0, "input_between": "held", "starts": "auto", "sample_time": None, "columns": None, "effort_scale": None, **labels, "base": "cart"}),
        (stepid.read_table, {"paths": table, "position": "x", "time": "t", "input": "u", **scales, "sample_time": None, **labels, "base": "b", "counts_per_meter": None, "input_before": 0.0, "input_between": "held", "starts": "auto", "delimiter": None, "decimal": ".", "skiprows": 0, "start": 0, "stop": None}),
        (stepid.read_tables, {"paths": side, "position": "x", "time": "t", "input": "u", "runs": None, "name": None, "added_mass": 0.0, "spring": "s", "damper": "d", "base": "b", "delimiter": None, "decimal": ".", "skiprows": 0, "sample_time": None, "position_scale": 1.0}),
        (stepid.transfer_function, {"source": parameters, "run": "case 1", "catalogue": catalogue}),
        (stepid.transfer_function, {"source": fitted.model, "run": runs[0], "catalogue": catalogue}),
        (stepid.state_space, {"source": fitted.model, "run": runs[0], "catalogue": catalogue}),
        (stepid.nonlinear_system, {"model": fitted.model, "run": runs[0], "catalogue": catalogue}),
        (stepid.initial_state, {"model": fitted.model, "run": runs[0], "catalogue": catalogue}),
        (stepid.simulate_system, {"system": system_of, "run": runs[0], "initial_state": None}),
        (stepid.to_time_response, {"run": runs[0], "position": None}),
        (stepid.from_time_response, {"data": response, **labels, "output": None, "input": None, "trace": None, "counts_per_meter": None, "input_before": 0.0, "base": "b", "input_between": "held", "starts": "auto"}),
        (resolve, {"effects": ("coulomb_friction",), "catalogue": catalogue}),
        (parameters.run_stiffness, {"name": "case 1"}),
        (parameters.base_difference, {"from_base": "cart", "to_base": "cart"}),
        (parameters.correlation, {"one": "case 1", "two": "case 2"}),
        (verified.__getitem__, {"name": "case 1"}),
        (stepid.StepInput(level=1.0).values, {"time": runs[0].time, "before": 0.0}),
        (diagnosis.to_html, {"path": folder / "r"}),
        (lab.make, {"seed": "a sentence for the benchmark", "groups": ("A",), "effects": (), "visibility": (5.0, 25.0), "rig": None, "catalogue": catalogue}),
        (lab.check, {"answer": answers.answers["A"], "submission": submission, "tolerance": 0.05, "catalogue": catalogue}),
        (lab.check_all, {"answers": answers.answers, "submissions": [submission], "tolerance": 0.05, "catalogue": catalogue}),
        (lab.confirm, {"answer": answers.answers["A"], "folder": folder / "class" / "A"}),
        (lab.open_answers, {"path": folder / "class", "passphrase": "correct horse"}),
        (lab.read_submission, {"path": folder / "a.json"}),
        (lab.read_submissions, {"folder": folder}),
        (submission.write, {"path": folder / "b.json"}),
        (answers.write, {"folder": folder / "again", "passphrase": "correct horse"}),
        (answers.__getitem__, {"group": "A"}),
        (lab.Rig().inputs, {"level": 0.5}),
        (plot.candidates, {"d": diagnosis, "axes": axes}),
        (plot.diagnosis, {"d": diagnosis, "runs": (), "axes": None}),
        (plot.force_against_position, {"d": diagnosis, "axes": axes}),
        (plot.force_against_velocity, {"d": diagnosis, "axes": axes}),
        (plot.gap_bars, {"d": diagnosis, "axes": axes}),
        (plot.gap_residual, {"d": diagnosis, "name": "case 1", "axes": axes, "largest": None}),
        (plot.gap_response, {"d": diagnosis, "name": "case 1", "axes": axes}),
        (plot.gap_runs, {"d": diagnosis, "columns": 3, "axes": None}),
        (plot.phase_bars, {"d": diagnosis, "axes": axes}),
        (plot.paper_figure, {"run": paper.responses[0], "axes": None}),
        (plot.residual, {"run": verified["case 1"], "axes": axes}),
        (plot.response, {"run": verified["case 1"], "axes": axes}),
        (plot.save, {"axes": axes, "path": folder / "a.png"}),
        (plot.trends, {"found": stepid.find_trends(every), "axes": None}),
        (plot.verification, {"run": verified["case 1"], "axes": None}),
        (plot.verification_grid, {"verified": verified, "columns": 3, "axes": None}),
    ]  # fmt: skip


def attack(folder: Path, count: int, seed: int, *, only: str = "") -> tuple[Counter[str], list[str]]:
    """Call `count` times; return how the calls ended, and what came out that is not stepid's."""
    prepared = [
        (function, arguments, name)
        for function, arguments in calls(folder)
        for name in arguments
        if only in f"{getattr(function, '__qualname__', function)}.{name}"
    ]
    every = [(f, a, n, i) for f, a, n in prepared for i in range(len(wrong_values(None)))]
    rng = random.Random(seed)
    chosen = rng.sample(every, min(count, len(every)))
    ends: Counter[str] = Counter()
    foreign = []
    for function, arguments, name, i in chosen:
        value = wrong_values(arguments[name])[i]
        who = f"{getattr(function, '__qualname__', function)}({name}={described(value)})"
        began = time.process_time()
        by_place = function.__name__ in ("__getitem__",)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                function(value) if by_place else function(**{**arguments, name: value})
            ends["accepted"] += 1
        except StepidError as error:
            ends["stepid's error"] += 1
            if not error.remedy:
                foreign.append(f"{who}: no remedy: {error}")
        except Exception as error:  # noqa: BLE001 - that is what is looked for
            ends["foreign"] += 1
            foreign.append(f"{who}: {type(error).__name__}: {str(error)[:100]}")
        if (took := time.process_time() - began) > SLOWEST:
            foreign.append(f"{who}: took {took:.1f} s")
        plt.close("all")
    return ends, foreign


def main() -> None:
    """Attack, and list what is wrong."""
    count, seed = (int(v) for v in [*sys.argv[1:3], *("4000", "1")[len(sys.argv[1:3]) :]])
    with tempfile.TemporaryDirectory() as scratch:
        ends, foreign = attack(Path(scratch), count, seed, only=sys.argv[3] if len(sys.argv) > 3 else "")
    print(*foreign, sep="\n")
    print(f"{sum(ends.values())} calls: {dict(ends)}; {len(foreign)} wrong")


if __name__ == "__main__":
    main()
