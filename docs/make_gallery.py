"""Make the gallery of the effects: its pictures and its page. Run with ``python docs/make_gallery.py``."""

from __future__ import annotations

import re
import sys
from io import BytesIO
from pathlib import Path
from typing import NamedTuple

import matplotlib as mpl
import numpy as np
from matplotlib import pyplot as plt
from matplotlib.figure import Figure
from PIL import Image

import stepid
from stepid.diagnosis.locate import locate
from stepid.diagnosis.result import Where
from stepid.diagnosis.shape_in_motion import of_the_linear_plant
from stepid.diagnosis.wording import effect_names, length
from stepid.effects import CATALOGUE, Effect, resolve
from stepid.fitting.fit import prepare
from stepid.plot.layout import new_figure, stacked_axes
from stepid.plot.style import MODEL, OTHER, SERIES, styled
from stepid.plot.style import PAGE as PAGE_WIDTH

DOCS = Path(__file__).parent
PAGE, PICTURES = DOCS / "gallery.md", DOCS / "_static" / "gallery"
BEGIN, END = "<!-- gallery: made by docs/make_gallery.py -->\n", "<!-- end of gallery -->\n"

MASS, STIFFNESS, DAMPING, GAIN = 0.95, 216.0, 4.0, 7.8  # kg, N/m, N·s/m, N/V
PERIOD, COUNTS, NOISE = 0.0088542, 226600.0, 8e-6  # s, counts/m, m
RUNS = ((0.0, 0.5), (0.5, 0.5), (1.5, 0.5), (0.5, -0.5), (0.5, 0.25))  # added kg, V; the first is shown
SIZES: dict[str, tuple[float, ...]] = {  # exaggerated, so that one sees them
    "coulomb_friction": (0.4,),
    "load_proportional_friction": (0.04,),
    "stribeck_friction": (0.15, 0.7, 0.06),
    "asymmetric_friction": (0.15, 0.5),
    "presliding_hysteresis": (0.4, 1e-3),
    "quadratic_damping": (40.0,),
    "power_damping": (0.8, 0.4),
    "position_dependent_damping": (-20.0,),
    "cubic_stiffness": (3e5,),
    "quadratic_stiffness": (-1600.0,),
    "sine_stiffness": (30.0,),
    "free_play": (0.0015,),
    "end_stop": (3000.0, 0.024),
    "viscoelastic_spring": (80.0, 20.0),
    "flexible_coupling": (0.3, 150.0, 0.3),
    "actuator_lag": (0.05,),
    "input_delay": (0.04,),
    "actuator_dead_zone": (0.1,),
    "actuator_saturation": (0.4,),
    "actuator_rate_limit": (3.0,),
    "periodic_disturbance": (0.3, 4.0),
    "cogging": (0.5, 0.012, 1.0),
    "sensor_drift": (1.5e-3,),
}
GROUPS = {  # module of stepid.effects: title, what its formula stands for
    "friction": ("Dry friction", "A force against the motion that does not vanish with the speed; added to the plant."),
    "damping": ("Damping", "A force against the motion that is no multiple of the speed; added to the plant."),
    "stiffness": ("Springs", "A force of the position that is no multiple of it; added to the plant."),
    "structure": ("Structure", "States that one mass on one spring has not; the force is added to the plant."),
    "drive": (
        "Drive and surroundings",
        "With $K_f$, it stands in the place of $K_f u$; else it is added to the plant.",
    ),
    "sensing": ("Sensor", "The plant is linear; the reading $y$ is not its position."),
}


class Shown(NamedTuple):
    """One effect in one plant: the run with it and without it, and the residual of the best linear fit."""

    time: np.ndarray
    record: np.ndarray
    without: np.ndarray
    residual: np.ndarray
    where: Where
    gap: str


