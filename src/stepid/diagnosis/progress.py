"""How far a diagnosis is."""

from __future__ import annotations

from stepid.diagnosis.wording import effect_names

_WORTH = 0.01  # share of the rest, below which a promise is not told


class Progress(str):
    """A stage of a diagnosis: a few words, with the best answer so far.

    Parameters
    ----------
    words : str
        What is done next; `str` of it.
    best : tuple of str
        Effects of the best answer so far.
    left : int
        Proposals that are not fitted yet.
    promise : float
        Largest share of the misfit's power, as the best answer leaves it, that one of them promises to take.
    """

    best: tuple[str, ...]
    left: int
    promise: float

    def __new__(cls, words: str, *, best: tuple[str, ...] = (), left: int = 0, promise: float = 0.0) -> Progress:
        """Make one."""
        out = super().__new__(cls, words)
        out.best, out.left, out.promise = best, left, promise
        return out


def stage_line(stage: Progress) -> str:
    """Write a stage on one line: what is tried, the best answer so far, what is left to try and what that promises."""
    parts = [effect_names((stage,))]
    if stage.best or stage.left:
        parts.append(f"best so far: {effect_names(stage.best) or 'linear model'}")
    if stage.left:
        promise = f", may take {100 * stage.promise:.0f} % of the rest" if stage.promise >= _WORTH else ""
        parts.append(f"{stage.left} left to try{promise}")
    return " | ".join(parts)
