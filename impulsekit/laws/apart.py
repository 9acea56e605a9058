"""Entries that compiled code calls by their address.

What compiled code calls is otherwise linked into it, and optimized again with every caller. An
entry that is ``apart`` is compiled once, and only when it is first reached: its callers look up
its address, and where there is none yet they have Python compile it. Should that fail or be
interrupted, the call returns zeros: an error cannot pass through compiled code. It waits, and who
called compiled code from Python raises it behind the call.
"""

from __future__ import annotations

import ctypes
import functools
import threading
import typing
from collections.abc import Callable
from typing import Any

__all__ = ["failed", "raise_failed", "tell_by_address"]

# The name of ``_compile`` for the linker; with the name of an entry behind it, of its address.
SYMBOL = "impulsekit_compile"

# By where the address of an entry stands: what compiles it and gives that address.
_compilers: dict[int, Callable[[], int]] = {}
# Memory that compiled code reads.
_addresses: list[Any] = []
# By thread: what ended a compilation that its compiled code asked for, until it is raised.
failed: dict[int, BaseException] = {}


def _compile(where: int) -> None:
    """Compile the entry whose address is to stand there. Compiled code calls this."""
    thread = threading.get_ident()
    if thread in failed:
        return
    try:
        ctypes.c_int64.from_address(where).value = _compilers[where]()
    except BaseException as error:
        failed[thread] = error


def raise_failed() -> None:
    """Raise what ended a compilation in this thread: do not use what its compiled code returned."""
    error = failed.pop(threading.get_ident(), None)
    if error is not None:
        raise error


# Python's lock is taken for the call.
_compiler = ctypes.CFUNCTYPE(None, ctypes.c_int64)(_compile)


@functools.cache
def _tell_of_compiler() -> None:
    from llvmlite import binding

    binding.add_symbol(SYMBOL, ctypes.cast(_compiler, ctypes.c_void_p).value)


def tell_by_address(entry: Any, examples: tuple[Any, ...], compile_it: Callable[[], Any]) -> None:
    """Let compiled code call an entry by its address.

    Args:
        entry: a global, whose ``py_func`` returns int, float, bool or a tuple of these.
        examples: arguments.
        compile_it: gives numba's dispatcher, compiled for these.
    """
    from llvmlite import binding
    from numba import typeof, types
    from numba.core.registry import cpu_target
    from numba.core.typing.templates import ConcreteTemplate

    function = entry.py_func
    signature = _numba_type(typing.get_type_hints(function)["return"])(*map(typeof, examples))

    def compiled_address() -> int:
        (made,) = compile_it().overloads.values()
        if made.signature.return_type != signature.return_type:
            raise TypeError(f"{function.__name__} returns {made.signature.return_type}")
        return int(made.library.get_pointer_to_function(made.fndesc.llvm_cfunc_wrapper_name))

    _tell_of_compiler()
    address = ctypes.c_int64(0)
    _addresses.append(address)
    where = ctypes.addressof(address)
    _compilers[where] = compiled_address
    name = f"{SYMBOL}.{function.__module__}.{function.__name__}"
    binding.add_symbol(name, where)

    class Template(ConcreteTemplate):
        key = entry
        cases: typing.ClassVar = [signature]

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return _call(context, builder, sig, args, name)

    cpu_target.typing_context.insert_global(entry, types.Function(Template))
    cpu_target.target_context.insert_func_defn([(lower, entry, signature.args)])


def _numba_type(hint: Any) -> Any:
    from numba import types

    if typing.get_origin(hint) is tuple:
        return types.BaseTuple.from_types([_numba_type(part) for part in typing.get_args(hint)])
    return {int: types.int64, float: types.float64, bool: types.boolean}[hint]


def _call(context: Any, builder: Any, sig: Any, args: Any, name: str) -> Any:
    """The code of one call: look up the address, have it compiled if there is none, and go."""
    from llvmlite import ir
    from numba.core import cgutils

    whole = ir.IntType(64)
    module = builder.module
    where = module.globals.get(name) or ir.GlobalVariable(module, whole, name)
    compiler = cgutils.get_or_insert_function(
        module, ir.FunctionType(ir.VoidType(), [whole]), SYMBOL
    )
    returned = context.get_value_type(sig.return_type)
    kind = ir.FunctionType(returned, [context.get_value_type(arg) for arg in sig.args])
    with builder.if_then(builder.icmp_unsigned("==", builder.load(where), whole(0)), likely=False):
        builder.call(compiler, [builder.ptrtoint(where, whole)])
    address = builder.load(where)
    result = cgutils.alloca_once_value(builder, ir.Constant(returned, None))
    with builder.if_then(builder.icmp_unsigned("!=", address, whole(0)), likely=True):
        found = builder.call(builder.inttoptr(address, kind.as_pointer()), args)
        builder.store(found, result)
    return builder.load(result)
