"""How far a diagnosis is."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from stepid.core.bar import notebook_bar
from stepid.core.takes import WantedError, caller
from stepid.diagnosis.wording import effect_names, promised


class Progress(str):
    """A stage of a diagnosis: a few words, with the best answer so far.

    Parameters
    ----------
    words : str
        What is done next; `str` of it.
    best : tuple of str
        Effects of the best answer so far.
    done : int
        Proposals that are fitted; of several campaigns, those that are diagnosed or made.
    left : int
        Those that are not yet.
    promise : float
        Largest share of the misfit's power, as the best answer leaves it, that one of them promises to take.
    """

    best: tuple[str, ...]
    done: int
    left: int
    promise: float

    def __new__(
        cls, words: str, *, best: tuple[str, ...] = (), done: int = 0, left: int = 0, promise: float = 0.0
    ) -> Progress:
        """Make one."""
        out = super().__new__(cls, words)
        out.best, out.done, out.left, out.promise = best, done, left, promise
        return out


Tell = Callable[[Progress], object]


def listener(value: object) -> object:
    """Check an argument `progress`: a function of one argument, False for silence, None for a bar in notebooks."""
    if value is None or value is False:
        return value
    if value is True:
        raise WantedError("a function, or False; in a notebook there is a bar without it")
    return caller("a function that takes one argument, a stepid.Progress, or False")(value)


@contextmanager
def telling(progress: Tell | bool | None, *, line: Callable[[Progress], str] | None = None) -> Iterator[Tell]:
    """Give what each stage is told to: the caller's function, a bar in a notebook, or nothing.

    `line` writes a stage beside the bar, `stage_line` if not given.
    """
    if callable(progress):
        yield progress
    elif progress is None:
        with notebook_bar() as show:
            yield lambda stage: show((line or stage_line)(stage), stage.done, stage.left)
    else:
        yield lambda stage: None


def stage_words(stage: Progress) -> str:
    """Write what is done next: names of effects as people speak, sentences as they are."""
    return str(stage) if "." in stage else effect_names((stage,))


def stage_line(stage: Progress) -> str:
    """Write a stage on one line: what is tried, the best answer so far, what is left to try and what that promises."""
    parts = [stage_words(stage)]
    if stage.best or stage.left:
        parts.append(f"best so far: {effect_names(stage.best) or 'linear model'}")
    if stage.left:
        parts.append("; ".join(filter(None, (f"{stage.left} left to try", promised(stage.promise)))))
    return " | ".join(parts)
