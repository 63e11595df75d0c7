"""The paper's whole route in one call: characteristics, stacked system, solve."""

from __future__ import annotations

import math
from collections.abc import Mapping

from stepid.core.arguments import as_campaign
from stepid.core.copies import copies
from stepid.core.experiment import Campaign, Experiment, MassOffset
from stepid.core.held_before import all_held_before
from stepid.core.quantities import in_own_quantities
from stepid.core.recorded import recorded
from stepid.core.samples import CLOSE, off_even_clock
from stepid.core.takes import takes
from stepid.core.units import check_speed
from stepid.core.words import counted
from stepid.errors import IdentificationError, UndeterminedError
from stepid.identification.characteristics import characterize_each
from stepid.identification.characteristics_model import Characteristics
from stepid.identification.parameters import IdentifiedParameters, ParameterUncertainty, StackedSystem
from stepid.identification.peak import InterpolatedPeak, Peak, a_peak
from stepid.identification.pooling import pool_steps
from stepid.identification.remainder import remainder, warning
from stepid.identification.slow_sensor import all_between_readings
from stepid.identification.solve import a_solver, solve
from stepid.identification.solvers import Solver, WeightedLeastSquares
from stepid.identification.stacked import assemble, undetermined_springs
from stepid.identification.tightness import tighter_by_fit

_VAGUE = 0.1  # relative uncertainty of the natural frequency beyond which a run says nothing
_LEAST_OVERSHOOT = 0.01  # below it the peak is so flat that the smallest departure from the model moves it far


@in_own_quantities
@takes(peak=a_peak, solver=a_solver)
@recorded(peak=InterpolatedPeak, solver=WeightedLeastSquares)
def identify(campaign: Campaign, *, peak: Peak | None = None, solver: Solver | None = None) -> IdentifiedParameters:
    """Identify masses, stiffnesses and damping constants of a campaign by the paper's method.

    Parameters
    ----------
    campaign : Campaign
        Steps and free releases may mix; runs may differ in spring, damper and base.
    peak : Peak, optional
        Default `InterpolatedPeak()`.
    solver : Solver, optional
        Default `WeightedLeastSquares()`. With `SampledPeak()` and `OrdinaryLeastSquares()` this is the paper's own
        procedure.

    Returns
    -------
    IdentifiedParameters
        One stiffness a spring label, damping pooled a damper label, one base mass a base label. Runs that the method
        cannot use are in `excluded`, each with the reason.

    Raises
    ------
    stepid.errors.UndeterminedError
        If the runs that are left do not fix the parameters; the message says what to add.
    stepid.errors.InputError
        If positions cannot be meters: they move faster than 100 m/s.

    Notes
    -----
    Each run counts with all its steps that can be read, pooled. Runs of one base are joined by their known mass
    differences; equal added masses are exact constraints.
    """
    return identify_with_system(campaign, peak=peak, solver=solver)[1]


@in_own_quantities
def identify_with_system(
    campaign: Campaign, *, peak: Peak | None = None, solver: Solver | None = None
) -> tuple[StackedSystem, IdentifiedParameters]:
    """Identify as `identify` does, and return the stacked system that was solved, too."""
    campaign = as_campaign(campaign)
    runs, slow = all_between_readings(campaign.experiments)
    runs, held = all_held_before(runs)
    if slow or held:
        campaign = campaign.model_copy(update={"experiments": tuple(runs)})
    used, excluded = characterize_campaign(campaign, peak=peak)
    while True:
        kept = [run for run in campaign.experiments if run.name in used]
        if len(kept) < 2:
            raise UndeterminedError(
                f"campaign {campaign.name!r} leaves {counted(len(kept), 'usable run')} of {len(campaign.experiments)}"
                f"{_left_out(excluded)}",
                "Two runs with the same spring and different known added masses are the least.",
            )
        system = assemble([used[run.name] for run in kept], _join(campaign, kept))
        loose = undetermined_springs(system)
        if not loose or len(loose) == len({run.spring for run in kept}):
            break
        for run in (run for run in kept if run.spring in loose):
            del used[run.name]
            excluded[run.name] = (
                f"no known mass difference fixes the stiffness of spring {run.spring!r}: "
                "add a run with this spring on a base of the others with another known added mass"
            )
    if loose and excluded:  # these may be all that is missing
        raise UndeterminedError(
            f"campaign {campaign.name!r}: no known difference in mass is left{_left_out(excluded)}",
            "Mend or record again what is left out, or add a run with another known added mass.",
        )
    found = solve(system, solver=solver)
    order = [run.name for run in campaign.experiments]
    left_out = dict(sorted(excluded.items(), key=lambda item: order.index(item[0])))
    said = _not_linear(campaign, used) or tighter_by_fit(kept, found, campaign.weight_uncertainty)
    notes = (*slow, *held, *found.notes, *(note for note in (said, _turned(used)) if note is not None))
    uncertainty = _scaled(found, campaign.scale_uncertainty)
    fields = found.model_dump() | {"uncertainty": uncertainty, "excluded": left_out, "notes": notes}
    return system, IdentifiedParameters(**fields)


