"""Simulate a plant model on the input of a campaign."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stepid.core.arguments import as_campaign
from stepid.core.base import Array
from stepid.core.experiment import Campaign
from stepid.core.quantities import in_own_quantities
from stepid.core.takes import takes
from stepid.effects import CATALOGUE, Effect, resolve
from stepid.errors import ConvergenceError, InputError
from stepid.simulation.layout import DEVIATIONS, own_state_names
from stepid.simulation.model import PlantModel, RunState, a_model
from stepid.simulation.records import Records, lay_out
from stepid.simulation.simulator import FINE, PATIENT, Simulator, Solved


def pack(model: PlantModel, records: Records, effects: tuple[Effect, ...]) -> tuple[Array, Array]:
    """Write a model as the simulator's parameter arrays: shared (P,) and local (Q, R)."""

    def by_label(values: object, labels: tuple[str, ...], what: str) -> list[float]:
        assert isinstance(values, dict)
        missing = [label for label in labels if label not in values]
        if missing:
            raise InputError(
                f"the model has no {what} for the label {missing[0]!r}", f"It knows: {', '.join(map(str, values))}."
            )
        return [values[label] for label in labels]

    shared = [
        *by_label(model.base_mass, records.bases, "base mass"),
        *by_label(model.stiffness, records.springs, "stiffness"),
        *by_label(model.damping, records.dampers, "damping"),
        model.force_gain,
    ]
    for effect, own in zip(effects, model.effects, strict=True):
        for parameter in effect.parameters:
            if parameter.name not in own.values:
                raise InputError(
                    f"the model's {effect.name} has no {parameter.name}", f"Give {parameter.name} in {parameter.unit}."
                )
            shared.append(own.values[parameter.name])
    states = [model.runs.get(e.name, RunState()) for e in records.runs]
    local = [[s.displacement for s in states], [s.velocity for s in states]]
    for effect in effects:
        for parameter in effect.run_parameters:
            key = f"{effect.name}.{parameter.name}"
            local.append([s.phases.get(key, 0.0) for s in states])
    local += [[s.states.get(key, 0.0) for s in states] for key in own_state_names(effects)]
    local += [[s.deviations.get(q.name, 0.0) for s in states] for q in DEVIATIONS]
    return np.array(shared), np.array(local)


def solve_model(
    model: PlantModel, campaign: Campaign, *, catalogue: tuple[Effect, ...] = CATALOGUE, tolerance: float = FINE
) -> tuple[Records, Solved]:
    """Simulate all records; see `simulate`."""
    effects = resolve([e.name for e in model.effects], catalogue=catalogue)
    records = lay_out(as_campaign(campaign))
    states = [model.runs.get(e.name, RunState()) for e in records.runs]
    moves = [
        e.is_release or e.starts == "motion" or s.velocity != 0 or bool(s.states)
        for e, s in zip(records.runs, states, strict=True)
    ]  # a driven run without a speed of its own is at rest, whatever its positions show
    records = replace(records, moving=records.moving & np.array(moves))
    shared, local = pack(model, records, effects)
    solved = Simulator(records, effects, tolerance, patience=PATIENT).solve(shared, local)
    if solved is None:
        raise ConvergenceError(
            f"the simulation of campaign {campaign.name!r} runs away",
            "Check the model's parameters: a softening spring or a negative mass has no bounded response, and a part "
            "that is far faster than the samples cannot be followed.",
        )
    return records, solved


@in_own_quantities
@takes(model=a_model)
def simulate(model: PlantModel, campaign: Campaign, *, catalogue: tuple[Effect, ...] = CATALOGUE) -> dict[str, Array]:
    """Simulate a plant model on a campaign's measured inputs, between the samples as each run's `input_between` says.

    Parameters
    ----------
    model : PlantModel
    campaign : Campaign
        Its inputs, times and labels are used; positions only where the model has no state of a run, to fit the rest
        position, and where a hand holds the cart before a release.
    catalogue : tuple of Effect
        Where the model's effects are looked up.

    Returns
    -------
    dict
        Run name to position [m], shape (n,) of the run.

    Raises
    ------
    stepid.errors.InputError
        If the model lacks a label of the campaign, or names an effect that is not in the catalogue.
    stepid.errors.ConvergenceError
        If the response runs away.
    """
    records, solved = solve_model(model, campaign, catalogue=catalogue)
    out: dict[str, Array] = {}
    for i, (run, piece) in enumerate(zip(records.runs, records.pieces(), strict=True)):
        reading = solved.reading[piece]
        rest = model.runs[run.name].rest if run.name in model.runs else np.mean(records.position[piece] - reading)
        held = np.array(run.position[: records.begin[i]])
        out[run.name] = np.concatenate([held, reading + rest])
    return out
