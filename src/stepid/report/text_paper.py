"""The text of `stepid paper`."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from stepid.core.tables import text_table
from stepid.datasets.replication import PRINTED_STIFFNESS, PaperRebuild
from stepid.identification.transfer import transfer_function
from stepid.report.section import Section


def paper_report(paper: PaperRebuild) -> tuple[Section, ...]:
    """Write the paper's result, rebuilt beside printed.

    Parameters
    ----------
    paper : PaperRebuild
        From `stepid.rebuild_paper`.

    Returns
    -------
    tuple of Section
    """
    return (
        Section(title="The paper", body=_ABOUT),
        Section(title="The system that is solved", body=paper.system.summary()),
        Section(title="Table 2, rebuilt beside printed", body=_table_2(paper)),
        Section(title="Transfer functions (Eqs. 12 to 15)", body=_transfer_functions(paper)),
        Section(title="What the row weights do", body=_weights(paper)),
        Section(title="Misprints", body=_misprints(paper)),
    )


_ABOUT = """\
B. T. Burchett, Parametric Time Domain System Identification of a Mass-Spring-Damper System,
Rose-Hulman Institute of Technology. Its raw records are not published: the four runs' peak times and
damping ratios are recovered from Table 2, which then has to come out of Eq. 10 again."""


def _table_2(paper: PaperRebuild) -> str:
    found = paper.parameters
    rows = [
        (
            case.name,
            f"{found.masses[case.name]:.4f}",
            f"{case.mass:.4f}",
            f"{found.damping[case.name]:.2f}",
            f"{found.damping_from_stiffness[case.name]:.2f}",
            f"{case.damping:.2f}",
            f"{found.static_gain[case.name]:.5f}",
            f"{case.static_gain:.5f}",
        )
        for case in paper.printed
    ]
    header = (
        "",
        "mass [kg]",
        "printed [kg]",
        "2ζmω_d/√(1−ζ²) [N·s/m]",
        "2ζk√(1−ζ²)/ω_d [N·s/m]",
        "printed [N·s/m]",
        "K [m/V]",
        "printed [m/V]",
    )
    (stiffness,) = found.stiffness.values()
    stiff = f"stiffness {stiffness:.2f} N/m, printed {PRINTED_STIFFNESS:.1f} N/m"
    return f"{text_table(header, rows)}\n\n{stiff}\nThe paper prints K in cm/V: 3.618 there is 0.03618 m/V here."


def _transfer_functions(paper: PaperRebuild) -> str:
    rows, drawn = [], []
    for case in paper.printed:
        system = transfer_function(paper.parameters, case.name)
        (gain,), (second, first, _) = system.num_array[0, 0], system.den_array[0, 0]
        note = "" if case.second_order == case.second_order_corrected else f" ({case.second_order:g}: misprint)"
        rows.append(
            (
                f"{case.equation}, {case.name}",
                f"{gain:.5f}",
                f"{second:.6f}",
                f"{case.second_order_corrected:g}{note}",
                f"{first:.5f}",
                f"{case.first_order:g}",
            )
        )
        drawn.append(_indent(str(system)))
    header = ("", "K [m/V]", "m/k [s²]", "printed [s²]", "c/k [s]", "printed [s]")
    return "\n\n".join([text_table(header, rows), "As python-control systems, from V to m:", *drawn])


def _indent(text: str) -> str:
    return "\n".join(f"    {line}".rstrip() for line in text.strip("\n").splitlines())


def _weights(paper: PaperRebuild) -> str:
    names = [case.name for case in paper.printed]
    solves = (
        ("the paper's, time in seconds", paper.parameters.masses),
        ("the paper's, time in milliseconds", paper.in_milliseconds),
        ("weighted by uncertainty, any unit", paper.weighted.masses),
    )
    rows = [(what, *(f"{masses[n]:.4f}" for n in names), _steps([masses[n] for n in names])) for what, masses in solves]
    header = ("solve", *(f"{name} [kg]" for name in names), "steps [kg] (known: 0.5, 1.0, 0.5)")
    (stiffness,) = paper.weighted.stiffness.values()
    return (
        "Eq. 10 mixes rows in N/m and rows in kg. Without weights the unit of time decides which of them count.\n\n"
        f"{text_table(header, rows)}\n\nstiffness by the weighted solve {stiffness:.2f} N/m"
    )


def _steps(masses: Sequence[float]) -> str:
    return ", ".join(f"{b - a:.3f}" for a, b in pairwise(masses))


def _misprints(paper: PaperRebuild) -> str:
    rows = [(m.where, m.printed, m.correct, m.shows) for m in paper.misprints]
    header = ("where", "printed", "correct", "how it shows")
    widths = [max(len(row[i]) for row in (header, *rows)) for i in range(4)]
    lines = ["  ".join(cell.ljust(w) for cell, w in zip(row, widths, strict=True)).rstrip() for row in (header, *rows)]
    return "\n".join([lines[0], "  ".join("-" * w for w in widths), *lines[1:]])
