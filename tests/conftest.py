"""Settings of all tests."""

from __future__ import annotations

import os

from hypothesis import settings

# the first example of a property may compile the kernel, which takes seconds and says nothing about the property
settings.register_profile("stepid", deadline=None)
# a run that decides what lands draws the same examples every time; new ones are drawn by those who develop
settings.register_profile("integration", deadline=None, derandomize=True)
settings.load_profile("integration" if os.environ.get("CI") else "stepid")
