"""The picture of a plan's trade."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stepid.core.latex import parameter_name
from stepid.core.quantities import quantities_of
from stepid.errors import InputError
from stepid.lab.design.separation import NEEDED

if TYPE_CHECKING:
    from stepid.lab.design.result import Plan
    from stepid.plot.trade import Drawn

SEPARATION = "separation"


def draw(plan: Plan, axes: Drawn | None) -> Drawn:
    """Draw a plan; see `Plan.plot`."""
    from stepid.plot.trade import Panel, trade

    say = quantities_of(plan).text
    best = [plan.designs.index(plan.best(runs)) for runs in sorted({design.runs for design in plan.designs})]
    first = next(iter(plan.wanted), "")
    panels = {
        name: Panel(
            title=say(parameter_name(name.partition("[")[0])),
            label="standard uncertainty [%]" if name == first else "",
            values=[100 * plan.relative(design, name) for design in plan.designs],
            wanted=100 * limit,
            below=True,
            best=best,
            advised=plan.advised,
        )
        for name, limit in plan.wanted.items()
    }
    if plan.pair:
        panels[SEPARATION] = Panel(
            title="the two told apart",
            label="χ² of the wrong one",
            values=[design.separation or 0.0 for design in plan.designs],
            wanted=NEEDED,
            below=False,
            best=best,
            advised=plan.advised,
        )
    if not panels:
        raise InputError("the plan wants nothing that could be drawn", "Give wanted or separate to stepid.plan.")
    if axes is not None and set(panels) - set(axes):
        raise InputError(f"axes: lacks {', '.join(set(panels) - set(axes))}", "Give axes for each of these names.")
    groups = [f"every {design.sample_time * 1e3:.3g} ms" for design in plan.designs]
    return trade(panels, [design.runs for design in plan.designs], groups, axes=axes)
