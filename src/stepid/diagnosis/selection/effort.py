"""How hard the search tries: numbers that save time and, as a rule, change no answer."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from stepid.core.base import Model
from stepid.core.takes import number, taken

Count = Annotated[int, Field(ge=1)]
Share = Annotated[float, Field(gt=0, le=1)]
Positive = Annotated[float, Field(gt=0)]


class Effort(Model):
    """How hard the search tries; what decides an answer is in `stepid.Criteria`.

    Parameters
    ----------
    effects : int
        Most effects in one answer, four at most.
    fits : int
        Most proposals that are fitted before larger sets and rivals are tried.
    first : int
        Proposals on the linear plant that are fitted whatever they promise less than the best.
    width : int
        Proposals fitted in one round.
    share : int
        Of these, on one candidate.
    beam : int
        Candidates that are expanded in one round; the largest sets of which effects are exchanged.
    rounds : int
        Most rounds of proposals and fits, in exploring, in confirming and in dropping what is not needed.
    worth : float
        Share of the best gain that a proposal must promise (a linearized step tells it within a factor of some four).
    rival : float
        The same where an effect is at the noise floor already.
    hope : float
        Power of the share that a linearized step promises to leave, which may really be left.
    price : float
        Share of what is left that a further parameter counts as, in the order of the proposals.
    costly : float
        Times what a proposal on a general effect promises to leave: those are slow, simple ones go first.
    starts : int
        Starts of one effect that are tried.
    keep : int
        Starts that are run on.
    begin : int
        Iterations that a start, or a fit to all samples, is given at first.
    promote : int
        Iterations of the first promotion; each further one has twice as many, for half as many candidates.
    promoted : int
        Candidates that are promoted first.
    polish : int
        Candidates of each size that are fitted to all samples where a rest remains.
    polishing : int
        Iterations of a fit to all samples.
    spread : float
        Relative difference of cost within which candidates are fitted to all samples, as within `stuck` ties of χ² or a
        tie of QBIC.
    attenuated : float
        Share of an effect, or of the largest velocity, at which hardly any is there: a start from which there is a way
        downhill.
    stuck : float
        Times a tie, or the price of initial states, by which a fit may seem worse before it is taken as stuck.
    alike : float
        Share of a general law's force that one or two simple ones may leave to be tried in its place.
    enough : float
        Share of what a fit leaves that a further step need not promise.
    converged : float
        χ² that a further step need not promise.
    """

    effects: Annotated[int, Field(ge=1, le=4)] = 3
    fits: Count = 60
    first: Count = 12
    width: Count = 8
    share: Count = 3
    beam: Count = 3
    rounds: Count = 8
    worth: Share = 0.15
    rival: Share = 0.7
    hope: Positive = 8.0
    price: Positive = 0.25
    costly: Positive = 3.0
    starts: Count = 3
    keep: Count = 2
    begin: Count = 3
    promote: Count = 6
    promoted: Count = 4
    polish: Count = 2
    polishing: Count = 15
    spread: Share = 0.02
    attenuated: Share = 0.03
    stuck: Positive = 6.0
    alike: Share = 0.1
    enough: Share = 0.002
    converged: Positive = 0.2

    @classmethod
    def quick(cls) -> Effort:
        """Half of the default's fits, rounds and starts for a first look; its rounds are as wide, for all rivals."""
        plain, half = cls(), cls().scaled(0.5)
        return half.model_copy(update={name: getattr(plain, name) for name in ("width", "share", "beam")})

    @classmethod
    def thorough(cls) -> Effort:
        """Twice the default, and sets of four effects."""
        return cls(effects=4).scaled(2)

    def scaled(self, times: float) -> Effort:
        """Return an effort with `times` as many fits, rounds and candidates."""
        taken("Effort.scaled", "times", times, number("a number above 0", above=0.0))
        counts = ("fits", "first", "width", "share", "beam", "rounds", "starts", "keep", "promoted", "polish")
        return self.model_copy(update={name: max(1, round(times * getattr(self, name))) for name in counts})
