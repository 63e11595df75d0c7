"""Find where simulation and measurement disagree, name what is missing, add it, show the gap shrink."""

from stepid.diagnose.diagnosis import diagnose, diagnose_many

__all__ = ["diagnose", "diagnose_many"]
