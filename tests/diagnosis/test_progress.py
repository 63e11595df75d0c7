"""What is told of a stage, in words."""

from __future__ import annotations

from stepid.diagnosis.progress import Progress, stage_line, stage_words


def test_names_are_put_into_words_and_sentences_are_left_alone() -> None:
    assert stage_words(Progress("coulomb_friction")) == "Coulomb friction"
    said = "linear model leaves 713 µm, noise 24.5 µm"
    assert stage_words(Progress(said)) == stage_line(Progress(said)) == said
