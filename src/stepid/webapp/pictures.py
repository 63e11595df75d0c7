"""Pictures of the page beside those of the report, as plotly's JSON; colors are named as there."""

from __future__ import annotations

from typing import Any

from stepid.core.base import Array
from stepid.core.experiment import Experiment
from stepid.core.quantities import Quantities, quantities_of
from stepid.identification.transfer.verification import Verification
from stepid.plot.panels import residual
from stepid.plot.scale import length_unit, reach_of
from stepid.report.axes import own_line, paired
from stepid.report.pictures import verification
from stepid.report.thin import kept_samples, listed

Drawn = dict[str, Any]


def record(run: Experiment, say: Quantities) -> Drawn:
    """Draw a record: position above, input below; `say` has the words of its axes."""
    time, position, volts = run.time, 1e3 * run.position, run.input
    kept = kept_samples(position, volts)
    figure = paired("V", 1.0)
    low, high = float(min(volts.min(), run.input_before)), float(max(volts.max(), run.input_before))
    edge = 0.1 * (high - low) or 1.0
    figure.update_layout(
        yaxis2={"range": [low - edge, high + edge], "title": {"text": "input [V]"}, "zeroline": False}, height=260
    )
    line = own_line("left", "position", "mm")
    figure.add_scatter(x=listed(time[kept]), y=listed(position[kept]), **line)
    shape = {"held": "hv"}.get(run.input_between, "linear")
    driven = own_line("before", "input", "V")
    driven["line"] = {"color": "var(--before)", "width": 1.5, "shape": shape}
    figure.add_scatter(x=listed(time[kept]), y=listed(volts[kept]), yaxis="y2", **driven)
    return _json(figure, say)


def verified(found: Verification) -> dict[str, Drawn]:
    """Draw the verification responses, by run, on one scale for what is left."""
    reach = reach_of(run.measured - run.simulated for run in found.runs)
    say = quantities_of(found)
    return {run.name: _json(verification(run, reach), say) for run in found.runs}


def played(run: Experiment, simulated: Array | None, *, reach: float, say: Quantities) -> Drawn:
    """Draw a record and a simulated response, what is left below on a scale that ends at ±`reach` [m]."""
    scale, what = length_unit(reach)
    kept = kept_samples(run.position) if simulated is None else kept_samples(run.position, simulated)
    figure = paired(what, scale * reach)
    time = listed(run.time[kept])
    figure.add_scatter(x=time, y=listed(1e3 * run.position[kept]), **own_line("measured", "measured", "mm"))
    if simulated is not None:
        left = residual(run.position, simulated, reach=reach)
        figure.add_scatter(x=time, y=listed(1e3 * simulated[kept]), **own_line("after", "simulated", "mm"))
        figure.add_scatter(x=time, y=listed(left.values[kept]), yaxis="y2", **own_line("left", "residual", left.unit))
    low, high = 1e3 * float(run.position.min()), 1e3 * float(run.position.max())
    room = 0.35 * (high - low) or 1.0  # the scale stays while knobs are turned
    figure.update_layout(yaxis={"range": [low - room, high + room]})
    return _json(figure, say)


def _json(figure: Any, say: Quantities) -> Drawn:
    drawn: Drawn = figure.to_plotly_json()
    return say.result({"data": list(drawn["data"]), "layout": drawn["layout"]})
