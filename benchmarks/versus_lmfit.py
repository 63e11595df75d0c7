"""stepid beside what a user does today for one known effect, on one nine-run campaign with Coulomb friction.

    python benchmarks/versus_lmfit.py [--seed N] [--tanh]

Timed in the same run, on one core:
- `stepid.diagnose`: the whole search over the catalogue, friction not known beforehand;
- `stepid.fit` with the effect given;
- lmfit with `solve_ivp`, friction known beforehand, written by someone who knows how: events at v = 0, the cart locked
  while the net force is within the friction band, restarts at every change of the input, rest positions eliminated,
  the fastest of three integrators at a tolerance that suffices, and a start 15 % off the truth;
- with --tanh: the same with tanh(v/v0) instead of events, which is what most scripts do;
- the paper's peak method: peaks by `control.step_info`.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")

import argparse
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import control
import lmfit
import numpy as np
from scipy.integrate import solve_ivp

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests"))

import stepid  # noqa: E402
from hidden.campaigns import make_campaign  # noqa: E402

Plant = tuple[float, float, float, float, float]  # m, k, c, gain, friction


def events_route(e: stepid.Experiment, plant: Plant, method: str, rtol: float) -> np.ndarray:
    """Position of one run: slip by `solve_ivp` up to the next v = 0, stick while the net force stays in the band."""
    m, k, c, gain, friction = plant
    x, v, now, sign = 0.0, 0.0, float(e.time[0]), 0.0
    out = np.empty(e.time.size)
    switches = np.flatnonzero(np.diff(e.input)) + 1
    ends = [*e.time[switches], e.time[-1]]
    drives = gain * e.input[[0, *switches]]

    def stop(t: float, y: np.ndarray) -> float:
        return float(y[1])

    stop.terminal = True  # type: ignore[attr-defined]
    for drive, end in zip(drives, ends, strict=True):
        while now < end:
            if abs(v) < 1e-12:
                net = drive - k * x
                if abs(net) <= friction:  # locked until the input changes
                    out[(e.time >= now) & (e.time <= end)] = x
                    now, v = float(end), 0.0
                    continue
                sign = float(np.sign(net))

            def rates(t: float, y: np.ndarray, force: float = drive - sign * friction) -> list[float]:
                return [y[1], (force - c * y[1] - k * y[0]) / m]

            stop.direction = -sign  # type: ignore[attr-defined]
            inside = (e.time >= now) & (e.time <= end)
            got = solve_ivp(
                rates, (now, end), [x, v], method=method, t_eval=e.time[inside], events=stop, rtol=rtol, atol=1e-9
            )
            out[np.flatnonzero(inside)[: got.t.size]] = got.y[0]
            if got.status == 1:
                now, x, v = float(got.t_events[0][-1]), float(got.y_events[0][-1][0]), 0.0
            else:
                now, x, v = float(end), float(got.y[0, -1]), float(got.y[1, -1])
    return out


def tanh_route(e: stepid.Experiment, plant: Plant, method: str, rtol: float) -> np.ndarray:
    """The same with tanh in place of the sign, at the common smoothing of 1e-4 m/s."""
    m, k, c, gain, friction = plant
    out, y, now = np.empty(e.time.size), [0.0, 0.0], float(e.time[0])
    switches = np.flatnonzero(np.diff(e.input)) + 1
    for drive, end in zip(gain * e.input[[0, *switches]], [*e.time[switches], e.time[-1]], strict=True):

        def rates(t: float, y: np.ndarray, force: float = drive) -> list[float]:
            return [y[1], (force - c * y[1] - k * y[0] - friction * np.tanh(y[1] / 1e-4)) / m]

        inside = (e.time >= now) & (e.time <= end)
        wanted = np.append(e.time[inside], end)
        got = solve_ivp(rates, (now, end), y, method="LSODA", t_eval=np.unique(wanted), rtol=rtol, atol=1e-9)
        out[inside] = got.y[0, : int(inside.sum())]
        now, y = float(end), [float(got.y[0, -1]), float(got.y[1, -1])]
    return out


def lmfit_user(campaign: stepid.Campaign, truth: dict[str, Any], route: Callable[..., np.ndarray], method: str) -> Any:
    """A joint fit with lmfit: shared parameters, rest positions eliminated."""
    rng = np.random.default_rng(1)
    p = lmfit.Parameters()

    def near(name: str, value: float) -> None:
        p.add(name, value=value * float(rng.choice([0.85, 1.15])), min=0.02 * value, max=50 * value)

    near("mass", truth["base_mass"])
    near("gain", truth["force_gain"])
    near("friction", truth["parameters"]["coulomb_friction.level"])
    springs, dampers = list(truth["stiffness"]), list(truth["damping"])
    for i, label in enumerate(springs):
        near(f"k{i}", truth["stiffness"][label])
    for i, label in enumerate(dampers):
        near(f"c{i}", truth["damping"][label])

    def residual(p: lmfit.Parameters) -> np.ndarray:
        rest = []
        for e in campaign.experiments:
            k, c = p[f"k{springs.index(e.spring)}"].value, p[f"c{dampers.index(e.damper)}"].value
            plant = (p["mass"].value + e.added_mass, k, c, p["gain"].value, p["friction"].value)
            left = e.position - route(e, plant, method, 1e-6)
            rest.append(left - left.mean())
        return np.concatenate(rest)

    return lmfit.minimize(residual, p, method="leastsq", ftol=1e-7, xtol=1e-7)


def hand_method(campaign: stepid.Campaign) -> float:
    """Base mass by `control.step_info` on the medium spring's runs and the known mass differences."""
    rows, rhs, added = [], [], []
    for e in campaign.experiments:
        if e.spring != "medium" or e.damper != "half":
            continue
        begin = int(np.flatnonzero(e.input)[0])
        off = np.flatnonzero(e.input[begin:] == 0)
        end = begin + int(off[0]) if off.size else e.input.size
        x = (e.position[begin:end] - e.position[: max(begin, 1)].mean()) * np.sign(e.input[begin])
        info = control.step_info(x, T=e.time[begin:end] - e.time[begin], yfinal=float(x[-15:].mean()))
        ratio = np.log(max(info["Overshoot"], 1e-3) / 100)
        zeta = -ratio / np.hypot(ratio, np.pi)
        wn = np.pi / info["PeakTime"] / np.sqrt(1 - zeta**2)
        rows.append([1.0, -1 / wn**2])  # m0 + added = k/wn²
        rhs.append(-e.added_mass)
        added.append(e.added_mass)
    return float(np.linalg.lstsq(np.array(rows), np.array(rhs), rcond=None)[0][0])