@in_own_quantities
def characterize_campaign(
    campaign: Campaign, *, peak: Peak | None = None
) -> tuple[dict[str, Characteristics], dict[str, str]]:
    """Read the characteristics of every run, and say which runs yield none and why.

    Parameters
    ----------
    campaign : Campaign
    peak : Peak, optional

    Returns
    -------
    tuple
        Run name to `Characteristics`, and run name to the reason why there are none.

    Raises
    ------
    stepid.errors.InputError
        If positions cannot be meters.
    """
    campaign = as_campaign(campaign)
    used: dict[str, Characteristics] = {}
    excluded: dict[str, str] = {}
    for experiment in campaign.experiments:
        check_speed(experiment.position, experiment.sample_time, f"run {experiment.name!r}: its positions")
        if off_even_clock(experiment.time).max() > CLOSE:
            excluded[experiment.name] = "its samples are uneven in time, which only fit and diagnose can take"
            continue
        try:
            used[experiment.name] = _readable(experiment, peak)
        except IdentificationError as error:
            excluded[experiment.name] = error.cause.removeprefix(f"run {experiment.name!r}: ")
    for name, why in copies(run for run in campaign.experiments if run.name in used).items():
        del used[name]
        excluded[name] = why
    return used, excluded


def _readable(experiment: Experiment, peak: Peak | None) -> Characteristics:
    """Pool the steps of a run that can be read, and note those that cannot."""
    results = characterize_each(experiment, peak=peak)
    good = [result for result in results if isinstance(result, Characteristics)]
    errors = [result for result in results if isinstance(result, IdentificationError)]
    if not good:
        raise errors[0]
    found = pool_steps(good, name=experiment.name)
    if found.overshoot is not None and found.overshoot < _LEAST_OVERSHOOT:
        raise IdentificationError(
            f"run {experiment.name!r}: too little overshoot ({100 * found.overshoot:.2g} %), "
            "its peak is too flat to tell the frequency"
        )
    vague = found.uncertainty.natural_frequency / found.natural_frequency
    if vague > _VAGUE:
        raise IdentificationError(
            f"run {experiment.name!r}: noise leaves the natural frequency uncertain by {100 * vague:.0f} %"
        )
    if not errors:
        return found
    notes = (*found.notes, *(f"a step is left out: {error.cause}" for error in errors))
    return Characteristics(**found.model_dump() | {"uncertainty": found.uncertainty, "notes": notes})


def _left_out(excluded: Mapping[str, str]) -> str:
    """Which runs are left out and why, as the end of a sentence."""
    return "".join(f"; {name} is left out: {why}" for name, why in excluded.items())


def _scaled(found: IdentifiedParameters, scale: float) -> ParameterUncertainty:
    """Uncertainties with that of the scale of all positions, relative: only the static gains depend on it."""
    known = found.uncertainty
    gains = {n: math.hypot(u, scale * abs(found.static_gain[n])) for n, u in known.static_gain.items()}
    return ParameterUncertainty(**known.model_dump() | {"static_gain": gains})


def _not_linear(campaign: Campaign, used: dict[str, Characteristics]) -> str | None:
    """Say that the runs are not those of a linear plant, where they are not."""
    return warning(
        remainder(campaign[name], damped_frequency=found.damped_frequency, damping_ratio=found.damping_ratio)
        for name, found in used.items()
    )


def _turned(used: dict[str, Characteristics]) -> str | None:
    """Say which runs answer a step in another direction than most, where some do."""
    gains = {name: found.static_gain for name, found in used.items() if found.static_gain is not None}
    sides = sorted(([name for name, gain in gains.items() if (gain > 0) is way] for way in (True, False)), key=len)
    if not sides[0]:
        return None
    few = ", ".join(map(repr, sides[0]))
    return f"{few}: the static gain has another sign than in the other runs. Is a position or an input turned?"


def _join(campaign: Campaign, kept: list[Experiment]) -> tuple[MassOffset, ...]:
    return campaign.model_copy(update={"experiments": tuple(kept)}).mass_offsets
