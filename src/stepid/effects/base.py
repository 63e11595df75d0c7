"""What an effect is: one small class that says what it adds to the linear plant."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import ClassVar, NamedTuple

import numpy as np

from stepid.core.base import Array

GRAVITY = 9.81  # m/s²

Values = tuple[Array, ...]
"""Parameter values of one effect, in the order of `Effect.parameters`, each broadcastable over the lanes."""


class Parameter(NamedTuple):
    """One parameter of an effect.

    Parameters
    ----------
    name : str
    unit : str
        SI, empty for a pure number.
    lower, upper : float
        Bounds, in `unit`.
    """

    name: str
    unit: str
    lower: float = 0.0
    upper: float = np.inf


class Motion(NamedTuple):
    """The state of many plants at once ("lanes"), as an effect sees it; every array has shape (lanes,).

    Parameters
    ----------
    x : array
        m, from the spring's rest position.
    v : array
        m/s.
    sign : array
        Direction of motion, ±1, held through a stretch without reversal.
    time : array
        s, from the record's first sample.
    mass, stiffness, damping : array
        kg, N/m, N·s/m.
    volts : array
        V, the input held through the step.
    sides : tuple of array
        Signs of the effect's own `switches`.
    extra : tuple of array
        The effect's own states.
    memory : tuple of array
        The effect's own states that follow the displacement, not time.
    """

    x: Array
    v: Array
    sign: Array
    time: Array
    mass: Array
    stiffness: Array
    damping: Array
    volts: Array
    sides: tuple[Array, ...] = ()
    extra: tuple[Array, ...] = ()
    memory: tuple[Array, ...] = ()


class Scales(NamedTuple):
    """Typical magnitudes of a campaign, for start guesses.

    Parameters
    ----------
    displacement : float
        m, largest excursion from rest.
    velocity : float
        m/s, largest.
    force : float
        N, largest spring force.
    mass, stiffness, damping : float
        kg, N/m, N·s/m: means over the labels.
    volts, volts_least : float
        V, largest and smallest nonzero input.
    sample_time, duration : float
        s, mean sample time and longest record.
    floor : float
        m, noise floor.
    low, high : float
        m, lowest and highest position from rest.
    resonances : tuple of float
        Hz, peaks of the residual's spectrum, strongest first.
    """

    displacement: float
    velocity: float
    force: float
    mass: float
    stiffness: float
    damping: float
    volts: float
    volts_least: float
    sample_time: float
    duration: float
    floor: float
    low: float
    high: float
    resonances: tuple[float, ...] = ()


class Regressor(NamedTuple):
    """Forces whose sum, with coefficients to be found, is the effect at one choice of its shape parameters.

    `forces` are arrays of shape (samples,); `values` turns their coefficients into the effect's parameter values, or
    None where the coefficients are not the effect's.
    """

    forces: tuple[Array, ...]
    values: Callable[[Array], tuple[float, ...] | None]


class Effect:
    """Base of every effect. Subclasses set the class attributes and override what they change; all else stays linear.

    All methods work on lanes: arrays of one shape, one entry per plant and moment. The parameter values `p` come as a
    tuple in the order of `parameters`.
    """

    name: ClassVar[str]
    parameters: ClassVar[tuple[Parameter, ...]]
    law: ClassVar[str] = ""  # the added force in one formula
    formula: ClassVar[str] = ""  # the same in LaTeX
    symbols: ClassVar[tuple[str, ...]] = ()  # of the parameters (those of each run last) in the formula, LaTeX
    seen: ClassVar[str] = ""  # what it looks like in a lab
    advice: ClassVar[str] = ""  # what to do about it

    linear: ClassVar[bool] = False  # the plant stays linear: solved exactly
    affine: ClassVar[bool] = False  # linear with constant forces between its events: solved exactly between them
    dry: ClassVar[bool] = False  # holds the cart at rest within its breakaway force
    reverses: ClassVar[bool] = False  # its law changes where the velocity changes sign
    rests_anywhere: ClassVar[bool] = False  # the cart may start off the spring's rest position
    never_rests: ClassVar[bool] = False  # the cart may be in motion at the start of any record
    repeats: ClassVar[bool] = False  # a sine of the position: its parameters are amplitude, pitch [m] and phase
    n_switches: ClassVar[int] = 0  # positions or states where its law changes
    n_extra: ClassVar[int] = 0  # own states with a rate in time
    n_memory: ClassVar[int] = 0  # own states that follow the displacement, not time
    settled: ClassVar[bool] = False  # own states are known even where a record starts in motion
    run_parameters: ClassVar[tuple[Parameter, ...]] = ()  # refitted for every run, appended to the values
    contains: ClassVar[tuple[str, ...]] = ()  # simpler effects that this one reduces to

    def starts(self, scales: Scales) -> Sequence[tuple[float, ...]]:
        """Start guesses for the parameters (run parameters excluded), each a tuple in the order of `parameters`."""
        raise NotImplementedError

    def faint(self, values: tuple[float, ...], share: float) -> tuple[float, ...]:
        """Parameter values at which the effect is as good as absent: the first parameter, its strength, scaled."""
        return (share * values[0], *values[1:])

    def grow(self, inner: tuple[float, ...], scales: Scales) -> Sequence[tuple[float, ...]]:
        """Start guesses from the optimum of a simpler effect that this one `contains`."""
        return ()

    def regressors(self, scales: Scales, m: Motion) -> Sequence[Regressor]:
        """Forces on the measured motion that would be this effect, for starts by linear least squares (optional)."""
        return ()

    def force(self, p: Values, m: Motion) -> Array | float:
        """Force added to the plant, N, friction that holds at rest excepted."""
        return 0.0

    def friction(self, p: Values, m: Motion) -> Array | float:
        """Magnitude of dry friction while sliding in direction `m.sign`, N."""
        return 0.0

    def breakaway(self, p: Values, m: Motion) -> Array | float:
        """Largest force that friction holds at rest against a push in direction `m.sign`, N."""
        return self.friction(p, m)

    def switches(self, p: Values, m: Motion) -> tuple[Array, ...]:
        """Functions of the state whose sign changes mark a change of law."""
        return ()

    def rates(self, p: Values, m: Motion) -> tuple[Array, ...]:
        """Rates of the effect's own states `m.extra`, per second."""
        return ()

    def at_rest(self, p: Values, x: Array, volts: Array) -> tuple[Array, ...]:
        """Own states (extra, then memory) of a plant that has long rested at `x` under `volts`."""
        return tuple(np.zeros_like(x) for _ in range(self.n_extra + self.n_memory))

    def remember(self, p: Values, memory: tuple[Array, ...], shift: Array, sign: Array) -> tuple[Array, ...]:
        """Own memory after the cart has moved by `shift` [m] in direction `sign` from where it was `memory`."""
        return memory

    def memory_slopes(self, p: Values, m: Motion) -> tuple[Array, ...]:
        """Change of the own memory per meter of travel, for solvers that know rates only (optional)."""
        return tuple(np.zeros_like(m.x) for _ in range(self.n_memory))

    def drive(self, p: Values, m: Motion) -> Array:
        """Voltage that reaches the motor, V (the measured one unless the effect changes it)."""
        return m.volts

    def delay(self, p: Values) -> Array | float:
        """Time by which the input comes late, s."""
        return 0.0

    def reading(self, p: Values, time: Array) -> Array | float:
        """Reading added to the true position, m."""
        return 0.0

    def relax(self, p: Values, m: Motion, time: Array, length: Array | None = None) -> tuple[Array, ...]:
        """Own states after `time` [s] in closed form, for effects whose states follow the held input alone.

        Within a piece of `length`, their mean over it where they settle much faster.
        """
        raise NotImplementedError

    def pieces(self, p: Values, m: Motion, acceleration: Array, length: Array) -> Array | float:
        """Substeps that a time step of `length` [s] needs to follow this effect's law."""
        return 1.0

    def __repr__(self) -> str:
        return f"<effect {self.name}: {', '.join(q.name for q in self.parameters)}>"
