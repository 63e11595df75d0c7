"""What a simulator is accepted by: every effect alone and thirty combinations on the paper's plant, as data.

`CASES[name]` is (effects, settings); the settings are the other fields of `hidden.Run`. Everything starts at rest: own
states with the cart (a second mass and a dashpot's joint at its position, bristles unbent), the drive at its force
before the record. `reference(case)` is the position at the samples in m, right to 1e-4 counts (`python -m
hidden.accuracy_cases` in tests/ shows how far: against tolerances a hundred times as tight).
"""

from __future__ import annotations

import hashlib
import os
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from .plant import Effects, Run
from .reference import reference as integrate

COUNTS, PERIOD = 226600.0, 0.0088542  # counts/m, s: the paper's
Case = tuple[Effects, dict[str, Any]]
ALONE: dict[str, dict[str, float]] = {
    "coulomb_friction": {"level": 0.3},
    "load_proportional_friction": {"coefficient": 0.015},
    "stribeck_friction": {"level": 0.2, "breakaway": 0.4, "velocity": 0.006},
    "asymmetric_friction": {"level_forward": 0.2, "level_backward": 0.35},
    "presliding_hysteresis": {"level": 0.25, "distance": 1.5e-4},
    "quadratic_damping": {"coefficient": 40.0},
    "position_dependent_damping": {"slope": -14.0},
    "cubic_stiffness": {"coefficient": 1.5e5},
    "quadratic_stiffness": {"coefficient": -1500.0},
    "free_play": {"gap": 0.0008},
    "end_stop": {"stiffness": 4000.0, "position": 0.0185},
    "viscoelastic_spring": {"stiffness": 60.0, "damping": 6.0},
    "flexible_coupling": {"mass": 0.25, "stiffness": 800.0, "damping": 0.8},
    "actuator_lag": {"time_constant": 0.01},
    "input_delay": {"delay": 0.013},
    "actuator_dead_zone": {"level": 0.05},
    "actuator_saturation": {"level": 0.42},
    "periodic_disturbance": {"amplitude": 0.2, "frequency": 5.3},
    "cogging": {"amplitude": 0.3, "pitch": 0.005, "phase": 1.0},
    "sensor_drift": {"rate": 3e-4},
    "sine_stiffness": {"curvature": 30.0},
    "power_damping": {"coefficient": 0.8, "exponent": 0.6},
    "actuator_rate_limit": {"rate": 4.0},
}
RELEASED = {**ALONE, "end_stop": {"stiffness": 4000.0, "position": -0.009}}  # on the side that is swung to
COMBINED = {
    **ALONE,
    "end_stop": {"stiffness": 4000.0, "position": 0.006},
    "sine_stiffness": {"curvature": 20.0},
    "actuator_saturation": {"level": 0.28},
}
FAMILIES = (  # at most one of each in a combination, but for the drive's
    ("coulomb_friction", "load_proportional_friction", "stribeck_friction", "asymmetric_friction"),
    ("presliding_hysteresis",),
    ("quadratic_damping", "position_dependent_damping", "power_damping"),
    ("cubic_stiffness", "quadratic_stiffness", "sine_stiffness"),
    ("free_play", "end_stop"),
    ("viscoelastic_spring", "flexible_coupling"),
    ("periodic_disturbance", "cogging", "sensor_drift"),
    ("actuator_lag", "input_delay"),
    ("actuator_dead_zone", "actuator_saturation", "actuator_rate_limit"),
)
DRIVE = {*FAMILIES[-1], *FAMILIES[-2]}


def _settings(inputs: np.ndarray, damping: float, **more: Any) -> dict[str, Any]:
    plain = {"mass": 1.5, "stiffness": 216.0, "damping": damping, "gain": 7.8, "sample_time": PERIOD}
    return {**plain, "inputs": inputs, "phase": 0.7, **more}


def _step() -> dict[str, Any]:
    return _settings(np.repeat([0.0, 0.5, 0.0], [5, 150, 145]), 14.0)


def _release(name: str) -> dict[str, Any]:
    """Free from 15 mm; with a step in the second half where the effect is the drive's."""
    later = 0.5 if name in DRIVE else 0.0
    return _settings(np.repeat([0.0, later], [150, 110]), 2.0, position=0.015)


