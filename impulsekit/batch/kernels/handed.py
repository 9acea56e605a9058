"""Functions that kernels are handed by their address, compiled only where they are needed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba import types
from numba.core import sigutils
from numba.core.ccallback import CFunc
from numba.extending import typeof_impl

from ...laws.store import Store
from .jit import CODE_OF_LANES

__all__ = ["Handed", "handed"]


class Handed(types.WrapperAddressProtocol):
    """A compiled function as kernels take it, its numba type at hand.

    numba makes out the type of a compiled function anew at every call, which costs as much as
    some hundred states do.
    """

    def __init__(self, compiled: Any, signature: Any) -> None:
        self._compiled = compiled
        self.type = types.FunctionType(signature)

    def __wrapper_address__(self) -> int:
        """Where the code is."""
        return self._compiled.address

    def signature(self) -> Any:
        """That of the function."""
        return self.type.signature


@typeof_impl.register(Handed)
def _typeof_handed(value: Handed, context: Any) -> Any:
    return value.type


def handed(signature: Any, function: Callable[..., None]) -> Handed:
    """The function compiled for a signature."""
    made = CFunc(function, sigutils.normalize_signature(signature), {}, {"error_model": "numpy"})
    made._cache = Store(function, CODE_OF_LANES)
    made.compile()
    return Handed(made, signature)
