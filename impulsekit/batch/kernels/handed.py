"""Functions that kernels are handed by their address, compiled only where they are needed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba import types
from numba.core import sigutils
from numba.core.ccallback import CFunc
from numba.extending import typeof_impl

from ...laws.resolving import quick_compiler
from ...laws.store import Store
from .jit import CODE_OF_LANES

__all__ = ["Handed", "handed"]


class Handed(types.WrapperAddressProtocol):
    """A compiled function as kernels take it, its numba type at hand.

    numba makes out the type of a compiled function anew at every call, which costs as much as
    some hundred states do.
    """

    def __init__(self, made: Any, signature: Any) -> None:
        self._made, self._signature = made, signature
        self._is_compiled = False
        self.type = types.FunctionType(signature)

    def compile(self) -> None:
        """Have the code, compiled now or loaded from disk."""
        if not self._is_compiled:
            self._made.compile()
            self._is_compiled = True

    @property
    def is_there(self) -> bool:
        """Whether nothing would be compiled for it."""
        context = self._made._targetdescr.target_context
        return self._is_compiled or self._made._cache.holds(self._made._sig, context)

    def __wrapper_address__(self) -> int:
        """Where the code is."""
        self.compile()
        return self._made.address

    def signature(self) -> Any:
        """That of the function."""
        return self.type.signature


@typeof_impl.register(Handed)
def _typeof_handed(value: Handed, context: Any) -> Any:
    return value.type


def handed(signature: Any, function: Callable[..., None]) -> Handed:
    """The function for a signature, compiled when its address is asked for."""
    made = CFunc(
        function,
        sigutils.normalize_signature(signature),
        {},
        {"error_model": "numpy"},
        pipeline_class=quick_compiler(),
    )
    made._cache = Store(function, CODE_OF_LANES)
    return Handed(made, signature)
