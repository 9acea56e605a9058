"""The words of a ``Law`` as integers: restitution, slip, order; and the code of no answer."""

from __future__ import annotations

__all__ = ["AGAIN", "END", "NEWTON", "PATH", "POISSON", "SEQUENTIAL", "SIMULTANEOUS", "STRONGE"]

NEWTON, POISSON, STRONGE = 0, 1, 2
END, PATH = 0, 1
SIMULTANEOUS, SEQUENTIAL = 0, 1

# Beside the codes of ``Status``: the problem is left to a slower way.
AGAIN = -1
