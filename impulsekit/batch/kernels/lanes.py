"""``Lanes``: several states side by side in one SIMD value, for numba.

A kernel is written once, in plain arithmetic on the values that ``load`` gives. With
``LANES`` as its witness these are vectors of ``WIDTH`` doubles, one state each; with
``SINGLE`` they are single floats. LLVM makes the widest registers of the machine of a
vector. Sums and products may be contracted to fused ones, and nothing else: a NaN stays
in its lane and stays a NaN.

Arrays of a kernel are flat. What belongs together for all lanes is stored together:
field k starts at ``k * width(witness)``.
"""

from __future__ import annotations

import operator
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import (
    NativeValue,
    intrinsic,
    lower_builtin,
    models,
    register_model,
    typeof_impl,
    unbox,
)

__all__ = [
    "LANES",
    "SINGLE",
    "WIDTH",
    "absolute",
    "any_less",
    "collect",
    "load",
    "put",
    "root",
    "rounded",
    "same",
    "store",
    "where_less",
    "width",
]

WIDTH = 8
SINGLE = 0.0
_FLAGS = ("contract",)
_VECTOR = ir.VectorType(ir.DoubleType(), WIDTH)


class LanesType(types.Type):
    """The numba type of ``WIDTH`` doubles."""

    def __init__(self) -> None:
        super().__init__(name=f"Lanes{WIDTH}")


lanes_type = LanesType()


class _Witness:
    """Stands for ``Lanes`` where a kernel is called from Python."""


LANES = _Witness()


class WitnessType(types.Type):
    """The numba type of ``LANES``, which holds nothing."""

    def __init__(self) -> None:
        super().__init__(name=f"LanesWitness{WIDTH}")


witness_type = WitnessType()


@register_model(LanesType)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, dmm: Any, fe_type: Any) -> None:
        super().__init__(dmm, fe_type, _VECTOR)


register_model(WitnessType)(models.OpaqueModel)


@typeof_impl.register(_Witness)
def _typeof_witness(value: Any, context: Any) -> WitnessType:
    return witness_type


@unbox(WitnessType)
def _unbox_witness(typ: Any, obj: Any, c: Any) -> NativeValue:
    return NativeValue(c.context.get_dummy_value())


def _vector_of(context: Any, builder: Any, value: Any, typ: Any) -> Any:
    """A value as a vector, a single number in all lanes."""
    if isinstance(typ, LanesType):
        return value
    value = context.cast(builder, value, typ, types.float64)
    single = builder.insert_element(
        ir.Constant(_VECTOR, ir.Undefined), value, ir.Constant(ir.IntType(32), 0)
    )
    mask = ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), [0] * WIDTH)
    return builder.shuffle_vector(single, ir.Constant(_VECTOR, ir.Undefined), mask)


def _vectors_of(context: Any, builder: Any, args: Any, sig: Any) -> list:
    """All arguments as vectors."""
    pairs = zip(args, sig.args, strict=True)
    return [_vector_of(context, builder, value, kind) for value, kind in pairs]


def _add_operator(operation: Any, instruction: str) -> None:
    @infer_global(operation)
    class _Typing(AbstractTemplate):
        def generic(self, args: Any, kws: Any) -> Any:
            numbers = LanesType | types.Float | types.Integer
            if any(isinstance(a, LanesType) for a in args) and all(
                isinstance(a, numbers) for a in args
            ):
                return signature(lanes_type, *args)
            return None

    for left, right in (
        (LanesType, LanesType),
        (LanesType, types.Float),
        (types.Float, LanesType),
        (LanesType, types.Integer),
        (types.Integer, LanesType),
    ):

        @lower_builtin(operation, left, right)
        def _lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            pair = [
                _vector_of(context, builder, *both) for both in zip(args, sig.args, strict=False)
            ]
            return getattr(builder, instruction)(*pair, flags=_FLAGS)


for _operation, _instruction in (
    (operator.add, "fadd"),
    (operator.sub, "fsub"),
    (operator.mul, "fmul"),
    (operator.truediv, "fdiv"),
):
    _add_operator(_operation, _instruction)


@infer_global(operator.neg)
class _NegTyping(AbstractTemplate):
    def generic(self, args: Any, kws: Any) -> Any:
        if isinstance(args[0], LanesType):
            return signature(lanes_type, lanes_type)
        return None


