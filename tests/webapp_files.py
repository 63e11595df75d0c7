"""Files as somebody would drop them on the page."""

from __future__ import annotations

import math

PLANT = {"stiffness": 300.0, "damping": 4.0, "base": 1.0}


def recording(added: float, *, units: bool = True, samples: int = 300) -> bytes:
    """A step response of a plant with a spring of 300 N/m and 1 kg, as a CSV with decimal commas."""
    mass = PLANT["base"] + added
    half = PLANT["damping"] / (2 * mass)
    swing = math.sqrt(PLANT["stiffness"] / mass - half**2)
    rows = ["Zeit [ms];Weg [mm];Spannung [V]" if units else "t;weg;u"]
    for n in range(samples):
        t = 0.01 * n
        x = 8 * (1 - math.exp(-half * t) * (math.cos(swing * t) + half / swing * math.sin(swing * t)))
        rows.append(f"{10 * n if units else t};{x:.4f};0,5".replace(".", ","))
    return ("\n".join(rows) + "\n").encode("cp1252")


def three(*, named: bool = True) -> dict[str, bytes]:
    """Recordings of three masses, in their names or not."""
    names = [f"medium_{kg}kg.csv" if named else f"run {i + 1}.csv" for i, kg in enumerate((0.0, 0.5, 1.0))]
    return dict(zip(names, map(recording, (0.0, 0.5, 1.0)), strict=True))
