"""How the kernels are compiled: those that Python calls, and those built into them.

Arrays belong to Python, which holds them while a kernel runs. Kernels of lanes do not count
who else does: numba's counting calls a function at every use, for which all that is in
registers is put down first. They can make no arrays of their own.
"""

from __future__ import annotations

import pathlib
from collections.abc import Callable
from typing import Any

from ...laws.compiled import OPTIONS, WITHIN, dispatcher, use_numba

__all__ = ["CODE_OF_LANES", "built_in", "inlined", "kernel"]

use_numba()

# What compiled code is made of where lanes occur; no function that calls it shows that.
CODE_OF_LANES = "".join(
    pathlib.Path(__file__).with_name(name).read_text() for name in ("lanes.py", "memory.py")
)


def _with(**options: Any) -> Callable[[Callable[..., Any]], Any]:
    return lambda function: dispatcher(function, options, CODE_OF_LANES)


# Called from Python, without its lock.
kernel = _with(**OPTIONS, _nrt=False)
# On lanes: part of the kernel, so that values stay in registers from one to the next.
inlined = _with(**WITHIN, _nrt=False, forceinline=True)
# On numbers, one state after the other; these may make arrays.
built_in = _with(**WITHIN)
