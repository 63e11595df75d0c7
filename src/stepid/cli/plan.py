"""`stepid plan`: which runs a guessed plant needs."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any, cast

import typer

import stepid
from stepid.cli.terminal import check_out
from stepid.errors import InputError
from stepid.io.guess.spoken import numbers

EXAMPLES = (
    "stepid plan -m 0.95 -k 216 -c 12 -g 7.8 --noise 2e-5 --out plan",
    "stepid plan -m 1 -k 200 -c 9 -g 8 --noise 1e-4 --runs 2,4,6 --check 200",
)


def plan(
    base_mass: Annotated[float, typer.Option("--base-mass", "-m", help="Guess, kg.", show_default=False)],
    stiffness: Annotated[float, typer.Option("--stiffness", "-k", help="Guess, N/m.", show_default=False)],
    damping: Annotated[float, typer.Option("--damping", "-c", help="Guess, N·s/m.", show_default=False)],
    force_gain: Annotated[float, typer.Option("--force-gain", "-g", help="Guess, N/V.", show_default=False)],
    noise: Annotated[float, typer.Option("--noise", help="Of the sensor, m.", show_default=False)],
    masses: Annotated[str, typer.Option("--masses", help="Weights that can be added, kg.")] = "0,0.5,1,1.5,2",
    levels: Annotated[str, typer.Option("--levels", help="Steps that can be made, V.")] = "0.5,-0.5,0.25",
    sample_times: Annotated[str, typer.Option("--sample-times", help="s.")] = "0.002,0.005,0.01",
    runs: Annotated[str, typer.Option("--runs", help="How many one would make.")] = "2,3,4,6,8,12",
    effects: Annotated[str, typer.Option("--effects", help="That are there, too.", show_default=False)] = "",
    want: Annotated[
        str, typer.Option("--want", help="Largest relative standard uncertainties.")
    ] = "base_mass=0.02,stiffness=0.02,damping=0.02",
    separate: Annotated[
        str, typer.Option("--separate", help="Two effects that are to be told apart.", show_default=False)
    ] = "",
    duration: Annotated[float | None, typer.Option("--duration", help="Of a record, s.", show_default=False)] = None,
    travel: Annotated[float | None, typer.Option("--travel", help="Of the cart, m.", show_default=False)] = None,
    noise_time: Annotated[float, typer.Option("--noise-time", help="Correlation time of the noise, s.")] = 0.0,
    weight_uncertainty: Annotated[float, typer.Option("--weight-uncertainty", help="Of a 0.5 kg weight, kg.")] = 0.005,
    motion: Annotated[
        str | None, typer.Option("--motion", help="rotation: kg·m², rad and N·m for kg, m and N.", show_default=False)
    ] = None,
    input_unit: Annotated[
        str | None, typer.Option("--input-unit", help="A, N or N·m for V.", show_default=False)
    ] = None,
    check: Annotated[
        int, typer.Option("--check", metavar="N", help="Simulate the advice so many times, and compare.")
    ] = 0,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="DIR", help="Folder for text, numbers and picture.", show_default=False),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", metavar="", help="Print JSON instead of text.")] = False,
) -> None:
    """Say which runs to make: masses, how many, sample time, size and direction of the steps."""
    check_out(out, "matplotlib")
    found = stepid.plan(
        {"base_mass": base_mass, "stiffness": stiffness, "damping": damping, "force_gain": force_gain},
        noise=noise,
        masses=numbers(masses, "--masses"),
        levels=numbers(levels, "--levels", unit="V"),
        sample_times=numbers(sample_times, "--sample-times", unit="s"),
        runs=_counts(runs),
        effects=_names(effects),
        wanted=_wants(want),
        separate=_names(separate) if separate else None,
        duration=duration,
        travel=travel,
        noise_time=noise_time,
        weight_uncertainty=weight_uncertainty,
        motion=cast(Any, motion),  # checked there
        input_unit=cast(Any, input_unit),
    )
    _show(found, found.check(check) if check else None, out, as_json=as_json)


def _show(found: stepid.Plan, checked: stepid.PlanCheck | None, out: Path | None, *, as_json: bool) -> None:
    values = {"format": 1, "stepid": stepid.__version__, **found.to_dict()}
    text = found.summary()
    if checked is not None:
        text = f"{text}\n\n{checked.summary()}"
        values["check"] = checked.to_dict()
    typer.echo(json.dumps(values, indent=2, ensure_ascii=False) if as_json else text)
    if out is not None:
        _write(found, text, values, out)
        if not as_json:
            typer.echo(f"wrote {out}")


def _write(found: stepid.Plan, text: str, values: dict[str, object], out: Path) -> None:
    from stepid import plot
    from stepid.core.atomic_write import staged

    with staged(out) as folder:
        (folder / "plan.txt").write_text(text + "\n", encoding="utf-8")
        (folder / "plan.json").write_text(json.dumps(values, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")
        plot.save(next(iter(found.plot().values())), folder / "plan.png")


def _names(given: str) -> tuple[str, ...]:
    return tuple(name.strip() for name in given.split(",") if name.strip())


def _counts(given: str) -> tuple[int, ...]:
    several = numbers(given, "--runs", unit="", example="2,4,8")
    if not all(one.is_integer() for one in several):
        raise InputError(f"--runs is {given!r}", "Give whole numbers parted by commas: 2,4,8.")
    return tuple(map(int, several))


def _wants(given: str) -> dict[str, float]:
    out = {}
    for part in _names(given):
        name, _, share = part.partition("=")
        try:
            out[name.strip()] = float(share)
        except ValueError:
            raise InputError(f"--want {part!r} says no number", "Give for example --want base_mass=0.02.") from None
    return out