@lower_builtin(operator.neg, LanesType)
def _lower_neg(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    return builder.fneg(args[0])


def _pointer(context: Any, builder: Any, array_type: Any, array: Any, index: Any) -> Any:
    data = context.make_array(array_type)(context, builder, array).data
    return builder.gep(data, [index])


def _is_vector(witness: Any) -> bool:
    return isinstance(witness, LanesType | WitnessType)


@intrinsic
def width(typingctx: Any, witness: Any) -> Any:
    """How many states a value holds."""
    count = WIDTH if _is_vector(witness) else 1

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return ir.Constant(ir.IntType(64), count)

    return types.int64(witness), codegen


@intrinsic
def load(typingctx: Any, array: Any, index: Any, witness: Any) -> Any:
    """The value that starts at ``index`` of a flat array."""
    vector = _is_vector(witness)

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        at = _pointer(context, builder, sig.args[0], args[0], args[1])
        if vector:
            at = builder.bitcast(at, _VECTOR.as_pointer())
        return builder.load(at, align=8)

    return (lanes_type if vector else types.float64)(array, types.int64, witness), codegen


@intrinsic
def store(typingctx: Any, array: Any, index: Any, value: Any) -> Any:
    """Write a value from ``index`` of a flat array on."""

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        at = _pointer(context, builder, sig.args[0], args[0], args[1])
        if isinstance(sig.args[2], LanesType):
            at = builder.bitcast(at, _VECTOR.as_pointer())
        builder.store(args[2], at, align=8)
        return context.get_dummy_value()

    return types.none(array, types.int64, value), codegen


@intrinsic
def collect(typingctx: Any, array: Any, index: Any, stride: Any, witness: Any) -> Any:
    """The entries ``index``, ``index + stride``, ... of a flat array, one a lane."""
    vector = _is_vector(witness)

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        array_value, at, step, _ = args
        if not vector:
            return builder.load(_pointer(context, builder, sig.args[0], array_value, at))
        found = ir.Constant(_VECTOR, ir.Undefined)
        for lane in range(WIDTH):
            entry = builder.load(_pointer(context, builder, sig.args[0], array_value, at))
            found = builder.insert_element(found, entry, ir.Constant(ir.IntType(32), lane))
            at = builder.add(at, step)
        return found

    out = lanes_type if vector else types.float64
    return out(array, types.int64, types.int64, witness), codegen


@intrinsic
def put(typingctx: Any, array: Any, index: Any, stride: Any, value: Any) -> Any:
    """Write each lane to ``index``, ``index + stride``, ... of a flat array."""

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        array_value, at, step, value = args
        if isinstance(sig.args[3], LanesType):
            for lane in range(WIDTH):
                entry = builder.extract_element(value, ir.Constant(ir.IntType(32), lane))
                builder.store(entry, _pointer(context, builder, sig.args[0], array_value, at))
                at = builder.add(at, step)
        else:
            builder.store(value, _pointer(context, builder, sig.args[0], array_value, at))
        return context.get_dummy_value()

    return types.none(array, types.int64, types.int64, value), codegen


@intrinsic
def same(typingctx: Any, number: Any, witness: Any) -> Any:
    """A number in all lanes."""
    vector = _is_vector(witness)

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        if not vector:
            return args[0]
        return _vector_of(context, builder, args[0], types.float64)

    return (lanes_type if vector else types.float64)(types.float64, witness), codegen


def _unary(name: str, doc: str) -> Any:
    """An intrinsic that is an LLVM intrinsic of one argument."""

    def typing(typingctx: Any, value: Any) -> Any:
        def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            kind = args[0].type
            function = cgutils.get_or_insert_function(
                builder.module,
                ir.FunctionType(kind, [kind]),
                f"llvm.{name}." + (f"v{WIDTH}f64" if isinstance(kind, ir.VectorType) else "f64"),
            )
            return builder.call(function, args)

        return value(value), codegen

    typing.__doc__ = doc
    return intrinsic(typing)


root = _unary("sqrt", "The square root of each lane.")
absolute = _unary("fabs", "The size of each lane.")
rounded = _unary("rint", "Each lane rounded to a whole number.")


@intrinsic
def where_less(typingctx: Any, left: Any, right: Any, then: Any, otherwise: Any) -> Any:
    """``then`` where left < right, else ``otherwise``, lane by lane; a NaN is never less."""

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        if isinstance(sig.return_type, LanesType):
            args = [
                _vector_of(context, builder, *both) for both in zip(args, sig.args, strict=False)
            ]
        less = builder.fcmp_ordered("<", args[0], args[1])
        return builder.select(less, args[2], args[3])

    kinds = (left, right, then, otherwise)
    out = lanes_type if any(isinstance(k, LanesType) for k in kinds) else types.float64
    return out(*kinds), codegen


@intrinsic
def any_less(typingctx: Any, left: Any, right: Any) -> Any:
    """Whether left < right in any lane."""

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        if any(isinstance(kind, LanesType) for kind in sig.args):
            args = [
                _vector_of(context, builder, *both) for both in zip(args, sig.args, strict=False)
            ]
            less = builder.fcmp_ordered("<", args[0], args[1])
            bits = builder.bitcast(less, ir.IntType(WIDTH))
            return builder.icmp_unsigned("!=", bits, ir.Constant(ir.IntType(WIDTH), 0))
        return builder.fcmp_ordered("<", args[0], args[1])

    return types.boolean(left, right), codegen
