"""The story of a diagnosis in chapters: the answer first, then what it rests on."""

from __future__ import annotations

from collections.abc import Sequence

from stepid.core.latex import parameter_name
from stepid.core.quantities import quantities_of
from stepid.core.words import capitalized, digits, length
from stepid.diagnosis.headline import answer, found_sizes
from stepid.diagnosis.result import Diagnosis
from stepid.diagnosis.text import (
    GAP_HEADER,
    gap_rows,
    next_steps,
    parameter_header,
    parameter_rows,
    ranking_header,
    ranking_rows,
    standing,
)
from stepid.diagnosis.wording import effect_names
from stepid.errors import IdentificationError
from stepid.report import captions
from stepid.report.chapter import Chapter, Table
from stepid.report.equation import equation
from stepid.report.hand import Hand, HandMethod, pictured, used_all_the_same
from stepid.report.provenance import Provenance
from stepid.report.pull import hand_method_rows
from stepid.report.tables import (
    characteristics_table,
    found_tables,
    phase_table,
    runs_table,
    system_table,
    verification_table,
)
from stepid.report.thin import MOST


def tell(d: Diagnosis, hand: Hand, provenance: Provenance) -> tuple[Chapter, ...]:
    """Tell what was measured, how the peak method and the linear fit fare, what is missing, and what next.

    Parameters
    ----------
    d : Diagnosis
    hand : HandMethod, IdentificationError or None
        From `stepid.report.hand.by_hand`.
    provenance : Provenance

    Returns
    -------
    tuple of Chapter
    """
    told = (
        _missing(d),
        _gap(d),
        _parameters(d, hand),
        _where(d),
        _next(d),
        _notes(d),
        *(_folded(one) for one in (_runs(d, hand), _by_hand(hand), _verification(d, hand), _provenance(provenance))),
    )
    return quantities_of(d).keeping(source.name for source in provenance.sources).result(told, words=True)


def _folded(chapter: Chapter) -> Chapter:
    return chapter.model_copy(update={"folded": True})


def _runs(d: Diagnosis, hand: Hand) -> Chapter:
    samples = sum(run.time.size for run in d.runs)
    return Chapter(
        name="runs",
        title="The runs",
        lead=f"{len(d.runs)} records of one plant, {samples} samples in all.",
        points=_left_out(d, hand),
        pictures=(captions.records(d),),
        tables=(runs_table(d),),
    )


def _left_out(d: Diagnosis, hand: Hand) -> tuple[str, ...]:
    """Which runs of the campaign the diagnosis does not rest on, and its notes that say why."""
    used = {run.name for run in d.runs}
    names = [run.name for run in d.data.experiments if run.name not in used] if d.data else []
    if not names:
        return ()
    said = f"Left out of the diagnosis and its pictures: {', '.join(names)}."
    still = used_all_the_same(d, hand.found) if isinstance(hand, HandMethod) else ""
    return (f"{said} {still}".rstrip(), *(note for note in d.notes if any(repr(name) in note for name in names)))


def _refusal(hand: IdentificationError | None) -> str:
    if hand is None:
        return "The diagnosis was made without its campaign at hand, so the peak method cannot be shown."
    return f"The peak method cannot use this campaign: {hand.cause}. {hand.remedy}".rstrip()


def _by_hand(hand: Hand) -> Chapter:
    if not isinstance(hand, HandMethod):
        return Chapter(name="by-hand", title="The peak method", lead=_refusal(hand))
    return Chapter(
        name="by-hand",
        title="The peak method",
        lead="The paper's way. From the first peak of each record come its damped frequency ω_d and damping ratio ζ. "
        "Each run gives a row m·ω_d² − k·(1 − ζ²) = 0 (Eq. 6), each known weight a row for a difference of masses "
        "(Eq. 9). "
        f"Stacked, they fix every mass and stiffness (Eq. 10); solved by {hand.found.solver or 'least squares'}.",
        tables=(
            characteristics_table(hand.system),
            system_table(hand.system, hand.found),
            *found_tables(hand.found),
        ),
    )


def _verification(d: Diagnosis, hand: Hand) -> Chapter:
    name, title = "verification", "Verification responses"
    if not isinstance(hand, HandMethod):
        return Chapter(name=name, title=title, lead="There are none without the peak method's models.")
    fits = [run.fit_percent for run in hand.verified.runs]
    return Chapter(
        name=name,
        title=title,
        lead="Each identified model, simulated on the input that was measured, against the record, as in the paper's "
        f"Figs. 3 and 6 to 8. The fit is {min(fits):.1f} to {max(fits):.1f} %; 100 % is perfect.",
        pictures=(captions.verification(shown),) if (shown := pictured(d, hand)) else (),
        tables=(verification_table(hand.verified),),
    )


