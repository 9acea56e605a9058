"""What all tests share."""

from __future__ import annotations

from hypothesis import settings

# The same scenes on every run: a failure is a fault of the change at hand, not of the day.
settings.register_profile("seeded", derandomize=True)
settings.load_profile("seeded")
