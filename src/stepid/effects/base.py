"""What an effect is: one small class that says what it adds to the linear plant."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import ClassVar, NamedTuple

import numpy as np

from stepid.core.base import Array
from stepid.effects.swing import Swing

Values = tuple[float, ...]  # of one effect's parameters, in the order of `Effect.parameters`, those of a run last


class Parameter(NamedTuple):
    """One parameter of an effect.

    Parameters
    ----------
    name : str
    unit : str
        SI, empty for a pure number.
    lower, upper : float
        Bounds, in `unit`; a lower one is that of a lab's rig, and goes with masses, travel and sample time of others.
    length : float, optional
        Power of a length that it is measured by, where its unit does not tell: a share of the weight's force is
        measured by one.
    """

    name: str
    unit: str
    lower: float = 0.0
    upper: float = np.inf
    length: float | None = None

    @property
    def force(self) -> bool:
        """Whether it is a force, or a share of the weight's."""
        return self.unit == "N" or (self.unit == "" and self.length == 1)

    @property
    def angle(self) -> bool:
        """Whether it is an angle, of which zero is as good a value as any."""
        return self.unit == "rad"


class Moment(NamedTuple):
    """One plant at one moment, as the law of an effect sees it.

    Parameters
    ----------
    x : float
        m, from the spring's rest position.
    v : float
        m/s.
    sign : float
        Direction of motion, ±1, held until the cart reverses.
    time : float
        s, from the record's first sample.
    mass, stiffness, damping : float
        kg, N/m, N·s/m.
    volts : float
        V, the input; for an effect of the drive, what the effects before it in `Effect.drive_order` hand on.
    sides : tuple of float
        Signs of the effect's own `switches`.
    extra : tuple of float
        The effect's own states.
    memory : tuple of float
        The effect's own states that follow the displacement, not time.
    slope, bend, jerk : float
        V/s, V/s², V/s³: derivatives of `volts` in time.
    """

    x: float
    v: float
    sign: float
    time: float
    mass: float
    stiffness: float
    damping: float
    volts: float
    sides: tuple[float, ...] = ()
    extra: tuple[float, ...] = ()
    memory: tuple[float, ...] = ()
    slope: float = 0.0
    bend: float = 0.0
    jerk: float = 0.0


class Motion(NamedTuple):
    """A measured motion, as `Effect.regressors` sees it: fields of `Moment`, sample by sample.

    Parameters
    ----------
    x, v, sign : array, shape (S,)
        m from the spring's rest position, m/s, ±1.
    time : array, shape (S,)
        s, from each record's first sample.
    mass, stiffness, damping : array, shape (S,)
        kg, N/m, N·s/m.
    volts : array, shape (S,)
        V, the input.
    """

    x: Array
    v: Array
    sign: Array
    time: Array
    mass: Array
    stiffness: Array
    damping: Array
    volts: Array


