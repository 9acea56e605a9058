"""What all tests share."""

from __future__ import annotations

import sys

import pytest
from hypothesis import settings

from .view.browser import browser

# The same scenes on every run: a failure is a fault of the change at hand, not of the day.
settings.register_profile("seeded", derandomize=True)
settings.load_profile("seeded")


@pytest.fixture(scope="session")
def session_browser():
    """One browser for all tests of pages: a process can drive no second one."""
    with browser() as opened:
        yield opened


@pytest.fixture(autouse=True)
def closed_figures():
    """Figures that a test leaves open are closed: pyplot warns of more than twenty."""
    yield
    if "matplotlib.pyplot" in sys.modules:
        sys.modules["matplotlib.pyplot"].close("all")
