"""Recordings of real plants that were found last: public files of others, read as those of `more_sets`.

Each showed what the diagnosis of its day did wrong, or not; `CHANGELOG.md` says what that mended.
"""

from __future__ import annotations

from collections.abc import Mapping

from more_sets import LOSSES, MoreSet, campaign, run
from real_sets import DAMPING, DRY

_SWINGS = frozenset(LOSSES | {"sine_stiffness"})
_SMALL = frozenset(DAMPING | {"sine_stiffness", "cubic_stiffness"})  # of small swings a cube is a sine
_COPENHAGEN = "AppliedStatisticsNBI/AppStat2020"
_THESIS = "nielsSkov/masterThesisMatlab"
_ENCODER = "y-fysiks/PHY180-Pendulum-datafit"
_TORSION = "gobby237/PendoloTorsione"
_SEISMOMETER = "caspar/PhysicsLab, a Lehman seismometer"


def _set(
    name: str, source: str, known: str, allowed: frozenset[str], *files: str, after: float | None = None
) -> MoreSet:  # fmt: skip
    return MoreSet(name, source, known, allowed, lambda: campaign(name, *(run(file, after=after) for file in files)))


_ALL = (
    _set("pendulum-94deg", _ENCODER, "sine of the angle, dry friction", _SWINGS, "pendulum-encoder/free_31"),
    _set(
        "pendulum-three",
        _ENCODER,
        "sine of the angle, dry friction",
        _SWINGS,
        *(f"pendulum-encoder/free_{i}" for i in (31, 32, 33)),
    ),
    _set(
        "arm-1.5rad", _THESIS, "sine of the angle, Coulomb friction, little viscous", _SWINGS, "arm/free_1", after=21.98
    ),
    _set(
        "arm-2.1rad", _THESIS, "sine of the angle, Coulomb friction, little viscous", _SWINGS, "arm/free_2", after=8.74
    ),
    _set(
        "arm-1.4rad", _THESIS, "sine of the angle, Coulomb friction, little viscous", _SWINGS, "arm/free_2", after=16.62
    ),
    _set(
        "video-pendulum-1",
        "tylertian123/phy180_lab",
        "sine of the angle, air drag",
        _SMALL,
        "video/free_trial1",
        after=1.0,
    ),
    _set(
        "video-pendulum-2",
        "tylertian123/phy180_lab",
        "sine of the angle, air drag",
        _SMALL,
        "video/free_lab1",
        after=0.0,
    ),
    _set(
        "video-pendulum-3",
        "HaysonC/PHY180-Pendulum",
        "sine of the angle, air drag",
        _SMALL,
        "video/free_hays",
        after=1.0,
    ),
    _set("weight-bare", _COPENHAGEN, "almost linear", frozenset(DAMPING), "weight/free_1", after=0.0),
    _set("weight-cardboard", _COPENHAGEN, "air drag of a cardboard", frozenset(DAMPING), "weight/free_2", after=0.0),
    _set("weight-rubbing", _COPENHAGEN, "dry friction against metal", frozenset(DRY), "weight/free_3", after=0.0),
    _set("weight-disc", "pankaj9um/PHY224", "air drag of a disc", frozenset(DAMPING), "sonar/free_disc", after=0.0),
    _set(
        "torsion-1", _TORSION, "viscous, and a further swing in the reading", frozenset(), "torsion/free_1", after=93.5
    ),
    _set(
        "torsion-2", _TORSION, "viscous, and a further swing in the reading", frozenset(), "torsion/free_2", after=103.0
    ),
    _set(
        "seismometer-brake", _SEISMOMETER, "eddy-current brake", frozenset(DAMPING), "seismometer/free_blow5", after=5.0
    ),
    _set(
        "seismometer-small", _SEISMOMETER, "eddy-current brake: linear", frozenset(), "seismometer/free_q2", after=9.0
    ),
)

SETS: Mapping[str, MoreSet] = {s.name: s for s in _ALL}
