"""From an export of the ECP program to a draft of its run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from stepid.errors import InputError
from stepid.io.ecp import FULL_SCALE, VOLTS_PER_DAC_UNIT
from stepid.io.ecp_layout import EFFORT, SAMPLE, TIME, Export, is_encoder, parse_export
from stepid.io.guess.draft import ALL, Draft, Found, falls
from stepid.io.guess.file_names import plain_name, read_name
from stepid.io.guess.named import named
from stepid.io.guess.words import COUNTS
from stepid.io.sample_clock import ENOUGH, fit_sample_time


def export_of(lines: Sequence[str], where: str) -> Export | None:
    """Parse an export of the ECP program, None where the lines are none."""
    try:
        export = parse_export(lines, columns=None, where=where)
    except InputError:
        if any("encoder" in line.lower() and "pos" in line.lower() for line in lines[:40]) and any(
            line.lstrip().startswith("[") for line in lines
        ):
            raise
        return None
    return export if any(map(is_encoder, export.columns)) else None


def from_export(export: Export, file: Path, chosen: Mapping[str, str]) -> Draft:
    """What an export says of its run: the encoder that moves, its input, and the sample time where the stamps agree.

    It has columns of its own: those that are `chosen`, as in `stepid.io.guess.understand.draft_runs`, must be these.
    """
    encoders = [name for name in export.columns if is_encoder(name)]
    moved = [name for name in encoders if np.ptp(export[name]) > 0]
    encoder = (moved or encoders)[0]
    readings = {"position": export[encoder]}
    layout: dict[str, object] = {}
    if encoder != "Encoder 1 Pos":
        layout["encoder"] = int(encoder.split()[1])
    scales, doubts = {}, []
    if EFFORT in export:
        readings["input"] = export[EFFORT]
        largest = float(np.abs(export[EFFORT]).max())
        if export.tabbed:
            scales["input"] = Found(VOLTS_PER_DAC_UNIT, "the program's DAC units")
            if 0 < largest < FULL_SCALE:
                doubts.append("Control Effort may be in volts or DAC units; say which by effort_scale")
        elif largest > FULL_SCALE:
            doubts.append("Control Effort is too large for volts; say its scale by effort_scale")
    time, sample = export.get(TIME), export.get(SAMPLE)
    sample = np.arange(len(export.lines), dtype=np.float64) if sample is None else sample
    known = None
    if time is not None and time.size > 1:
        step, spread = fit_sample_time(sample, time, resolution=export.time_resolution)
        readings["time"] = sample * step
        known = Found(step, "the columns Sample and Time") if spread <= ENOUGH * step else None
    titles = {"position": encoder, "input": EFFORT, "time": TIME}
    draft = Draft(
        file=file,
        name=plain_name(file.stem),
        format="ecp",
        layout=layout,
        columns={role: role for role in readings},
        titles=titles,
        readings=readings,
        units={"position": Found(COUNTS, "the program"), "time": Found("s", "the program")}
        | ({"input": Found("V", "the program")} if EFFORT in export else {}),
        scales=scales,
        sample_time=known,
        falling=falls(readings),
        doubts=tuple(doubts),
        lacking={
            role: f"is an export of the ECP program, whose {role} is {titles[role]!r}"
            for role, name in chosen.items()
            if name not in (titles[role], ALL)
        },
    )
    return named(draft, read_name(file.stem), None)
