"""Settings of all tests."""

from __future__ import annotations

import os

import pytest
from hypothesis import settings

import compiling

# the first example of a property may compile the kernel, which takes seconds and says nothing about the property
settings.register_profile("stepid", deadline=None)
# a run that decides what lands draws the same examples every time; new ones are drawn by those who develop
settings.register_profile("integration", deadline=None, derandomize=True)
settings.load_profile("integration" if os.environ.get("CI") else "stepid")


def pytest_configure(config: pytest.Config) -> None:
    compiling.start(config)


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    compiling.wait_for_it(config, items)
