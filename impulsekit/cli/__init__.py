"""The command ``impulsekit``. Answers go to stdout, diagnostics to stderr.

Exit status: 0 a valid answer; 1 an answer that is not; 2 input that cannot be used; 3 a
fault of impulsekit itself; 130 ended by Ctrl-C.
"""

from .main import main

__all__ = ["main"]