def campaign() -> stepid.Campaign:
    """Inputs, times and labels; the positions are still to be simulated."""
    runs = []
    for i, (added, volts) in enumerate(RUNS):
        inputs = np.repeat([0.0, volts, 0.0], [6, 220, 220])
        time = PERIOD * np.arange(inputs.size)
        fields = {"added_mass": added, "spring": "medium", "damper": "1/2 turn", "counts_per_meter": COUNTS}
        runs.append(stepid.Experiment(name=f"run {i + 1}", time=time, position=0 * time, input=inputs, **fields))
    return stepid.Campaign(name="gallery", experiments=tuple(runs))


def model(effect: Effect | None) -> stepid.PlantModel:
    """The plant of the gallery, with an effect or linear."""
    effects = ()
    phases: dict[str, float] = {}
    if effect is not None:
        values = dict(zip([q.name for q in effect.parameters], SIZES[effect.name], strict=True))
        effects = (stepid.EffectModel(name=effect.name, values=values),)
        phases = {f"{effect.name}.{q.name}": 0.7 for q in effect.run_parameters}
    return stepid.PlantModel(
        base_mass={"cart": MASS},
        stiffness={"medium": STIFFNESS},
        damping={"1/2 turn": DAMPING},
        force_gain=GAIN,
        effects=effects,
        runs={f"run {i + 1}": stepid.RunState(phases=phases) for i in range(len(RUNS))},
    )


def show(effect: Effect) -> Shown:
    """Simulate with the effect, add noise, round to counts, fit the best linear plant, and see what it leaves."""
    plain = campaign()
    clean, without = stepid.simulate(model(effect), plain), stepid.simulate(model(None), plain)
    rng = np.random.default_rng(20050401)
    runs = []
    for run in plain.experiments:
        noisy = clean[run.name] + NOISE * rng.standard_normal(run.time.size)
        runs.append(run.model_copy(update={"position": np.round(noisy * COUNTS) / COUNTS}))
    context = prepare(stepid.Campaign(name="gallery", experiments=tuple(runs)))
    records = context.records
    where = locate(records, context.linear, context.floor, otherwise=lambda: of_the_linear_plant(context))
    residual = context.linear.residual[records.pieces()[0]]
    gap = f"{length(context.linear.rms)} beside {length(context.floor)} of noise"
    return Shown(runs[0].time, runs[0].position, without["run 1"], residual, where, gap)


def write(figure: Figure, path: Path) -> None:
    """Write a PNG with a palette of few colors: a third of the size."""
    whole = BytesIO()
    figure.savefig(whole, dpi=130)
    Image.open(whole).convert("RGB").quantize(48, dither=Image.Dither.NONE).save(path, optimize=True)


def draw(effect: Effect, shown: Shown) -> None:
    """Write the picture and the icon of one effect."""
    PICTURES.mkdir(parents=True, exist_ok=True)
    with styled():
        figure = new_figure(width=PAGE_WIDTH, height=2.2)
        left, middle, right = figure.add_gridspec(1, 3, width_ratios=(1.5, 1, 1))
        record, below = stacked_axes(figure, left, ratio=2.2)
        record.plot(shown.time, 1e3 * shown.without, "--", color=OTHER, linewidth=1.0, label="without")
        record.plot(shown.time, 1e3 * shown.record, "-", color=MODEL, linewidth=0.9, label="with")
        record.set(ylabel="position [mm]", title=title(effect.name))
        record.legend(loc="upper right")
        below.plot(shown.time, 1e3 * shown.residual, "-", color=SERIES[0], linewidth=0.9)
        below.set(xlabel="time [s]", ylabel="residual\n[mm]")
        velocity = figure.add_subplot(middle)
        position = figure.add_subplot(right, sharey=velocity)
        stepid.plot.force_against_velocity(shown.where, axes=velocity)
        stepid.plot.force_against_position(shown.where, axes=position)
        position.set_ylabel("")
        write(figure, PICTURES / f"{effect.name}.png")
        figure = new_figure(width=1.5, height=0.9)
        icon = figure.subplots()
        icon.plot(shown.time, shown.without, "--", color=OTHER, linewidth=0.8)
        icon.plot(shown.time, shown.record, "-", color=MODEL, linewidth=1.0)
        icon.axis("off")
        write(figure, PICTURES / f"{effect.name}-icon.png")
    plt.close("all")


