"""How the kernels are compiled: those that Python calls, and those built into them.

Arrays belong to Python, which holds them while a kernel runs. Kernels of lanes make none and do
not count who else holds them, as ``laws.borrowed`` says: before every call that counts, all that
is in registers would be put down.
"""

from __future__ import annotations

import pathlib
from collections.abc import Callable
from typing import Any

from ...laws.borrowed import UNCOUNTED
from ...laws.compiled import OPTIONS, WITHIN, dispatcher, use_numba

__all__ = ["CODE_OF_LANES", "built_in", "inlined", "kernel", "uncounted"]

use_numba()

# What compiled code is made of where lanes occur; no function that calls it shows that.
CODE_OF_LANES = "".join(
    pathlib.Path(__file__).with_name(name).read_text() for name in ("lanes.py", "memory.py")
)


def _with(**options: Any) -> Callable[[Callable[..., Any]], Any]:
    return lambda function: dispatcher(function, options, CODE_OF_LANES)


# Called from Python, without its lock.
kernel = _with(**{**OPTIONS, **UNCOUNTED})
# On lanes: part of the kernel, so that values stay in registers from one to the next.
inlined = _with(**{**WITHIN, **UNCOUNTED}, forceinline=True)
# On numbers, one state after the other; these may make arrays.
built_in = _with(**WITHIN)
# Likewise, where neither they nor what they call make any, and none are returned.
uncounted = _with(**{**WITHIN, **UNCOUNTED})
