"""How the plants of a campaign swing: by this effects say what they cannot be told from."""

from __future__ import annotations

import math
from typing import NamedTuple

OWN = "the plant's own oscillation"
_OVERTONE = f"an overtone of {OWN}"
_MULTIPLES = (2, 3)  # of its rate: higher ones of a smooth law are faint


class Swing(NamedTuple):
    """How a campaign's plants swing, for `Effect.imitates`.

    Parameters
    ----------
    rates, decays : tuple of float
        rad/s and 1/s, natural frequency of each run, and how fast what swings with it decays.
    masses : tuple of float
        kg, of each run.
    displacement : float
        m, largest excursion from rest.
    duration : float
        s, longest record.
    resolution : float
        Relative difference of two rates that the records tell apart.
    pitch : float
        Largest pitch of a force periodic in position, over `displacement`, that does not just bend the spring.
    fast, slow : float
        Relaxation times over 1/rate that are neither damping nor a shift of rest.
    swings : float
        Least number of periods, or of beats, in the longest record.
    """

    rates: tuple[float, ...]
    decays: tuple[float, ...]
    masses: tuple[float, ...]
    displacement: float
    duration: float
    resolution: float
    pitch: float
    fast: float
    slow: float
    swings: float

    def near(self, rate: float) -> bool:
        """Tell whether a rate [rad/s] cannot be told from that of a run."""
        return any(abs(rate - own) < self.resolution * own for own in self.rates)

    def splits(self, mass: float, stiffness: float) -> bool:
        """Tell whether a second mass [kg] on a spring [N/m] gives every run two rates that the records tell apart.

        Alone it may swing at the rate of a run: two equal masses on equal springs have rates of 0.62 and 1.62 of that.
        """
        alone = math.sqrt(stiffness / mass)

        def apart(rate: float, of: float) -> float:  # by the trace and the determinant of both masses' matrix
            return math.sqrt(max(rate**2 + alone**2 * (1.0 + mass / of) - 2.0 * rate * alone, 0.0))

        return all(apart(*own) >= self.resolution * own[0] for own in zip(self.rates, self.masses, strict=True))

    def unseen(self, frequency: float) -> str:
        """Say what a frequency [Hz] of too few periods in the longest record cannot be told from, or nothing."""
        return "a slow shift of the rest position" if frequency * self.duration < self.swings else ""

    def unbeaten(self, frequency: float) -> str:
        """Say that a steady frequency [Hz] beats too few times with the own oscillation of every run, while that lasts.

        What differs by less within the longest record, in rate and decay, is any slow change of that oscillation.
        """
        rate, least = math.tau * frequency, math.tau * self.swings / self.duration
        own = zip(self.rates, self.decays, strict=True)
        return OWN if all(math.hypot(rate - swing, decay) < least for swing, decay in own) else ""

    def overtone(self, frequency: float) -> str:
        """Say that a steady frequency [Hz] is an overtone of runs that swing as steadily, or nothing.

        It keeps in step with the own oscillation of every run to a quarter of a period in the longest record, in which
        that does not decay: then a spring or a damping that bends makes it, and no shaker.
        """

        def in_step(rate: float, decay: float, times: int) -> bool:
            late = abs(math.tau * frequency - times * rate) * self.duration
            return late < math.pi / 2 and times * decay * self.duration < 1.0

        own = list(zip(self.rates, self.decays, strict=True))
        return _OVERTONE if any(all(in_step(*one, times) for one in own) for times in _MULTIPLES) else ""
