"""Words of a column's name: what names a quantity, and what only says what moves or reads."""

from __future__ import annotations

import pytest

from stepid.io.guess.words import role_of


@pytest.mark.parametrize(
    ("name", "role"),
    [
        ("Time (s) good cart run #1", "time"),
        ("Position (m) good cart run #1", "position"),
        ("Voltage cart (V)", "input"),
        ("Force sensor (N)", "input"),
        ("time_encoder", "time"),
        ("cart", "position"),
        ("laser", "position"),
        ("sensor voltage (V)", "position"),  # its reading
        ("cart position voltage", "position"),
    ],
)
def test_what_moves_or_reads_is_named_beside_another_quantity(name: str, role: str) -> None:
    assert role_of(name) == role
