"""The command line: thin, colored only on a terminal; exit status 0 done, 2 bad input."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import stepid  # what takes long to load is loaded by the command that needs it: completion and help are quick
from stepid.cli.bar import showing
from stepid.cli.init import init, read_records
from stepid.cli.page import app as page
from stepid.cli.plan import EXAMPLES, plan
from stepid.cli.said import Said, taking_answers
from stepid.cli.terminal import check_out, console, examples, showing_a_manifest
from stepid.errors import IdentificationError, StepidError

if TYPE_CHECKING:
    from stepid import Effort
    from stepid.core.experiment import Campaign
    from stepid.identification.parameters import IdentifiedParameters
    from stepid.report import Section

app = typer.Typer(
    name="stepid",
    help="Identify a mass-spring-damper from its step responses.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
)

CampaignFile = Annotated[
    Path, typer.Argument(metavar="CAMPAIGN.toml", help="The campaign's manifest, or its folder.", show_default=False)
]
Records = Annotated[
    list[Path],
    typer.Argument(
        metavar="CAMPAIGN.toml|FILES...",
        help="The campaign's manifest, or its folder, or recordings.",
        show_default=False,
    ),
]
Out = Annotated[
    Path | None, typer.Option("--out", metavar="DIR", help="Folder for report and figures.", show_default=False)
]
Outside = Annotated[
    bool, typer.Option("--allow-outside", metavar="", help="Read files outside of the manifest's folder, too.")
]
Json = Annotated[bool, typer.Option("--json", metavar="", help="Print JSON instead of text.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", metavar="", help="Show no progress on standard error.")]


class EffortName(StrEnum):
    """Presets of `stepid.Effort`, as the command line names them."""

    quick = "quick"
    default = "default"
    thorough = "thorough"


Hard = Annotated[
    EffortName, typer.Option("--effort", help="How hard to search: quick, default or thorough.", show_choices=False)
]
Parts = Annotated[
    int | None,
    typer.Option(
        "--parts", metavar="N", help="Cut each recording into so many runs: a long one, alone.", show_default=False
    ),
]


def _version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"stepid {stepid.__version__}")
        raise typer.Exit


@app.callback()
def _root(
    version: Annotated[
        bool, typer.Option("--version", help="Print the version and stop.", callback=_version, is_eager=True)
    ] = False,
) -> None:
    """Identify a mass-spring-damper from its step responses."""


@app.command(epilog=examples("stepid paper", "stepid paper --out out"))
def paper(out: Out = None, as_json: Json = False) -> None:
    """Rebuild Burchett's Table 2 and Eqs. 12 to 15 beside the printed ones, name the misprints, draw the figures."""
    from stepid.core.atomic_write import staged
    from stepid.report import as_text, paper_report
    from stepid.report.json_values import paper_values

    rebuilt = stepid.rebuild_paper()
    sections = paper_report(rebuilt)
    written: list[Path] = []
    if out is not None:
        from stepid import plot

        with staged(out) as folder:
            (folder / "paper.txt").write_text(as_text(sections), encoding="utf-8")
            for run in rebuilt.responses:
                upper, _ = plot.paper_figure(run)
                plot.save(upper, folder / f"{run.figure.lower().replace('. ', '-')}.png")
            written = sorted(out / path.name for path in folder.iterdir())
    if as_json:
        _print_json(paper_values(rebuilt))
    else:
        _show(sections, written)


@app.command(
    epilog=examples("stepid identify lab/campaign.toml --out results", "stepid identify lab/campaign.toml --json")
)
@showing_a_manifest
def identify(campaign: CampaignFile, out: Out = None, allow_outside: Outside = False, as_json: Json = False) -> None:
    """Find masses, stiffness and damping by the paper's method, and verify them against the records."""
    from stepid.core.atomic_write import staged
    from stepid.identification.identify import characterize_campaign
    from stepid.report import as_text, identify_report
    from stepid.report.file_names import file_names
    from stepid.report.json_values import identify_values

    check_out(out, "matplotlib")
    read = stepid.read_campaign(campaign, allow_outside=allow_outside)
    parameters = stepid.identify(read)
    verified = stepid.verify(parameters, read)
    trends = stepid.find_trends(characterize_campaign(read)[0].values())
    sections = identify_report(read, parameters, verified, trends)
    values = identify_values(read.name, parameters, verified)
    written: list[Path] = []
    if out is not None:
        from stepid import plot

        with staged(out) as folder:
            (folder / "report.txt").write_text(as_text(sections), encoding="utf-8")
            _write_json(folder / "parameters.json", values)
            plot.save(plot.verification_grid(verified)[0, 0], folder / "verification.png")
            for name, file in file_names(run.name for run in verified.runs).items():
                plot.save(plot.verification(verified[name])[0], folder / f"verification-{file}.png")
            if trends.trends:
                plot.save(plot.trends(trends)[0, 0], folder / "trends.png")
            written = sorted(out / path.name for path in folder.iterdir())
    if as_json:
        _print_json(values)
    else:
        _show(sections, written)


