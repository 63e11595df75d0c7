"""CPU time of a joint fit with one known effect: stepid beside what an expert and a user write themselves.

    python benchmarks/joint_fit.py [--only NAME] [--quick] [--repeats N]

- stepid: `stepid.fit(campaign, effects=...)`, from a start of its own, after a first call;
- loop: the plain compiled loop of loop.py in scipy's `least_squares` (2-point Jacobian), from 15 % off;
- scipy: `solve_ivp` with events (solve_events.py) in the same `least_squares`;
- lmfit: `solve_ivp` with events in `lmfit.minimize`.

All but stepid know that the runs start at rest in the middle of the band, eliminate the rest positions and start 15 %
off the truth, up or down. They can end in a wrong place: of ten such starts the first from which the loop reaches the
noise is used for all three, and the table says how many did. --quick leaves out scipy and lmfit.
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

import numpy as np
from scipy.optimize import least_squares

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "tests"), str(ROOT / "benchmarks")]

import loop  # noqa: E402
import solve_events  # noqa: E402
import stepid  # noqa: E402
from hidden.campaigns import make_campaign  # noqa: E402

CASES = (  # effect, kind of the campaign
    ("coulomb_friction", "four"),
    ("stribeck_friction", "four"),
    ("cubic_stiffness", "four"),
    ("coulomb_friction", "nine"),
)
RTOL = 1e-6
DIFFERENCE = 1e-5  # share of a parameter by which it is moved for the Jacobian
STARTS = 10
Values = dict[str, float]
Route = Callable[[stepid.Experiment, Values], np.ndarray]


def campaign_at_rest(effect: str, kind: str) -> tuple[stepid.Campaign, dict[str, Any]]:
    """A campaign whose runs start in the middle of the band, as the users' models do."""
    seed = 12
    while True:
        campaign, truth = make_campaign(seed, (effect,), kind=kind, r0=30.0)
        if not any(truth["starts"]):
            return campaign, truth
        seed += 1


def true_values(truth: dict[str, Any]) -> Values:
    """Every parameter of the joint fit, by stepid's names."""
    told = {"base_mass": truth["base_mass"], "force_gain": truth["force_gain"]}
    told |= {f"stiffness[{label}]": v for label, v in truth["stiffness"].items()}
    told |= {f"damping[{label}]": v for label, v in truth["damping"].items()}
    return {name: float(v) for name, v in (told | truth["parameters"]).items()}


def plant_of(e: stepid.Experiment, values: Values) -> dict[str, Any]:
    effects: dict[str, dict[str, float]] = {}
    for name, v in values.items():
        effect, _, parameter = name.partition(".")
        if parameter:
            effects.setdefault(effect, {})[parameter] = v
    return {
        "mass": values["base_mass"] + e.added_mass,
        "stiffness": values[f"stiffness[{e.spring}]"],
        "damping": values[f"damping[{e.damper}]"],
        "gain": values["force_gain"],
        "effects": effects,
    }


def loop_route(parts: int) -> Route:
    def route(e: stepid.Experiment, values: Values) -> np.ndarray:
        out = np.empty((1, e.time.size))
        loop.run_rows(loop.row(**plant_of(e, values))[None], e.input, e.sample_time, parts, 0.0, 0.0, out)
        return out[0]

    return route


def enough_parts(campaign: stepid.Campaign, values: Values) -> int:
    """Substeps of which twice as many change nothing by 0.01 count."""
    parts = 1
    while parts < 256:
        apart = [loop_route(parts)(e, values) - loop_route(2 * parts)(e, values) for e in campaign.experiments]
        if np.sqrt(np.mean(np.concatenate(apart) ** 2)) < 0.01 / 226600:
            break
        parts *= 2
    return parts


def ivp_route(method: str) -> Route:
    def route(e: stepid.Experiment, values: Values) -> np.ndarray:
        plant = solve_events.Plant(**plant_of(e, values))
        return solve_events.simulate(plant, np.asarray(e.time), np.asarray(e.input), method, RTOL)

    return route


def residual(campaign: stepid.Campaign, values: Values, route: Route) -> np.ndarray:
    left = [e.position - route(e, values) for e in campaign.experiments]
    return np.concatenate([x - x.mean() for x in left])


def by_least_squares(campaign: stepid.Campaign, truth: Values, route: Route, start: np.ndarray) -> tuple[Values, float]:
    """Parameters in units of the truth; differences wider than the noise of located events."""
    names, scale = list(truth), np.array(list(truth.values()))

    def left(q: np.ndarray) -> np.ndarray:
        return residual(campaign, dict(zip(names, q * scale, strict=True)), route)

    found = least_squares(left, start, bounds=(0.02, 50.0), ftol=1e-7, xtol=1e-7, x_scale="jac", diff_step=DIFFERENCE)
    return dict(zip(names, found.x * scale, strict=True)), float(np.sqrt(np.mean(found.fun**2)))


