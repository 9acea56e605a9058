"""Threads of linear algebra, which commands set before numpy is loaded."""

from __future__ import annotations

import os

__all__ = ["one_thread_each"]


def one_thread_each() -> None:
    """Linear algebra on one thread, as Pinocchio's is: matrices are small, and threads that wait
    for work take the time of processes that have some. What the user has set stays."""
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(name, "1")
