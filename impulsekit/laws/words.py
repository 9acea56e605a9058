"""The words of a ``Law`` as integers: restitution, slip, order."""

from __future__ import annotations

__all__ = ["END", "NEWTON", "PATH", "POISSON", "SEQUENTIAL", "SIMULTANEOUS", "STRONGE"]

NEWTON, POISSON, STRONGE = 0, 1, 2
END, PATH = 0, 1
SIMULTANEOUS, SEQUENTIAL = 0, 1
