"""What labs call their columns, files and notes: words to practice on, and others that are held out."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Words:
    """Pools to draw from; `{m}` stands for a mass in kg, `{g}` in g, `{n}` for weights, `{i}` for the run's number."""

    time: tuple[str, ...]
    position: tuple[str, ...]
    input: tuple[str, ...]
    beside: tuple[str, ...]  # columns that are none of the three
    unit_styles: tuple[str, ...]
    preamble: tuple[str, ...]
    mass_line: tuple[str, ...]
    mass_files: tuple[str, ...]
    weight_files: tuple[str, ...]
    plain_files: tuple[str, ...]
    side_styles: tuple[str, ...]
    springs: tuple[tuple[str, str], ...]  # in a file's name, and the label


PRACTICE = Words(
    time=("t", "time", "Time", "Zeit", "temps", "tempo", "elapsed"),
    position=("x", "position", "Pos", "Weg", "displacement", "Encoder", "posizione"),
    input=("u", "voltage", "Spannung", "input", "motor", "tension"),
    beside=("velocity", "setpoint", "status", "n", "Kommentar"),
    unit_styles=("{name}_{unit}", "{name} [{unit}]", "{name} ({unit})", "{name} / {unit}"),
    preamble=(
        "Mass spring damper lab",
        "Datum: 12.03.2021",
        "Operator: Müller, Gruppe 7",
        "date;2022-11-03",
        "Sample rate: 100 Hz",
        "Channels: 3",
    ),
    mass_line=("Added mass: {m} kg", "Zusatzmasse = {m} kg", "mass: {g} g"),
    mass_files=("step_{m}kg", "{m}kg", "run{i}_{g}g", "Messung_{m}_kg", "m{m}kg_trial{i}"),
    weight_files=("{n}mass", "{n}_masses", "{n}weights_run{i}"),
    plain_files=("case_{i}", "run{i}", "Messung {i}", "data_{i}"),
    side_styles=("{name} {i}", "{name}{i}", "run {i} {name}", "case {i} {name}"),
    springs=(("soft", "soft"), ("medium", "medium"), ("stiff", "stiff")),
)

HELD_OUT = Words(
    time=("TIME", "Zeitpunkt", "tiempo", "timestamp", "Elapsed time", "tid"),
    position=("deflection", "Position der Masse", "spostamento", "cart_pos", "Auslenkung", "y", "enc1"),
    input=("Motor voltage", "u_in", "Eingang", "V_motor", "control", "command"),
    beside=("v", "reference", "comment", "sample", "accel"),
    unit_styles=("{name}({unit})", "{name}, {unit}", "{name} in {unit}", "{name}[{unit}]"),
    preamble=(
        "Überschrift: Feder-Masse-Dämpfer",
        "Lab 4 - second order systems",
        "File created 3/4/2019 10:22:51",
        "Interval,0.01",
        "DAQ: NI USB-6009",
        "Versuch Nr. 3",
    ),
    mass_line=("# extra mass {m} kg", "Load: {g} g", "Masse supplémentaire: {m} kg"),
    mass_files=("{g}gram", "Step response {m} kg", "plus{m}kg", "exp{i}-m{m}kg", "add_{g}g_v2"),
    weight_files=("{n}wts", "with_{n}_weights", "{n} mass pieces"),
    plain_files=("trial-{i}", "exp{i}", "Versuch{i}", "test_2_{i}"),
    side_styles=("{name}_{i}", "{i} {name}", "test {i} - {name}", "{name} (run {i})"),
    springs=(("softspring", "soft"), ("spring_hard", "hard"), ("weak", "weak")),
)
