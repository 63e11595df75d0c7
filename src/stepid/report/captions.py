"""The pictures of a report in words: titles, what they show, and what their lines mean."""

from __future__ import annotations

from stepid.core.latex import parameter_name
from stepid.core.words import digits, length
from stepid.diagnosis.result import Diagnosis
from stepid.diagnosis.wording import candidate_name
from stepid.identification.transfer.verification import Verification
from stepid.plot.ring_down import zoomed_ring_down
from stepid.report.chapter import Picture
from stepid.report.pull import linear_pull

_MEASURED = ("measured", "measured")
_NOISE = ("noise", "noise, ±2σ")


def records(d: Diagnosis) -> Picture:
    """All records in one picture."""
    return Picture(
        name="records",
        title="All records",
        alt=f"Measured position against time, one curve for each of {len(d.runs)} runs.",
        still="records",
    )


def verification(verified: Verification) -> Picture:
    """The peak method's models against the records."""
    said = "; ".join(f"{run.name} fit {run.fit_percent:.1f} %" for run in verified.runs)
    return Picture(
        name="verification",
        title="Measured and simulated, what is left below",
        alt=f"For each run the measured position, the identified model's, and their difference below. {said}.",
        still="verification",
        runs=tuple(run.name for run in verified.runs),
        beside=tuple(f"fit {run.fit_percent:.1f} %" for run in verified.runs),
        said=tuple(
            f"{run.name}: measured and identified model, fit {run.fit_percent:.1f} %, RMS left {length(run.rms)}."
            for run in verified.runs
        ),
        key=(_MEASURED, ("after", "identified model"), ("peak", "first peak")),
    )


def where(d: Diagnosis) -> tuple[Picture, ...]:
    """Where the linear joint fit disagrees."""
    phases = ", ".join(f"{name} {length(rms)}" for name, rms in d.where.phases.items())
    return (
        Picture(
            name="residuals",
            title="What the linear joint fit leaves, against time",
            alt="Measured minus linear joint fit against time, one curve a run, with the noise as a band.",
            still="where",
        ),
        Picture(name="phases", title="By phase of the response", alt=f"Bars of the RMS left: {phases}.", wide=False),
        Picture(
            name="velocity",
            title="As a force, against velocity",
            alt="Residual force against velocity; a step at zero velocity is Coulomb friction.",
            wide=False,
        ),
        Picture(
            name="position",
            title="As a force, against position",
            alt="Residual force against position from rest; a cubic curve is a cubic spring.",
            wide=False,
        ),
    )


def candidates(d: Diagnosis) -> Picture:
    """What each candidate leaves."""
    best = d.ranking[0]
    name = candidate_name(best.effects, best.deviations) if best.effects or best.deviations else "nothing added"
    return Picture(
        name="candidates",
        title="What each candidate leaves",
        alt=f"The RMS that each candidate leaves; the best is {name} with {length(best.rms)}, the noise "
        f"{length(d.gap.noise)}. All values are in the table.",
        still="candidates",
    )


def gap(d: Diagnosis) -> Picture:
    """The gap in numbers."""
    values = [f"linear model {length(d.gap.before)}"]
    if d.effects:
        values.append(f"with the effect {length(d.gap.after)}")
    if d.gap.held_out:
        before, after = map(length, d.gap.held_out)
        values.append(f"on runs held out {f'{before} and {after}' if d.effects else before}")
    values.append(f"noise {length(d.gap.noise)}")
    return Picture(name="gap", title="RMS gap and noise", alt=f"RMS: {'; '.join(values)}.", still="gap")


def ring_down(d: Diagnosis) -> tuple[Picture, ...]:
    """The ring-down of one run, zoomed; none where no run swings."""
    shown = zoomed_ring_down(d)
    if shown is None:
        return ()
    models = "the linear joint fit" + (" and the model with the effect" if d.effects else "")
    return (
        Picture(
            name="ring-down",
            title=f"The ring-down of {shown.run}, zoomed",
            alt=f"Position against time from {shown.time[0]:.3g} to {shown.time[-1]:.3g} s: measured, {models}.",
            still="ring-down",
        ),
    )


def gap_runs(d: Diagnosis) -> Picture:
    """Run by run, before and after."""
    said = "; ".join(f"{run.name} {length(run.before)} → {length(run.after)}" for run in d.runs)
    key = [_MEASURED, ("before", "linear joint fit")]
    if d.effects:
        key.append(("after", "with the effect"))
    return Picture(
        name="run",
        title="Run by run, residuals below" + (", those with the effect on a finer scale" if d.effects else ""),
        alt=f"For each run the measured position, the models', and what they leave. RMS: {said}.",
        still="runs",
        runs=tuple(run.name for run in d.runs),
        beside=tuple(length(run.before) + (f" → {length(run.after)}" if d.effects else "") for run in d.runs),
        said=tuple(
            f"{run.name}: measured and models; the linear one leaves {length(run.before)} RMS"
            + (f", with the effect {length(run.after)}." if d.effects else ".")
            for run in d.runs
        ),
        key=(*key, _NOISE),
    )


def pull(d: Diagnosis) -> Picture:
    """How far the missing effect pulled the linear fit's numbers."""
    said = [f"{parameter_name(name)} {_signed(off)} %" for name, off, _ in linear_pull(d)]
    return Picture(
        name="pull",
        title="How far the linear fit is off without the effect",
        alt=f"Linear joint fit against the final model, with 95 % intervals: {'; '.join(said) or 'none in common'}.",
        still="",
    )


def _signed(value: float) -> str:
    """Two decimals at most; what is nothing then has no sign."""
    size = digits(abs(value))
    return size if float(size) == 0 else f"{'+' if value > 0 else '−'}{size}"