def _where(d: Diagnosis) -> Chapter:
    times = f": {digits(d.gap.before / d.gap.noise)} times the noise" if d.gap.noise else ""
    return Chapter(
        name="where",
        title="Where they part",
        lead="No linear plant that is the same in all runs comes nearer than the one fitted to all of them. It leaves "
        f"{length(d.gap.before)} RMS where noise alone would leave {length(d.gap.noise)}{times}.",
        points=tuple(_sentence(s) for s in d.where.sentences),
        pictures=captions.where(d),
        tables=(phase_table(d),),
    )


def _sentence(words: str) -> str:
    return capitalized(words.rstrip(".")) + "."


def _missing(d: Diagnosis) -> Chapter:
    ranking = Table(caption="Candidates, best first", header=ranking_header(d), rows=tuple(ranking_rows(d)))
    said = answer(d)
    sizes = (f"{effect}: {name} {size}." for effect, name, size in found_sizes(d) if size not in said)
    return Chapter(
        name="missing",
        title="What is missing",
        lead=" ".join([said, *sizes]),
        points=(*d.reasons, *standing(d)),
        pictures=(captions.candidates(d),) if d.ranking else (),
        tables=(ranking,) if d.ranking else (),
    )


def _gap(d: Diagnosis) -> Chapter:
    if d.effects:
        lead = (
            f"The linear model leaves {length(d.gap.before)} RMS over all samples, the model with "
            f"{effect_names(d.effects)} {length(d.gap.after)}, noise {length(d.gap.noise)}."
        )
    elif d.gap.after != d.gap.before:
        lead = (
            f"No effect was added. The linear model leaves {length(d.gap.before)} RMS, with what the runs differ by "
            f"{length(d.gap.after)}, noise {length(d.gap.noise)}."
        )
    else:
        lead = f"Nothing was added: the linear model leaves {length(d.gap.before)} RMS, noise {length(d.gap.noise)}."
    if d.gap.held_out:
        before, after = map(length, d.gap.held_out)
        lead += (
            " On runs held out, each predicted by a fit that did not see it, the gap is "
            f"{before} before and {after} after."
        )
    return Chapter(
        name="gap",
        title="The gap, before and after",
        lead=lead,
        pictures=(captions.gap(d), *captions.ring_down(d), captions.gap_runs(d)),
        tables=(Table(caption="The gap by run", header=GAP_HEADER, rows=tuple(gap_rows(d))),),
    )


def _parameters(d: Diagnosis, hand: Hand) -> Chapter:
    tables = [
        Table(
            caption="The joint fit",
            header=parameter_header(d),
            words=(len(parameter_header(d)) - 1,),
            rows=_in_words(parameter_rows(d)),
        )
    ]
    if isinstance(hand, HandMethod):
        header, rows = hand_method_rows(d, hand.found)
        tables.append(
            Table(
                caption="The peak method beside it", header=header, rows=_in_words(rows), words=(header.index("unit"),)
            )
        )
    missing = f" Without {effect_names(d.effects)} the linear plant bends its own numbers to make up for it."
    return Chapter(
        name="parameters",
        title="Parameters",
        lead="Value ± standard uncertainty, of one fit to all runs together." + missing * bool(d.effects),
        points=equation(d),
        pictures=(captions.pull(d),) if d.effects else (),
        tables=tuple(tables),
    )


def _in_words(rows: Sequence[tuple[str, ...]]) -> tuple[tuple[str, ...], ...]:
    return tuple((parameter_name(name), *cells) for name, *cells in rows)


def _next(d: Diagnosis) -> Chapter:
    steps = next_steps(d)
    lead = "" if steps else "There is nothing to advise."
    title = (
        "What to measure next" if d.next_experiment and not (d.advice and d.verdict == "named") else "What to do next"
    )
    return Chapter(name="next", title=title, lead=lead, points=steps)


def _notes(d: Diagnosis) -> Chapter:
    thinned = [run.name for run in d.runs if run.time.size > MOST]
    said = list(d.notes)
    if thinned:
        said.append(
            f"The interactive pictures of {', '.join(thinned)} show at most {MOST} samples of a curve, those at its "
            "extremes included. The numbers, the tables and the printed pictures rest on all samples."
        )
    return Chapter(name="notes", title="Notes", lead="" if said else "None.", points=tuple(said))


def _provenance(provenance: Provenance) -> Chapter:
    what = "file" if provenance.of_files else "run (times, then positions, 64-bit)"
    sources = Table(
        caption="What was read",
        header=(what, "SHA-256"),
        words=(1,),
        rows=tuple((source.name, source.sha256) for source in provenance.sources),
    )
    versions = Table(caption="What computed it", header=("package", "version"), rows=provenance.versions, words=(1,))
    return Chapter(
        name="provenance", title="Provenance", lead=f"Written {provenance.written}.", tables=(sources, versions)
    )