@app.command(
    epilog=examples(
        "stepid diagnose lab/campaign.toml --out results",
        "stepid diagnose lab/campaign.toml --effort quick --json",
        "stepid diagnose run*.csv --added-mass 0,0.5,1.5",
        "stepid diagnose decay.csv --step 0 --added-mass 0 --parts 3",
    )
)
@taking_answers
@showing_a_manifest
def diagnose(
    said: Said,
    campaign: Records,
    out: Out = None,
    effort: Hard = EffortName.default,
    parts: Parts = None,
    allow_outside: Outside = False,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Say whether a linear model is adequate, and if not, which effect is missing; show the gap before and after."""
    from stepid.core.atomic_write import staged
    from stepid.diagnosis.progress import stage_line
    from stepid.report import as_text, diagnosis_report
    from stepid.report.json_values import diagnosis_values
    from stepid.report.provenance import of_campaign
    from stepid.report.write import write_all

    check_out(out, "matplotlib", "jinja2", "plotly")
    read = read_records(campaign, said, allow_outside=allow_outside)
    if parts is not None:
        read = read.in_parts(parts)
    if not (quiet or as_json):
        console(stderr=True).print(_runs(read), markup=False)
    with showing(lines=not (quiet or as_json), bar=not quiet) as tell:
        found = stepid.diagnose(
            read,
            effort=_effort(effort),
            progress=lambda stage: tell(f"diagnosing: {stage_line(stage)}", stage.done, stage.left),
        )
        by_hand: IdentifiedParameters | StepidError
        try:
            by_hand = stepid.identify(found.data or read)  # with what was noted wrongly put right
        except IdentificationError as error:
            by_hand = error
        sections = diagnosis_report(found, by_hand)
    if as_json:  # before the report: what fails there does not take the search with it
        _print_json(diagnosis_values(found))
    else:
        _show(sections, ())
    if out is None:
        return
    with showing(lines=not (quiet or as_json), bar=not quiet) as tell:
        tell(f"writing {out}")
        from stepid import plot

        with staged(out) as folder:
            (folder / "diagnosis.txt").write_text(as_text(sections), encoding="utf-8")
            _write_json(folder / "diagnosis.json", found.to_dict())
            plot.save(plot.diagnosis(found)["gap"], folder / "diagnosis.png")
            write_all(found, of_campaign(read), folder)
            written = sorted(out / path.name for path in folder.iterdir())
    if not as_json:
        _show((), written)


app.command(epilog=examples("stepid init *.csv", "stepid init *.txt --added-mass 0,0.5,1.5 --counts-per-meter 56000"))(
    init
)
app.command(epilog=examples(*EXAMPLES))(plan)
app.command("app", epilog=examples("stepid app", "stepid app lab/campaign.toml --port 5006 --no-browser"))(page)


def _effort(name: EffortName) -> Effort:
    from stepid import Effort

    return Effort() if name == EffortName.default else getattr(Effort, name)()


def _runs(campaign: Campaign) -> str:
    """Say how the runs were understood: a release among steps is easily a forgotten input."""
    runs = campaign.experiments
    released = ", ".join(run.name for run in runs if run.is_release)
    return f"{campaign.name}: {len(runs)} run{'s' * (len(runs) > 1)}" + (
        f", free releases (no input): {released}" if released else ""
    )


def _write_json(path: Path, values: Any) -> None:
    path.write_text(json.dumps(values, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")


def _print_json(values: Any) -> None:
    typer.echo(json.dumps(values, indent=2, ensure_ascii=False))


def _show(sections: Iterable[Section], written: Sequence[Path]) -> None:
    screen = console()
    for section in sections:
        screen.print(section.title, style="bold", markup=False)
        screen.print(f"{section.body}\n", markup=False)
    for path in written:
        screen.print(f"wrote {path}", style="dim", markup=False)


def run(arguments: Sequence[str]) -> int:
    """Run one command.

    Parameters
    ----------
    arguments : sequence of str
        Without the program's name.

    Returns
    -------
    int
        Exit status: 0 done, 2 bad input (with one message on standard error).
    """
    try:
        app(args=list(arguments), prog_name="stepid", standalone_mode=True)
    except SystemExit as done:
        return done.code if isinstance(done.code, int) else int(done.code is not None)
    except StepidError as error:
        console(stderr=True).print(f"stepid: {error}", style="red", markup=False)
        return 2
    return 0