class Scales(NamedTuple):
    """Typical magnitudes of a campaign, for start guesses.

    Parameters
    ----------
    displacement, velocity, force : float
        m, m/s and N, largest from rest; the force is the spring's.
    mass, stiffness, damping : float
        kg, N/m, N·s/m: means over the labels.
    volts, volts_least : float
        V, largest and smallest nonzero input.
    sample_time, duration : float
        s, mean sample time and longest record.
    floor, low, high : float
        m: noise floor, lowest and highest position from rest.
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

    Its laws are static methods on plain numbers, one plant at one moment: stepid compiles them for its simulation. The
    parameter values `p` come as a tuple in the order of `parameters`, those of a run last.
    """

    name: ClassVar[str]
    parameters: ClassVar[tuple[Parameter, ...]]
    law: ClassVar[str] = ""  # the added force in one formula
    formula: ClassVar[str] = ""  # the same in LaTeX
    symbols: ClassVar[tuple[str, ...]] = ()  # of the parameters (those of each run last) in the formula, LaTeX
    seen: ClassVar[str] = ""  # what it looks like in a lab
    advice: ClassVar[str] = ""  # what to do about it

    linear: ClassVar[bool] = False  # the plant stays linear: solved exactly
    affine: ClassVar[bool] = False  # linear with constant forces between its events: exact steps, where no slope turns
    dry: ClassVar[bool] = False  # holds the cart at rest within its breakaway force
    reverses: ClassVar[bool] = False  # its law changes where the velocity changes sign
    rests_anywhere: ClassVar[bool] = False  # the cart may start off the spring's rest position
    never_rests: ClassVar[bool] = False  # the cart may be in motion at the start of any record
    drive_order: ClassVar[int] = 2  # place from command to force: delay 0, dead zone, saturation, rate, lag 4
    repeats: ClassVar[bool] = False  # a sine of the position (amplitude, pitch [m], phase); `regressors` scan the pitch
    n_switches: ClassVar[int] = 0  # positions or states where its law changes
    n_extra: ClassVar[int] = 0  # own states with a rate in time
    n_memory: ClassVar[int] = 0  # own states that follow the displacement, not time
    settled: ClassVar[bool] = False  # own states are known even where a record starts in motion
    own_units: ClassVar[tuple[str, ...] | None] = None  # of its own states; then units tell how its laws scale
    run_parameters: ClassVar[tuple[Parameter, ...]] = ()  # refitted for every run, appended to the values
    power: ClassVar[tuple[int, int] | None] = None  # places of a coefficient and of the speed's exponent it belongs to
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

    def imitates(self, values: tuple[float, ...], swing: Swing) -> str:
        """Say which linear parameter the effect can stand in for at these values, or nothing."""
        return ""

    def unseen(self, values: tuple[float, ...], swing: Swing) -> str:
        """Say what the effect cannot be told from in records too short to show it, however well it fits, or nothing."""
        return ""

    def remark(self, values: tuple[float, ...]) -> str:
        """Say what one sees or hears of the effect at these values, where its parameters do not, in a sentence."""
        return ""

    def regressors(self, scales: Scales, m: Motion) -> Sequence[Regressor]:
        """Forces on the measured motion that would be this effect, for starts by linear least squares (optional)."""
        return ()

    def overtones(self, values: tuple[float, ...], m: Motion) -> Sequence[Array]:
        """Forces that a law of the same period and of another shape holds beside it; `values` with those of a run."""
        return ()

    @staticmethod
    def force(p: Values, m: Moment) -> float:
        """Force added to the plant, N, dry friction excepted."""
        return 0.0

    @staticmethod
    def friction(p: Values, m: Moment) -> float:
        """Magnitude of dry friction while sliding in direction `m.sign`, N."""
        return 0.0

    @staticmethod
    def breakaway(p: Values, m: Moment) -> float:
        """Largest force that friction holds against a push in direction `m.sign`, N; `friction` unless given."""
        return 0.0

    @staticmethod
    def switches(p: Values, m: Moment) -> tuple[float, ...]:
        """Functions of the state whose sign changes mark a change of law; the signs are `m.sides`."""
        return ()

    @staticmethod
    def rates(p: Values, m: Moment) -> tuple[float, ...]:
        """Rates of the effect's own states `m.extra`, per second."""
        return ()

    @staticmethod
    def at_rest(p: Values, x: float, volts: float) -> tuple[float, ...]:
        """Own states (extra, then memory) of a plant that has long rested at `x` under `volts`; zeros unless given."""
        return ()

    @staticmethod
    def remember(p: Values, memory: tuple[float, ...], shift: float, sign: float) -> tuple[float, ...]:
        """Own memory after the cart has moved by `shift` [m] in direction `sign` from where it was `memory`."""
        return memory

    @staticmethod
    def memory_slopes(p: Values, m: Moment) -> tuple[float, ...]:
        """Change of the own memory per meter of travel, for solvers that know rates only (optional)."""
        return ()

    @staticmethod
    def drive(p: Values, m: Moment) -> float:
        """Voltage handed on toward the motor, V; `m.volts` is what arrives from the effects before in `drive_order`."""
        return m.volts

    @staticmethod
    def delay(p: Values) -> float:
        """Time by which the input comes late, s."""
        return 0.0

    @staticmethod
    def reading(p: Values, time: float) -> float:
        """Reading added to the true position, m."""
        return 0.0

    @staticmethod
    def relax(p: Values, m: Moment, time: float) -> tuple[float, ...]:
        """Own states `time` [s] after `m` in closed form, for effects of the drive whose states follow `m.volts` alone.

        The input is a cubic meanwhile (`m.slope`, `m.bend`, `m.jerk`): a law need not be exact, steps are short then.
        """
        return ()

    @staticmethod
    def kink(p: Values, m: Moment) -> float:
        """Time [s] after which a state of `relax` turns a corner, where that is known: a step ends there."""
        return np.inf

    def holds(self, p: Values, m: Moment) -> float:
        """Largest force that friction holds at rest, N: what `breakaway` says, or `friction` where it is not given."""
        given = type(self).breakaway is not Effect.breakaway
        return self.breakaway(p, m) if given else self.friction(p, m)

    def __repr__(self) -> str:
        return f"<effect {self.name}: {', '.join(q.name for q in self.parameters)}>"
