"""Turning points of a made-up decay."""

from __future__ import annotations


def losing(count: int) -> tuple[list[float], list[float]]:
    """Ranges D' = 0.9 D − 1 mm from 20 mm on, and how far from rest the turning points between them are, m."""
    ranges = [0.02]
    while len(ranges) < count:
        ranges.append(0.9 * ranges[-1] - 1e-3)
    sizes = [0.011]
    for one in ranges:
        sizes.append(one - sizes[-1])
    return ranges, sizes
