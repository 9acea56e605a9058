"""Exit statuses of the command, other than 0 and 1."""

from __future__ import annotations

__all__ = ["BAD_INPUT", "INTERRUPTED", "OWN_FAULT"]

BAD_INPUT = 2
OWN_FAULT = 3
# Of a command that Ctrl-C has ended, as shells have it.
INTERRUPTED = 130
