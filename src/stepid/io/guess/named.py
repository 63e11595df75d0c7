"""What the name of a file, sheet, folder or column says of a run."""

from __future__ import annotations

from stepid.io.guess.draft import ASSUMED, Draft, Found
from stepid.io.guess.file_names import FileName, plain_name


def named(draft: Draft, said: FileName, prefix: str | None) -> Draft:
    """Add what a name tells where nothing better has."""
    if draft.mass is None and draft.weights is None:
        mass = None if said.mass is None else Found(said.mass, "the name")
        draft = draft.having(mass=mass, weights=said.weights)
    if said.spring is not None and draft.spring.why == ASSUMED:
        draft = draft.having(spring=Found(said.spring, "the name"))
    if said.damper is not None and draft.damper.why == ASSUMED:
        draft = draft.having(damper=Found(said.damper, "the name"))
    if said.release and "input" not in draft.columns:
        draft = draft.having(release=True)
    if prefix is not None:
        single = draft.name == plain_name(draft.file.stem)
        draft = draft.having(name=prefix if single else f"{prefix}, {draft.name}")
    return draft
