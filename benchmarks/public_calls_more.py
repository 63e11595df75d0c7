"""Public functions with arguments that are right: the bridge to python-control, classes, plots."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import SimpleNamespace
from typing import Any

import stepid
from stepid import lab, plot

Call = tuple[Callable[..., Any], Mapping[str, Any]]


def of_bridges(m: SimpleNamespace) -> list[Call]:
    """What goes to python-control, and verification."""
    labels = m.labels
    return [
        (stepid.solve, {"system": m.system, "solver": None}),
        (stepid.verify, {"parameters": m.parameters, "campaign": m.campaign}),
        (stepid.transfer_function, {"source": m.parameters, "run": "case 1", "catalogue": m.catalogue}),
        (stepid.transfer_function, {"source": m.fitted.model, "run": m.runs[0], "catalogue": m.catalogue}),
        (stepid.state_space, {"source": m.fitted.model, "run": m.runs[0], "catalogue": m.catalogue}),
        (stepid.nonlinear_system, {"model": m.fitted.model, "run": m.runs[0], "catalogue": m.catalogue}),
        (stepid.initial_state, {"model": m.fitted.model, "run": m.runs[0], "catalogue": m.catalogue}),
        (stepid.simulate_system, {"system": m.system_of, "run": m.runs[0], "initial_state": None}),
        (stepid.to_time_response, {"run": m.runs[0], "position": None}),
        (
            stepid.from_time_response,
            {
                "data": m.response,
                **labels,
                "output": None,
                "input": None,
                "trace": None,
                "counts_per_meter": None,
                "input_before": 0.0,
                "base": "b",
                "input_between": "held",
                "starts": "auto",
            },
        ),
        (m.verified.__getitem__, {"name": "case 1"}),
    ]


def of_classes(m: SimpleNamespace) -> list[Call]:
    """What a class needs."""
    return [
        (
            lab.make,
            {
                "seed": "a sentence for the benchmark",
                "groups": ("A",),
                "effects": (),
                "visibility": (5.0, 25.0),
                "rig": None,
                "catalogue": m.catalogue,
            },
        ),
        (
            lab.check,
            {"answer": m.answers.answers["A"], "submission": m.submission, "tolerance": 0.05, "catalogue": m.catalogue},
        ),
        (
            lab.check_all,
            {"answers": m.answers.answers, "submissions": [m.submission], "tolerance": 0.05, "catalogue": m.catalogue},
        ),
        (lab.confirm, {"answer": m.answers.answers["A"], "folder": m.folder / "class" / "A"}),
        (lab.open_answers, {"path": m.folder / "class", "passphrase": "correct horse"}),
        (lab.read_submission, {"path": m.folder / "a.json"}),
        (lab.read_submissions, {"folder": m.folder}),
        (m.submission.write, {"path": m.folder / "b.json"}),
        (m.answers.write, {"folder": m.folder / "again", "passphrase": "correct horse"}),
        (m.answers.__getitem__, {"group": "A"}),
        (lab.Rig().inputs, {"level": 0.5}),
    ]


def of_pictures(m: SimpleNamespace) -> list[Call]:
    """Plots."""
    return [
        (plot.candidates, {"d": m.diagnosis, "axes": m.axes}),
        (plot.diagnosis, {"d": m.diagnosis, "runs": (), "axes": None}),
        (plot.force_against_position, {"d": m.diagnosis, "axes": m.axes}),
        (plot.force_against_velocity, {"d": m.diagnosis, "axes": m.axes}),
        (plot.gap_bars, {"d": m.diagnosis, "axes": m.axes}),
        (plot.gap_residual, {"d": m.diagnosis, "name": "case 1", "axes": m.axes, "largest": None}),
        (plot.gap_response, {"d": m.diagnosis, "name": "case 1", "axes": m.axes}),
        (plot.gap_runs, {"d": m.diagnosis, "columns": 3, "axes": None}),
        (plot.phase_bars, {"d": m.diagnosis, "axes": m.axes}),
        (plot.paper_figure, {"run": m.paper.responses[0], "axes": None}),
        (plot.residual, {"run": m.verified["case 1"], "axes": m.axes}),
        (plot.response, {"run": m.verified["case 1"], "axes": m.axes}),
        (plot.save, {"axes": m.axes, "path": m.folder / "a.png"}),
        (plot.trends, {"found": stepid.find_trends(m.every), "axes": None}),
        (plot.verification, {"run": m.verified["case 1"], "axes": None}),
        (plot.verification_grid, {"verified": m.verified, "columns": 3, "axes": None}),
    ]


def of_results(m: SimpleNamespace) -> list[Call]:
    """What lasts, and what comes before the lab."""
    m.fitted.save(m.folder / "fit.json")
    guess = {"base_mass": 0.95, "stiffness": 216.0, "damping": 7.0, "force_gain": 7.8}
    few: dict[str, Any] = {"masses": (0.0, 1.0), "levels": (0.5,), "sample_times": (0.02,), "runs": (2,)}
    return [
        (m.fitted.save, {"path": m.folder / "again.json"}),
        (stepid.load, {"path": m.folder / "fit.json", "kind": stepid.Fit}),
        (
            stepid.plan,
            {"plant": guess, "noise": 5e-5, **few, "effects": (), "wanted": None, "separate": None, "duration": 2.0}
            | {"travel": None, "noise_time": 0.0, "weight_uncertainty": 0.005, "catalogue": m.catalogue},
        ),
    ]
