"""How far a diagnosis is."""

from __future__ import annotations


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
