"""How the kernels are compiled: those that Python calls, and those built into them.

Arrays belong to Python, which holds them while a kernel runs. Kernels of lanes do not count
who else does: numba's counting calls a function at every use, for which all that is in
registers is put down first. They can make no arrays of their own.
"""

from __future__ import annotations

from numba import njit

__all__ = ["built_in", "inlined", "kernel"]

# What is divided by zero is no number: an error could not leave a function that is called by
# its address, and states would be left as they were.
_PLAIN = {"cache": True, "nogil": True, "error_model": "numpy"}
# Called by kernels alone: no doors for Python, which cost more to compile than some bodies.
_WITHIN = {**_PLAIN, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}

# Called from Python, without its lock.
kernel = njit(**_PLAIN, _nrt=False)
# On lanes: part of the kernel, so that values stay in registers from one to the next.
inlined = njit(**_WITHIN, _nrt=False, forceinline=True)
# On numbers, one state after the other; these may make arrays.
built_in = njit(**_WITHIN)
