"""How the kernels are compiled: those that Python calls, and those built into them."""

from __future__ import annotations

from numba import njit

__all__ = ["built_in", "kernel"]

# Called from Python, without its lock.
kernel = njit(cache=True, nogil=True)
# Called by kernels alone: no doors for Python, which cost more to compile than some bodies.
built_in = njit(cache=True, nogil=True, no_cpython_wrapper=True, no_cfunc_wrapper=True)
