"""What the hashes of an assignment cover: these fields, in this order, written in this way, ever after.

A field that a model gains later is not among them, so what 0.1.0 sealed keeps its hashes. Numbers are written here and
not by pydantic, whose versions differ in how they write large ones.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence

import numpy as np

from stepid.core.experiment import Campaign

CAMPAIGN = ("name", "experiments", "weight_uncertainty")
EXPERIMENT = (
    "name",
    "time",
    "position",
    "input",
    "added_mass",
    "spring",
    "damper",
    "counts_per_meter",
    "input_before",
    "base",
)
ANSWER = ("group", "effects", "parameters", "units", "attainable", "visibility", "noise", "records", "nonce")


def digest(campaign: Campaign) -> str:
    """SHA-256 of a campaign's records, hexadecimal; the same after writing and reading."""
    runs = [_chosen(run, EXPERIMENT) for run in campaign.experiments]
    return _sha256(_chosen(campaign, CAMPAIGN) | {"experiments": runs})


def answer_digest(answer: object) -> str:
    """SHA-256 of an `Answer`, hexadecimal."""
    return _sha256(_chosen(answer, ANSWER))


def _chosen(model: object, fields: tuple[str, ...]) -> dict[str, object]:
    return {field: getattr(model, field) for field in fields}


def _sha256(value: object) -> str:
    return hashlib.sha256(written(value).encode()).hexdigest()


def written(value: object) -> str:
    """JSON without blanks."""
    if value is None:
        return "null"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, int | float):
        return _number(float(value))
    if isinstance(value, Mapping):
        return "{" + ",".join(f"{written(k)}:{written(v)}" for k, v in value.items()) + "}"
    if isinstance(value, np.ndarray):
        return "[" + ",".join(map(_number, value.tolist())) + "]"
    if isinstance(value, Sequence):
        return "[" + ",".join(map(written, value)) + "]"
    raise TypeError(f"{type(value).__name__} is nothing that a hash covers")


def _number(value: float) -> str:
    """Shortest decimals that give the number again; a power of ten from 1e16 up and from 1e-6 down, as in 1.5e-6."""
    digits, _, power = repr(value).partition("e")
    if not power:
        return digits
    if int(power) == -5:  # repr writes 1.5e-05
        sign = "-" * digits.startswith("-")
        return f"{sign}0.0000{digits.lstrip('-').replace('.', '')}"
    return f"{digits}e{int(power):+d}"
