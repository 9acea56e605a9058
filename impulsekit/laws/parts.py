"""Compiled functions that no one calls but compiled code.

numba optimizes each function with all that it calls, and makes machine code of it: a function ten
calls deep ten times. What only compiled code calls is kept as the compiler's intermediate code; it
is optimized, and made machine code, once with each ``entry`` that holds it.
"""

from __future__ import annotations

import functools
from typing import Any

__all__ = ["give_environments", "pipeline", "rebuilt"]

# What a stored library of intermediate code is called.
KIND = "part"


class _NoEngine:
    """numba's code generator for what is not made machine code."""

    def __init__(self, codegen: Any) -> None:
        self._codegen = codegen

    def __getattr__(self, name: str) -> Any:
        return getattr(self._codegen, name)

    def set_env(self, name: str, environment: Any) -> None:
        """Its globals are those of the code that it is built into."""


@functools.cache
def _library() -> Any:
    from llvmlite import binding
    from numba.core.codegen import JITCodeLibrary

    class Part(JITCodeLibrary):
        @property
        def codegen(self) -> Any:
            return _NoEngine(self._codegen)

        def get_pointer_to_function(self, name: str) -> int:
            self._ensure_finalized()
            return 0

        def _optimize_final_module(self) -> None:
            pass

        def _finalize_final_module(self) -> None:
            self._finalize_dynamic_globals()
            self._verify_declare_only_symbols()
            self._finalized = True

        def serialize_using_object_code(self) -> tuple[str, str, bytes]:
            self._ensure_finalized()
            return self.name, KIND, self._final_module.as_bitcode()

        @classmethod
        def read(cls, codegen: Any, name: str, code: bytes) -> Any:
            self = cls(codegen, name)
            self._final_module = binding.parse_bitcode(code)
            self._finalize_final_module()
            return self

    return Part


@functools.cache
def pipeline(compiler: Any) -> Any:
    """A compiler of numba's, for functions that only compiled code calls."""

    class PartCompiler(compiler):
        def define_pipelines(self) -> Any:
            if self.state.library is None:
                codegen = self.state.targetctx.codegen()
                self.state.library = _library()(codegen, self.state.func_id.func_qualname)
            return super().define_pipelines()

    return PartCompiler


def rebuilt(target_context: Any, packed: tuple[Any, ...]) -> Any:
    """numba's result of a compilation, from what was stored of it."""
    from numba.core import compiler

    (name, kind, code), fndesc, environment, signature, objectmode, lifted, *rest = packed
    if kind != KIND:
        return compiler.CompileResult._rebuild(target_context, *packed)
    annotation, reload_init, environments = rest
    library = _library().read(target_context.codegen(), name, code)
    return compiler.compile_result(
        target_context=target_context,
        typing_context=target_context.typing_context,
        library=library,
        environment=environment,
        entry_point=target_context.get_executable(library, fndesc, environment),
        fndesc=fndesc,
        type_annotation=annotation,
        signature=signature,
        objectmode=objectmode,
        lifted=lifted,
        typing_error=None,
        call_helper=None,
        metadata=None,
        reload_init=reload_init,
        referenced_envs=environments,
    )


def give_environments(compiled: Any) -> None:
    """Set the globals of the parts that are in new machine code, as numba does when it loads it."""
    # A callback's is not made machine code before; then its parts are not in it yet.
    compiled.library._ensure_finalized()
    for environment in compiled._find_referenced_environments():
        compiled.library.codegen.set_env(environment.env_name, environment)