def anchor(name: str) -> str:
    return f"effect-{name.replace('_', '-')}"


def title(name: str) -> str:
    words = effect_names([name])
    return words[0].upper() + words[1:]


def entry(effect: Effect, residual: str) -> str:
    """Everything that the page says about one effect; `residual` is what its residual force looks like, in words."""
    doc = " ".join((type(effect).__doc__ or "").split("\n\n")[0].split())
    values = (*SIZES[effect.name], *(0.7 for _ in effect.run_parameters))
    quantities = []
    for q, symbol, value in zip((*effect.parameters, *effect.run_parameters), effect.symbols, values, strict=True):
        own = " of each run" if q in effect.run_parameters else ""
        quantities.append(f"${symbol}$ = `{q.name}`{own} ({value:g} {q.unit})".replace(" )", ")"))
    lines = [
        f"({anchor(effect.name)})=",
        f"### {title(effect.name)}",
        "",
        doc,
        "",
        f"$${effect.formula}$$",
        "",
        f"![{title(effect.name)}: record, residual, residual force](_static/gallery/{effect.name}.png)",
        "",
        f"- **In the code**: `{effect.name}`; {', '.join(quantities)}.",
        f"- **In a record**: {effect.seen}.",
        f"- **In the residual**: {residual}.",
        f"- **In the lab**: {effect.advice}.",
    ]
    if effect.contains:
        inner = " and ".join(f"[{effect_names([name])}](#{anchor(name)})" for name in effect.contains)
        lines.append(f"- **Contains** {inner}, and is not named where the data cannot tell the two apart.")
    return "\n".join(lines) + "\n"


def body(residuals: dict[str, str]) -> str:
    """The part of the page that is made: a grid of icons, then the effects by group."""
    lines = ["::::{grid} 2 3 4 5", ":gutter: 2", ""]
    for effect in CATALOGUE:
        lines += [
            f":::{{grid-item-card}} {title(effect.name)}",
            f":img-bottom: _static/gallery/{effect.name}-icon.png",
            f":link: {anchor(effect.name)}",
            ":link-type: ref",
            ":text-align: center",
            ":::",
        ]
    lines += ["::::", ""]
    for module, (heading, words) in GROUPS.items():
        lines += [f"## {heading}", "", words, ""]
        lines += [entry(e, residuals[e.name]) for e in CATALOGUE if type(e).__module__.endswith(f".{module}")]
    return "\n".join(lines)


def page(text: str, residuals: dict[str, str]) -> str:
    """The page with the gallery put between its marks."""
    before, rest = text.split(BEGIN)
    return before + BEGIN + body(residuals) + END + rest.split(END)[1]


def residuals_on(text: str) -> dict[str, str]:
    """What a page says about the residual of each effect, by name."""
    names = re.findall(r"^- \*\*In the code\*\*: `(\w+)`", text, re.MULTILINE)
    said = re.findall(r"^- \*\*In the residual\*\*: (.*)\.$", text, re.MULTILINE)
    return dict(zip(names, said, strict=True))


def words(shown: Shown) -> str:
    """What the diagnosis would say about the residual of the linear fit."""
    return f"{shown.gap}; {shown.where.sentences[-1]}"


def main() -> None:
    mpl.use("Agg")
    text = PAGE.read_text(encoding="utf-8")
    named = resolve(sys.argv[1:])
    residuals = residuals_on(text) if named else {}
    for effect in named or CATALOGUE:
        shown = show(effect)
        draw(effect, shown)
        residuals[effect.name] = words(shown)
        print(f"{effect.name}: {residuals[effect.name]}")
    PAGE.write_text(page(text, residuals), encoding="utf-8")


if __name__ == "__main__":
    main()
