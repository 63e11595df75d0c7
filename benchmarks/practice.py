"""Campaigns in folders, with an answers.json beside them that uses short parameter names."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import stepid

SHORT = {
    "coulomb_friction": {"level": "Fc"},
    "load_proportional_friction": {"coefficient": "mu"},
    "stribeck_friction": {"level": "Fc", "breakaway": "Fs", "velocity": "vs"},
    "asymmetric_friction": {"level_backward": "Fc"},
    "presliding_hysteresis": {"distance": "alpha"},
    "quadratic_damping": {"coefficient": "c2"},
    "position_dependent_damping": {"slope": "cpos"},
    "cubic_stiffness": {"coefficient": "k3"},
    "quadratic_stiffness": {"coefficient": "k2"},
    "free_play": {"gap": "gap"},
    "end_stop": {"stiffness": "kstop", "position": "xstop"},
    "viscoelastic_spring": {"stiffness": "kve", "damping": "cve"},
    "flexible_coupling": {"mass": "m2", "stiffness": "kc", "damping": "cc"},
    "actuator_lag": {"time_constant": "tau"},
    "input_delay": {"delay": "delay"},
    "periodic_disturbance": {"amplitude": "aper", "frequency": "fper"},
    "cogging": {"amplitude": "kper", "pitch": "xper", "phase": "phper"},
    "sensor_drift": {"rate": "drift"},
}


def canonical(effects: list[str], short: Mapping[str, float]) -> dict[str, float]:
    """Canonical parameter names; what is put together from two short ones is computed."""
    found = {
        f"{effect}.{name}": float(short[key])
        for effect in effects
        for name, key in SHORT.get(effect, {}).items()
        if key in short
    }
    if "asymmetric_friction" in effects and "Fcm" in short:
        found["asymmetric_friction.level_forward"] = float(short["Fc"] + short["Fcm"])
    if "presliding_hysteresis" in effects and "kb" in short:
        # the answers give a Dahl force kb·z with |z| ≤ alpha
        found["presliding_hysteresis.level"] = float(short["kb"] * short["alpha"])
    return found


def cases(folder: Path) -> Iterator[tuple[str, stepid.Campaign, dict[str, Any]]]:
    """(set, campaign, truth) of every campaign with an answer."""
    told = json.loads((folder / "answers.json").read_text(encoding="utf-8"))
    for name, answer in sorted(told.items()):
        effects = [] if answer["outside_catalogue"] else answer["effects"]
        outside = "+".join(answer["effects"]) if answer["outside_catalogue"] else None
        which = "outside" if outside else ("none", "single", "pairs")[min(len(effects), 2)]
        yield (
            which,
            stepid.read_campaign(folder / name / "campaign.toml"),
            {
                "seed": name,
                "kind": "practice",
                "effects": tuple(effects),
                "outside": outside,
                "r0": answer["r0"],
                "noise_rms": answer["noise_rms"],
                "variants": (),
                "parameters": canonical(effects, answer["effect_parameters"]),
            },
        )
