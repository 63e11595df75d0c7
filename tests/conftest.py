"""Settings of all tests."""

from __future__ import annotations

from hypothesis import settings

# the first example of a property may compile the kernel, which takes seconds and says nothing about the property
settings.register_profile("stepid", deadline=None)
settings.load_profile("stepid")
