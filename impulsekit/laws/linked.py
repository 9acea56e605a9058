"""How numba compiles our functions: code that only compiled code calls is made once.

By itself numba turns every function into machine code, also those that only other compiled
functions call; these link its code, optimize it again and make machine code of it again. Here
what is within stays as numba's front end leaves it, and an entry links all that it reaches,
which is optimized and turned into machine code once for each entry.

References to arrays are counted only where an array is made: whoever passes one holds it.
"""

from __future__ import annotations

import pathlib
import pickle
from typing import Any

from llvmlite import binding
from numba.core import ir, types
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, CompileResult, DefaultPassBuilder
from numba.core.compiler_machinery import register_pass
from numba.core.environment import lookup_environment
from numba.core.typed_passes import DumpParforDiagnostics, InlineOverloads, NativeLowering
from numba.core.untyped_passes import (
    FindLiterallyCalls,
    InlineClosureLikes,
    InlineInlinables,
    LiteralPropagationSubPipelinePass,
    LiteralUnroll,
    MakeFunctionToJitFunction,
    WithLifting,
)

from .lookups import Lookups, QuickFlags

__all__ = ["EntryCompiler", "InnerCompiler", "InnerLibrary", "put_on_disk", "rebuild"]

# What marks a library within on disk.
KIND = "within"
# How names of the environments of functions begin.
ENVIRONMENT = "_ZN08NumbaEnv"
# What reads arrays without making any.
VIEWS = ("getattr", "static_getitem", "build_tuple", "exhaust_iter", "cast", "getiter", "phi")

# Passes for ``with``, for functions made in functions, for inlining by numba, for loops over tuples
# of several types and for diagnostics.
UNUSED = (
    WithLifting,
    InlineClosureLikes,
    MakeFunctionToJitFunction,
    InlineInlinables,
    FindLiterallyCalls,
    LiteralUnroll,
    LiteralPropagationSubPipelinePass,
    InlineOverloads,
    DumpParforDiagnostics,
)

# Signatures of operations by the flags of the compiler.
_signatures: dict[str, dict[Any, Any]] = {}
# Libraries within that were read from disk or put there, by their files.
_by_path: dict[pathlib.Path, InnerLibrary] = {}


class InnerLibrary(JITCodeLibrary):
    """The code of a function within: not optimized, no machine code.

    Attributes:
        path: its file, once it is on disk.
        held: what has to live as long as it does.
    """

    path: pathlib.Path | None = None
    held: Any = None

    def _optimize_functions(self, ll_module: Any) -> None:
        ll_module.data_layout = self._codegen._data_layout

    def finalize(self) -> None:
        """Link what is not within; that is left to entries."""
        self._raise_if_finalized()
        for library in dict.fromkeys(self._linking_libraries):
            self._reload_init.update(library._reload_init)
            if not isinstance(library, InnerLibrary):
                module = library._get_module_for_linking()
                self._final_module.link_in(module, preserve=True)
        self._finalize_dynamic_globals()
        if self._dynamic_globals:
            # Addresses of this process, which cannot be put on disk: mostly in code never reached.
            self._optimize_final_module()
            self._dynamic_globals.clear()
            self._finalize_dynamic_globals()
        self._finalized = True

    @property
    def within(self) -> list[InnerLibrary]:
        """The libraries within that it calls itself."""
        linked = dict.fromkeys(self._linking_libraries)
        return [library for library in linked if isinstance(library, InnerLibrary)]

    def own_module(self) -> Any:
        """Its code alone, to be linked into others."""
        return super()._get_module_for_linking()

    def _get_module_for_linking(self) -> Any:
        """Its code with all that it reaches, for what is not an ``EntryLibrary``."""
        module = self.own_module().clone()
        for library in reached(self.within):
            if library is not self:
                module.link_in(library.own_module(), preserve=True)
        return module

    def get_pointer_to_function(self, name: str) -> int:
        """None: Python cannot call it."""
        return 0

    def serialize_using_object_code(self) -> tuple[str, str, Any]:
        """What ``rebuild`` makes it of."""
        self._ensure_finalized()
        paths = [library.path for library in self.within]
        return self.name, KIND, (self.own_module().as_bitcode(), paths)


class EntryLibrary(JITCodeLibrary):
    """The code of an entry and of all that it reaches."""

    def finalize(self) -> None:
        """Link everything, optimize, and make machine code."""
        plain = [one for one in self._linking_libraries if not isinstance(one, InnerLibrary)]
        inner = [one for one in self._linking_libraries if isinstance(one, InnerLibrary)]
        for library in reached(inner):
            self._reload_init.update(library._reload_init)
            self._final_module.link_in(library.own_module(), preserve=True)
        self._linking_libraries = plain
        super().finalize()
        codegen: Any = self._codegen
        for variable in self._final_module.global_variables:
            if variable.name.startswith(ENVIRONMENT):
                environment = lookup_environment(variable.name)
                if environment is not None:
                    codegen.set_env(variable.name, environment)


def reached(libraries: list[InnerLibrary]) -> list[InnerLibrary]:
    """Libraries within, and those that they reach, each once."""
    found: dict[InnerLibrary, None] = {}
    waiting = list(libraries)
    while waiting:
        library = waiting.pop()
        if library not in found:
            found[library] = None
            waiting += library.within
    return list(found)