def by_lmfit(campaign: stepid.Campaign, truth: Values, route: Route, start: np.ndarray) -> tuple[Values, float]:
    import lmfit  # not needed with --quick

    p = lmfit.Parameters()
    keys = {name: f"q{i}" for i, name in enumerate(truth)}
    for (name, v), factor in zip(truth.items(), start, strict=True):
        ends = sorted((0.02 * v, 50 * v))
        p.add(keys[name], value=factor * v, min=ends[0], max=ends[1])

    def left(p: lmfit.Parameters) -> np.ndarray:
        return residual(campaign, {name: p[key].value for name, key in keys.items()}, route)

    found = lmfit.minimize(left, p, method="leastsq", ftol=1e-7, xtol=1e-7, epsfcn=DIFFERENCE**2)
    values = {name: found.params[key].value for name, key in keys.items()}
    return values, float(np.sqrt(np.mean(found.residual**2)))


def good_start(campaign: stepid.Campaign, truth: Values, route: Route, noise: float) -> tuple[np.ndarray, int]:
    """The first start from which the loop reaches the noise, and how many of all do."""
    starts = [np.random.default_rng(i).choice([0.85, 1.15], size=len(truth)) for i in range(STARTS)]
    good = [q for q in starts if by_least_squares(campaign, truth, route, q)[1] < 1.1 * noise]
    return (good or starts)[0], len(good)


def by_stepid(campaign: stepid.Campaign, effect: str) -> tuple[Values, float, dict[str, float]]:
    f = stepid.fit(campaign, effects=(effect,))
    values = {name: q.value for name, q in f.parameters.items()}
    return values, float(f.rms), {n: q.uncertainty for n, q in f.parameters.items() if q.uncertainty}


def clock(work: Callable[[], Any], repeats: int = 1) -> tuple[float, Any]:
    least, result = float("inf"), None
    for _ in range(repeats):
        start = time.process_time()  # one thread each, and fair where others compute too
        result = work()
        least = min(least, time.process_time() - start)
    return least, result


def apart(one: Values, other: Values, sigma: dict[str, float]) -> tuple[float, float]:
    """Largest difference of what both found: relative, and in standard deviations that stepid tells."""
    common = [n for n in one if n in other]
    relative = max(abs(one[n] / other[n] - 1) for n in common)
    return relative, max((abs(one[n] - other[n]) / sigma[n] for n in common if n in sigma), default=float("nan"))


def compare(effect: str, kind: str, repeats: int, quick: bool) -> list[list[str]]:
    campaign, told = campaign_at_rest(effect, kind)
    truth = true_values(told)
    by_stepid(campaign, effect)  # imports, caches, compilation
    parts = enough_parts(campaign, truth)
    start, good = good_start(campaign, truth, loop_route(parts), told["noise_rms"])
    ours, theirs = float("inf"), float("inf")
    for _ in range(repeats):  # in turns
        fresh = campaign.model_copy(deep=True)  # of what is known of a record nothing is kept
        seconds, (values, rms, sigma) = clock(lambda fresh=fresh: by_stepid(fresh, effect))
        ours = min(ours, seconds)
        seconds, (plain, plain_rms) = clock(lambda: by_least_squares(campaign, truth, loop_route(parts), start), 3)
        theirs = min(theirs, seconds)
    results = [
        ("stepid", ours, values, rms),
        (f"loop, {parts} parts, {good} of {STARTS} starts", theirs, plain, plain_rms),
    ]
    if not quick:
        first = campaign.experiments[0]
        speed = {m: clock(lambda m=m: ivp_route(m)(first, truth))[0] for m in solve_events.METHODS}
        best = min(speed, key=lambda m: speed[m])
        for name, work in (("scipy", by_least_squares), ("lmfit", by_lmfit)):
            seconds, (found, left) = clock(lambda work=work: work(campaign, truth, ivp_route(best), start))
            results.append((f"{name}, {best}", seconds, found, left))
    lines = []
    for name, seconds, found, left in results:
        relative, deviations = apart(found, values, sigma)
        own = ["", ""] if found is values else [f"{100 * relative:.2g} %", f"{deviations:.2g}"]
        cells = [f"{len(campaign.experiments)} runs, {effect}", name, f"{seconds:.3g}", f"{seconds / ours:.3g}"]
        lines.append([*cells, f"{left / told['noise_rms']:.4f}", *own])
    return lines


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", help="cases whose name contains this, such as cubic or nine")
    parser.add_argument("--quick", action="store_true", help="stepid and the loop only")
    parser.add_argument("--repeats", type=int, default=3)
    args = parser.parse_args()
    head = ["fit", "by", "CPU s", "times stepid's", "RMS over noise", "furthest from stepid's", "in its deviations"]
    print(f"| {' | '.join(head)} |\n|{' --- |' * len(head)}")
    for effect, kind in CASES:
        if args.only and args.only not in f"{effect} {kind}":
            continue
        for line in compare(effect, kind, args.repeats, args.quick):
            print(f"| {' | '.join(line)} |", flush=True)


if __name__ == "__main__":
    main()