def _powers() -> dict[str, Case]:
    values = ((0.5, 0.3), (3.0, 1.3), (60.0, 2.7))
    named = {f"power_damping {p}": {"power_damping": {"coefficient": c, "exponent": p}} for c, p in values}
    return {name: (effects, _step()) for name, effects in named.items()}


def _combination(number: int) -> Case:
    rng = np.random.default_rng([2024, number])
    wanted = int(rng.integers(2, 5))
    chosen: list[str] = []
    for i in rng.permutation(len(FAMILIES))[:wanted]:
        chosen.append(str(rng.choice(FAMILIES[i])))
    effects = {}
    for name in chosen:
        values = dict(COMBINED[name])
        scale = float(rng.uniform(0.6, 1.3))
        for parameter in values:
            if parameter not in ("exponent", "phase", "position", "frequency", "pitch"):
                values[parameter] = float(f"{values[parameter] * scale:.6g}")
        effects[name] = values
    damping = float(rng.choice([2.0, 6.0, 14.0]))
    if number % 3 == 2 and not DRIVE & set(chosen):
        start = -0.014 if "end_stop" in effects else float(rng.choice([-1, 1])) * 0.014
        return effects, _settings(np.zeros(220), damping, position=start)
    volts = rng.choice([0.5, -0.5, 0.35, 0.2, 0.0], size=3, replace=False)
    return effects, _settings(
        np.repeat([0.0, *volts], [4, 80, 80, 76]), damping, mass=float(rng.choice([1.0, 1.5, 3.0]))
    )


def _between() -> dict[str, Case]:
    """Inputs that are joined between the samples."""
    wave = 0.45 * np.sin(np.arange(200) / 9.0) + 0.1 * np.sin(np.arange(200) / 2.3)
    drive = {n: ALONE[n] for n in ("input_delay", "actuator_dead_zone", "actuator_rate_limit", "actuator_lag")}
    told = {"plain": {}, "friction": {"coulomb_friction": {"level": 0.3}}, "drive": drive}
    ways = ("straight", "smooth")
    return {f"{way} {n}": (e, _settings(wave, 6.0, input_between=way)) for way in ways for n, e in told.items()}


CASES: dict[str, Case] = {
    "linear step": ({}, _step()),
    "linear release": ({}, _release("")),
    **{f"{name} step": ({name: values}, _step()) for name, values in ALONE.items()},
    **{f"{name} release": ({name: values}, _release(name)) for name, values in RELEASED.items()},
    **_powers(),
    **{f"combination {i}": _combination(i) for i in range(30)},
    **_between(),
}


def run(case: str | Case) -> Run:
    effects, settings = CASES[case] if isinstance(case, str) else case
    return Run(effects=effects, **settings)


def _folder() -> Path:
    told = os.environ.get("STEPID_REFERENCE_CACHE")
    return Path(told) if told else Path(tempfile.gettempdir()) / "stepid-reference"


def reference(case: str | Case, *, fineness: float = 1.0) -> np.ndarray:
    """Position at each sample, m; kept in the temporary folder (STEPID_REFERENCE_CACHE for another)."""
    effects, settings = CASES[case] if isinstance(case, str) else case
    told = {k: v.tolist() if isinstance(v, np.ndarray) else v for k, v in settings.items()}
    code = b"".join((Path(__file__).parent / name).read_bytes() for name in ("plant.py", "drive.py", "reference.py"))
    key = hashlib.sha256(code + repr((effects, told, fineness)).encode()).hexdigest()[:24]
    file = _folder() / f"{key}.npy"
    if file.exists():
        return np.asarray(np.load(file))
    x = integrate(Run(effects=effects, **settings), fineness=fineness)
    file.parent.mkdir(parents=True, exist_ok=True)
    part = file.with_suffix(f".{os.getpid()}.npy")
    np.save(part, x)
    part.replace(file)
    return x


def main() -> None:
    """The reference's own error, case by case, and how much each effect shows."""
    worst = 0.0
    print("| case | samples | swing, counts | own error, counts |\n| --- | --- | --- | --- |")
    for name in CASES:
        x = reference(name)
        error = float(np.max(np.abs(x - reference(name, fineness=0.01)))) * COUNTS
        worst = max(worst, error)
        print(f"| {name} | {x.size} | {np.ptp(x) * COUNTS:.0f} | {error:.1e} |", flush=True)
    print(f"{len(CASES)} cases, worst {worst:.1e} counts, asked: below 1e-4")


if __name__ == "__main__":
    main()