def clock(work: Callable[[], Any]) -> tuple[float, Any]:
    start = time.process_time()  # one thread each, and fair where others compute too
    result = work()
    return time.process_time() - start, result


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=12)
    parser.add_argument("--tanh", action="store_true", help="also the tanh fit, which takes minutes")
    args = parser.parse_args()
    seed = args.seed
    while True:  # the user's model starts at rest in the middle of the band: a campaign that does so too
        campaign, truth = make_campaign(seed, ("coulomb_friction",), kind="nine", r0=30.0)
        if not any(truth["starts"]):
            break
        seed += 1
    mass, level = truth["base_mass"], truth["parameters"]["coulomb_friction.level"]
    print(f"campaign {campaign.name!r}: {len(campaign.experiments)} runs, r0 {truth['r0']:.1f}")
    rows: list[tuple[str, float, float, float, float]] = []

    def note(name: str, seconds: float, m: float, f: float, rms: float) -> None:
        rows.append((name, seconds, 100 * (m / mass - 1), 100 * (f / level - 1), rms / truth["noise_rms"]))

    stepid.fit(campaign, effects=())  # imports and caches
    seconds, d = clock(lambda: stepid.diagnose(campaign))
    told = {name: estimate.value for name, estimate in d.parameters.items()}
    friction = told.get("coulomb_friction.level", float("nan"))
    note(f"stepid.diagnose: {d.verdict} {', '.join(d.effects)}", seconds, told["base_mass"], friction, d.gap.after)
    seconds, f = clock(lambda: stepid.fit(campaign, effects=("coulomb_friction",)))
    note("stepid.fit", seconds, f.parameters["base_mass"].value, f.parameters["coulomb_friction.level"].value, f.rms)
    stiffness, damping = truth["stiffness"], truth["damping"]
    first = campaign.experiments[0]
    plant = (mass + first.added_mass, stiffness[first.spring], damping[first.damper], truth["force_gain"], level)
    speed = {m: clock(lambda m=m: events_route(first, plant, m, 1e-6))[0] for m in ("RK45", "DOP853", "LSODA")}
    best = min(speed, key=lambda m: speed[m])
    routes = [("events and locking", events_route)] + ([("tanh(v/1e-4)", tanh_route)] if args.tanh else [])
    for name, route in routes:
        seconds, found = clock(lambda route=route: lmfit_user(campaign, truth, route, best))
        rms = float(np.sqrt(np.mean(found.residual**2)))
        note(f"lmfit, {best}, {name}", seconds, found.params["mass"].value, found.params["friction"].value, rms)
    seconds, by_hand = clock(lambda: hand_method(campaign))
    note("control.step_info by hand", seconds, by_hand, float("nan"), float("nan"))
    print("| | CPU s | base mass off by | friction off by | RMS over noise |\n| --- | --- | --- | --- | --- |")
    for name, seconds, m, f, rms in rows:
        print(f"| {name} | {seconds:.3g} | {m:+.3g} % | {f:+.3g} % | {rms:.4g} |")
    print(f"lmfit with events over stepid.diagnose: {rows[2][1] / rows[0][1]:.1f} times as long")


if __name__ == "__main__":
    main()