def _is_counted(state: Any, kind: Any) -> bool:
    return bool(state.targetctx.data_model_manager[kind].contains_nrt_meminfo())


def _is_plain_index(kind: Any) -> bool:
    if isinstance(kind, types.BaseTuple):
        parts: Any = kind
        return all(map(_is_plain_index, parts))
    return isinstance(kind, types.Integer | types.SliceType | types.NoneType | types.EllipsisType)


def _makes_arrays(state: Any) -> bool:
    """Whether a function makes or copies arrays, or may be given new ones by what it calls."""
    if _is_counted(state, state.return_type):
        return True
    for block in state.func_ir.blocks.values():
        for written in block.find_insts((ir.SetItem, ir.StaticSetItem)):
            if _is_counted(state, state.typemap[written.value.name]):
                return True
        for statement in block.find_insts(ir.Assign):
            if not _is_counted(state, state.typemap[statement.target.name]):
                continue
            value = statement.value
            if not isinstance(value, ir.Expr) or value.op in VIEWS:
                continue
            if value.op == "getitem" and _is_plain_index(state.typemap[value.index.name]):
                continue
            return True
    return False


class _Lowering(NativeLowering):
    library: type[JITCodeLibrary]

    def run_pass(self, state: Any) -> bool:
        target = state.targetctx
        if not _makes_arrays(state):
            target.enable_nrt = False
        state.library = self.library(target.codegen(), state.func_id.func_qualname)
        state.library.enable_object_caching()
        kept = type(target).get_executable

        def get_executable(library: Any, fndesc: Any, env: Any) -> Any:
            if isinstance(library, InnerLibrary):
                return _uncallable(library, fndesc, env)
            return kept(target, library, fndesc, env)

        target.get_executable = get_executable
        return bool(super().run_pass(state))


@register_pass(mutates_CFG=True, analysis_only=False)
class _EntryLowering(_Lowering):
    _name: Any = "lowering_of_entries"
    library = EntryLibrary


@register_pass(mutates_CFG=True, analysis_only=False)
class _InnerLowering(_Lowering):
    _name: Any = "lowering_within"
    library = InnerLibrary


def _uncallable(library: Any, fndesc: Any, env: Any) -> Any:
    """What stands for a function in Python that cannot be called from there."""
    from numba import _dynfunc  # type: ignore[attr-defined]

    library.held = env
    module, name = fndesc.lookup_module(), fndesc.qualname.rpartition(".")[2]
    return _dynfunc.make_function(module, name, "within compiled code", 0, env, (library,))


class _Compiler(CompilerBase):
    lowering: type[_Lowering]

    def __init__(self, typingctx: Any, targetctx: Any, library: Any, *rest: Any) -> None:
        super().__init__(typingctx, targetctx, library, *rest)
        flags = QuickFlags(self.state.flags)
        found = _signatures.setdefault(repr(sorted(flags.values().items())), {})
        self.state.flags, self.state.typingctx = flags, Lookups(typingctx, found)

    def define_pipelines(self) -> list[Any]:
        """numba's own, but for the last of it and what our functions have no use for."""
        manager = DefaultPassBuilder.define_nopython_pipeline(self.state)
        kept = [one for one in manager.passes if one[0] not in UNUSED]
        manager.passes = [
            (self.lowering, "lowering") if one[0] is NativeLowering else one for one in kept
        ]
        # What passes change each of them brings up to date itself.
        manager._ENFORCING = False
        manager.finalize()
        return [manager]


class EntryCompiler(_Compiler):
    """The compiler of what Python calls, or compiled code by its address."""

    lowering = _EntryLowering


class InnerCompiler(_Compiler):
    """The compiler of what only compiled code calls."""

    lowering = _InnerLowering


def rebuild(target_context: Any, reduced: tuple[Any, ...], path: pathlib.Path) -> Any:
    """numba's result of a compilation from what was put on disk."""
    libdata, fndesc, env, signature, objectmode, lifted, annotation, reload_init, envs = reduced
    result: Any = CompileResult
    if libdata[1] != KIND:
        return result._rebuild(target_context, *reduced)
    library = _by_path.get(path) or _read_library(target_context, libdata, path, env)
    return result(
        target_context=target_context,
        typing_context=target_context.typing_context,
        library=library,
        environment=env,
        entry_point=_uncallable(library, fndesc, env),
        fndesc=fndesc,
        type_annotation=annotation,
        signature=signature,
        objectmode=objectmode,
        lifted=lifted,
        typing_error=None,
        call_helper=None,
        metadata=None,
        reload_init=reload_init,
        referenced_envs=envs,
    )


def _read_library(target_context: Any, libdata: Any, path: pathlib.Path, env: Any) -> InnerLibrary:
    name, _, (bitcode, paths) = libdata
    library = InnerLibrary(target_context.codegen(), name)
    library._final_module = binding.parse_bitcode(bitcode)
    for other in paths:
        if other not in _by_path:
            reduced = pickle.loads(other.read_bytes()[32:])
            _read_library(target_context, reduced[0], other, reduced[2])
        library._linking_libraries.append(_by_path[other])
    library._finalize_dynamic_globals()
    library._finalized = True
    library.path, library.held = path, env
    _by_path[path] = library
    return library


def put_on_disk(library: InnerLibrary, path: pathlib.Path) -> None:
    """Note where a library stands."""
    library.path = path
    _by_path[path] = library
