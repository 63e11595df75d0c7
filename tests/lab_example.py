"""An answer and a submission made by hand."""

from __future__ import annotations

from stepid import Estimate, lab

TRUTH = {"base_mass": 1.0, "stiffness[medium]": 200.0, "damping[1/2 turn]": 10.0, "force_gain": 8.0}
UNITS = {"base_mass": "kg", "stiffness[medium]": "N/m", "damping[1/2 turn]": "N·s/m", "force_gain": "N/V"}


def answer(effects=("coulomb_friction",), own=None, units=None, group="A", attainable=None):
    own = {"coulomb_friction.level": 0.3} if own is None else own
    return lab.Answer(
        group=group,
        effects=effects,
        parameters=TRUTH | own,
        units=UNITS | (dict.fromkeys(own, "N") if units is None else units),
        attainable=attainable or {},
        visibility=10.0,
        noise=1e-5,
        records="r",
        nonce="n",
    )


def submission(effects=("coulomb_friction",), alternatives=(), group="A", **changes):
    units = UNITS | {"coulomb_friction.level": "N"}
    given = {n: Estimate(value=v, uncertainty=0.01 * v, unit=units[n]) for n, v in TRUTH.items()}
    if "coulomb_friction" in effects:
        given["coulomb_friction.level"] = Estimate(value=0.3, uncertainty=0.003, unit="N")
    for name, estimate in changes.items():
        name = {"mass": "base_mass", "level": "coulomb_friction.level"}.get(name, name)
        if estimate is None:
            del given[name]
        else:
            given[name] = estimate
    return lab.Submission(group=group, parameters=given, effects=effects, alternatives=alternatives)


def mass(value, uncertainty, unit="kg"):
    return Estimate(value=value, uncertainty=uncertainty, unit=unit)
