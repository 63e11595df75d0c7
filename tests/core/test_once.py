"""Answers are computed once for each object, and forgotten with it."""

from __future__ import annotations

import gc
import weakref

from stepid.core.once import once


class Thing:
    def __init__(self, size: int) -> None:
        self.size = size

    def __eq__(self, other: object) -> bool:
        return True

    __hash__ = None  # type: ignore[assignment]


def test_each_object_and_each_argument_is_asked_once() -> None:
    asked = []

    @once
    def doubled(thing: Thing, more: int = 0) -> int:
        asked.append((thing.size, more))
        return 2 * thing.size + more

    one, other = Thing(1), Thing(2)
    assert [doubled(one), doubled(one), doubled(other), doubled(one, 5), doubled(one, 5)] == [2, 2, 4, 7, 7]
    assert asked == [(1, 0), (2, 0), (1, 5)]


def test_what_was_known_of_an_object_goes_with_it() -> None:
    """A new object in the old one's place in memory is asked anew."""

    @once
    def size(thing: Thing) -> int:
        return thing.size

    found = []
    for n in range(50):
        thing = Thing(n)
        found.append(size(thing))
        del thing
        gc.collect(0)
    assert found == list(range(50))


def test_what_is_its_own_answer_goes_as_well() -> None:
    @once
    def same(thing: Thing) -> Thing:
        return thing

    one = Thing(1)
    gone = weakref.ref(one)
    assert same(one) is same(one) is one
    del one
    gc.collect()
    assert gone() is None
