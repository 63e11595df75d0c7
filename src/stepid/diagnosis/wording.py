"""What was found, in plain words."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence

from stepid.core.latex import parameter_name
from stepid.core.words import capitalized, length, listed
from stepid.diagnosis.residual_force import CLEAR, Shape

_CLEAR_TREND = 0.7  # correlation
_DIFFER = 1.5  # ratio of two RMS values that differ
_WORTH = 0.01  # share of the misfit, below which a promise is not told
_NEARLY = 0.95  # share, from which it is nearly all


def whole_percent(share: float) -> str:
    """Write a share in whole per cent: ``"97 %"``."""
    return f"{100 * share:.0f} %"


def taken_in_words(names: Sequence[str], share: float) -> str:
    """Say what effects take of the misfit on runs left out, never more than they do: the per cent are rounded down."""
    said = effect_names(names)
    takes = "takes" if len(names) == 1 else "take"
    percent = math.floor(100 * share + 1e-9)
    return f"{capitalized(said)} {takes} {percent} % of the misfit's power on runs that the fit did not see"


def effect_names(names: Iterable[str]) -> str:
    """Write canonical names as people speak: ``"Coulomb friction and input delay"``."""
    return " and ".join(map(parameter_name, names))


_DIFFER_WORDS = {
    "start_time": "start times differ",
    "gain": "gains differ",
    "damping": "damping differs",
    "friction": "friction differs",
    "start_offset": "start offsets differ",
    "start_velocity": "start velocities differ",
}


def candidate_name(effects: Sequence[str], deviations: Sequence[str] = ()) -> str:
    """Write a candidate as people speak: ``"Coulomb friction, start times differ"``; the plain plant is linear."""
    first = effect_names(effects) or ("linear" if deviations else "nothing (linear)")
    return ", ".join([first, *(_DIFFER_WORDS.get(kind, f"{kind} differs") for kind in deviations)])


def per_cent(share: float) -> str:
    """Write a share in per cent, with more digits near 0 and 100: ``"99.95 %"``, ``"12 %"``, ``"0.2 %"``."""
    value = 100.0 * share
    if value <= -0.5:
        return f"−{-value:.0f} %"
    if share >= 1.0:
        return "100 %"
    if value >= 99.995:
        return "> 99.99 %"
    if value >= 99.0:
        return f"{value:.2f} %"
    if value >= 90.0:
        return f"{value:.1f} %"
    if value >= 0.95:
        return f"{value:.2g} %"
    return f"{value:.1g} %" if value >= 0.05 else "0 %"


def promised(share: float) -> str:
    """Write what the most promising of some proposals may explain of the misfit left: empty below one per cent."""
    if share < _WORTH:
        return ""
    part = "nearly all" if share >= _NEARLY else whole_percent(share)
    return f"the most promising may explain {part} of the remaining misfit"


def parameter_words(name: str) -> str:
    """Write a parameter's name within a sentence: ``"the level of Coulomb friction"``, ``"stiffness (medium)"``."""
    effect, dot, parameter = name.partition(".")
    said = parameter_name(name)
    own = dot and "[" not in effect and "," in said  # a label may have a dot, too
    return f"the {parameter_name(parameter)} of {effect_names((effect,))}" if own else said


def chance(probability: float) -> str:
    """Write a probability in whole per cent, never as certainty: ``"98 %"``, ``"<1 %"``, ``">99 %"``."""
    value = 100.0 * probability
    if value < 1.0:
        return "<1 %"
    return ">99 %" if value > 99.0 else f"{value:.0f} %"


def sentences(
    rms: float,
    floor: float,
    phases: Mapping[str, float],
    runs: Mapping[str, float],
    trends: Mapping[str, float],
    shape: Shape | None,
    *,
    driven: bool = True,
    enough: bool = False,
    otherwise: str = "",
) -> tuple[str, ...]:
    """Say where a linear fit disagrees.

    Parameters
    ----------
    rms, floor : float
        m, over all samples.
    phases, runs : mapping
        To RMS, m.
    trends : mapping
        Correlations from `stepid.diagnosis.locate.run_trends`.
    shape : Shape or None
        What the residual force follows.
    driven : bool
        Whether any run has an input.
    enough : bool
        Whether the linear plant is the answer.
    otherwise : str
        What shape the residual has where its force shows none.
    """
    if enough:
        return (f"nowhere: the linear model leaves {length(rms)} RMS, the noise alone {length(floor)}",)
    said = [_about_phases(phases, floor)]
    if len(runs) > 1:
        said.append(_about_runs(runs))
    if max(runs.values()) >= _DIFFER * min(runs.values()):
        said += [_about_trend(name, value, driven) for name, value in trends.items() if abs(value) >= _CLEAR_TREND]
    said.append(_about_force(shape, driven, otherwise))
    return tuple(said)


def _about_phases(phases: Mapping[str, float], floor: float) -> str:
    order = sorted(phases, key=lambda name: -phases[name])
    first = f"largest {_during(order[0])} ({length(phases[order[0]])} RMS)"
    clean = [name for name in order[1:] if phases[name] <= _DIFFER * floor]
    if clean and phases[order[0]] <= _DIFFER * floor:
        return f"{first}, little above the noise in every phase"
    if clean:
        return f"{first}; at the noise {listed([_during(name) for name in clean], 'and')}"
    if len(order) > 1:
        return f"{first}, smallest {_during(order[-1])} ({length(phases[order[-1]])})"
    return first


def _during(phase: str) -> str:
    return {"before": "before the first step", "rest": "at rest", "driven": "while driven"}.get(
        phase, f"in the {phase}"
    )


def _about_runs(runs: Mapping[str, float]) -> str:
    worst, best = max(runs, key=lambda n: runs[n]), min(runs, key=lambda n: runs[n])
    if runs[worst] < _DIFFER * runs[best]:
        return "of similar size in every run"
    return f"most in run {worst!r} ({length(runs[worst])}), least in run {best!r} ({length(runs[best])})"


def _about_trend(name: str, value: float, driven: bool) -> str:
    if name == "direction":
        which = ("that go down", "that go up") if driven else ("that start below rest", "that start above rest")
        return f"larger in runs {which[value > 0]} (correlation {abs(value):.2f})"
    size = "the size of the step" if driven else "how far from rest a run starts"
    what = {"mass": "mass", "size": size}.get(name, name)
    return f"{'grows' if value > 0 else 'falls'} with {what} (correlation {value:+.2f})"


def _about_force(shape: Shape | None, driven: bool, otherwise: str) -> str:
    if shape is None:
        return "too little motion to see a force in the residual"
    if shape.share < CLEAR and otherwise:
        return f"the residual force has no clear shape, but {otherwise}"
    if shape.share < CLEAR:
        where = "the drive, the reading or time" if driven else "the reading or time"
        return f"the residual force follows neither velocity nor position clearly: look at {where}, too"
    share = f"{whole_percent(shape.share)} of the force that no spring or damper gives"
    if shape.name == "sign of velocity":
        size = abs(shape.coefficient)
        like = f", like friction of {size:.2g} N either way" if shape.coefficient < 0 else ""
        return f"the residual force jumps by {2 * size:.2g} N where the velocity changes sign{like} ({share})"
    if shape.name == "velocity squared":
        way = "against" if shape.coefficient < 0 else "with"
        return f"the residual force grows with the square of the velocity, {way} the motion ({share})"
    if shape.name == "position squared":
        return f"the residual force is lopsided about rest, a square of the position ({share})"
    way = "stiffer" if shape.coefficient < 0 else "softer"
    return f"the residual force bends as a cube of the position: {way} away from rest ({share})"
