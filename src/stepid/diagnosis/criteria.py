"""The numbers that decide an answer, each with its unit, its reason and where it comes from."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from stepid.core.base import Model

Share = Annotated[float, Field(gt=0, le=1)]
Times = Annotated[float, Field(ge=1)]
Positive = Annotated[float, Field(gt=0)]


class Criteria(Model):
    """What decides an answer; what only saves time is in `stepid.Effort`.

    Parameters
    ----------
    tie : float
        Difference of QBIC below which two candidates are not told apart. "Very strong" evidence (Kass and Raftery
        1995, J. Am. Stat. Assoc. 90, 773).
    further : float
        Decrease of QBIC that a further effect, or a further condition that differs from run to run, must bring: the
        catalogue offers some twenty, of which the best by chance gains more than one alone (2 ln 23 = 6 above `tie`).
    white : float
        Standard deviations of block-mean χ², of the von Neumann ratio and of what a law of any shape takes of colored
        noise or beside runs that differ, that white noise may show; 1 in 3,000,000 for a normal deviate at 5.
    floor : float
        Times the noise floor that a complete model may leave: the floor is estimated from a few hundred differences
        to some 3 per cent.
    near : float
        Times the floor within which a model is complete although a faint rest remains; white noise may leave more
        by what chance makes of the floor.
    faint : float
        Times the floor that the linear plant must leave for a name; beside colored noise `near` holds.
    rival : float
        χ² that the freedom of a more general effect must gain to count as a rival of the simpler one: two standard
        deviations, squared, and one for the choice. A difference below `tie` is enough where the linear plant leaves
        less than twice the floor.
    open : float
        Standard uncertainty over value, from where its range begins, above which a parameter is not determined: at ½,
        zero is within two of them. A strength is determined, too, where its 95 % limit toward none is within two such
        shares of it.
    lead : float
        Share of the misfit's repeatable power that an effect must take on runs left out to be named where a rest
        remains: the rest is then two fifths of the misfit, or less, in amplitude. A second effect must halve what may
        be left. At 0.75 half of the further names were wrong.
    rough : float
        Share of the misfit's power, or of what conditions that differ leave of it, that a law of another shape may take
        from what a lead leaves: real laws are that rough (0.1 to 0.3 per cent in recordings of real springs, hulls and
        pendulums). Laws of one state that differ by less are not told apart beside a rest.
    sure : float
        Weight (sum of Akaike-like weights exp(−ΔQBIC/2)) that the candidates which hold an effect must have (Burnham
        and Anderson 2002, section 4.3).
    steady : float
        Least ratio of the smallest to the largest share that an answer takes in single runs left out: a size that is
        not the same in every run is no property of the plant.
    first : float
        Part of a run left out on which its own freedoms are estimated; the rest judges (evidence of 58 campaigns).
    resolution : float
        Least difference of two rates, over the plant's natural frequency, that are told apart in a short record.
    pitch : float
        Largest pitch of a force periodic in position, over the largest displacement: two periods on a side of rest show
        that it repeats, longer ones bend the spring.
    slow : float
        Longest relaxation time, in 1/ω₀, that is not a shift of the rest position.
    fast : float
        Shortest relaxation time, in 1/ω₀, that is not damping.
    swings : float
        Least number of periods of a disturbance or a second mass, or of beats with the own swing, in the longest
        record.
    shape : float
        Standard deviations beyond chance that a law of any shape may take of what is left in white noise where no runs
        differ, that the law which takes most of a rest may take beside another, and that what runs differ by may go
        with a condition: 1 in 4,300 for a normal deviate at 3.5, and there are a dozen of either.
    size : float
        Standard deviations (of the other runs' scatter and of its own uncertainty) beyond which a run is accused.
    """

    tie: Positive = 10.0
    further: Positive = 16.0
    white: Positive = 5.0
    floor: Times = 1.05
    near: Times = 1.15
    faint: Times = 1.05
    rival: Positive = 5.0
    open: Share = 0.5
    lead: Share = 0.85
    rough: Share = 0.003
    sure: Share = 0.95
    steady: Share = 0.4
    first: Share = 0.4
    resolution: Share = 0.05
    pitch: Positive = 0.5
    slow: Positive = 20.0
    fast: Positive = 0.05
    swings: Positive = 1.0
    shape: Positive = 3.5
    size: Positive = 5.0
