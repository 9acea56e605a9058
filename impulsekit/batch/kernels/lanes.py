"""Lanes: several states side by side in one SIMD value, for numba.

A kernel is written once, in plain arithmetic on the values that ``memory.load`` gives. With
``LANES`` as its witness these are vectors of 8 doubles, one state each; with ``LANES32``
vectors of 16 single-precision floats; with ``SINGLE`` they are one double. LLVM makes the
widest registers of the machine of a vector. Sums and products may be contracted to fused
ones, and nothing else: a NaN stays in its lane and stays a NaN.
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
    "LANES32",
    "SINGLE",
    "LanesType",
    "Witness",
    "absolute",
    "any_less",
    "as_vector",
    "digits",
    "lanes_of",
    "root",
    "rounded",
    "where_less",
    "width",
]

SINGLE = 0.0
FLAGS = ("contract",)


class LanesType(types.Type):
    """The numba type of so many numbers of one kind, side by side."""

    def __init__(self, element: types.Float, width: int) -> None:
        self.element, self.width = element, width
        number = ir.DoubleType() if element == types.float64 else ir.FloatType()
        self.vector = ir.VectorType(number, width)
        super().__init__(name=f"Lanes{width}x{element.bitwidth}")


class WitnessType(types.Type):
    """The numba type of a witness, which holds nothing."""

    def __init__(self, lanes: LanesType) -> None:
        self.lanes = lanes
        super().__init__(name=f"Witness of {lanes.name}")


class Witness:
    """Stands for lanes where a kernel is called from Python.

    Attributes:
        type: of the witness in numba.
        width: how many states go side by side.
        number: "float64" or "float32".
    """

    def __init__(self, element: types.Float, width: int) -> None:
        self.type = WitnessType(LanesType(element, width))
        self.width, self.number = width, element.name


LANES = Witness(types.float64, 8)
LANES32 = Witness(types.float32, 16)


@register_model(LanesType)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, dmm: Any, fe_type: Any) -> None:
        super().__init__(dmm, fe_type, fe_type.vector)


register_model(WitnessType)(models.OpaqueModel)


@typeof_impl.register(Witness)
def _typeof_witness(value: Any, context: Any) -> WitnessType:
    return value.type


@unbox(WitnessType)
def _unbox_witness(typ: Any, obj: Any, c: Any) -> NativeValue:
    return NativeValue(c.context.get_dummy_value())


def lanes_of(*kinds: Any) -> LanesType | None:
    """The lanes that a witness or any of these types is of; None for single numbers."""
    for kind in kinds:
        if isinstance(kind, LanesType):
            return kind
        if isinstance(kind, WitnessType):
            return kind.lanes
    return None


def as_vector(context: Any, builder: Any, value: Any, typ: Any, lanes: LanesType) -> Any:
    """A value as a vector, a single number in all lanes."""
    if isinstance(typ, LanesType):
        return value
    value = context.cast(builder, value, typ, lanes.element)
    nothing = ir.Constant(lanes.vector, ir.Undefined)
    single = builder.insert_element(nothing, value, ir.Constant(ir.IntType(32), 0))
    mask = ir.Constant(ir.VectorType(ir.IntType(32), lanes.width), [0] * lanes.width)
    return builder.shuffle_vector(single, nothing, mask)


def _vectors(context: Any, builder: Any, args: Any, sig: Any, lanes: LanesType) -> list:
    """All arguments as vectors."""
    pairs = zip(args, sig.args, strict=True)
    return [as_vector(context, builder, value, kind, lanes) for value, kind in pairs]


def _add_operator(operation: Any, instruction: str) -> None:
    @infer_global(operation)
    class _Typing(AbstractTemplate):
        def generic(self, args: Any, kws: Any) -> Any:
            numbers = LanesType | types.Float | types.Integer
            lanes = next((a for a in args if isinstance(a, LanesType)), None)
            if lanes is not None and all(isinstance(a, numbers) for a in args):
                return signature(lanes, *args)
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
            pair = _vectors(context, builder, args, sig, sig.return_type)
            return getattr(builder, instruction)(*pair, flags=FLAGS)


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
            return signature(args[0], args[0])
        return None


@lower_builtin(operator.neg, LanesType)
def _lower_neg(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    return builder.fneg(args[0])


@intrinsic
def width(typingctx: Any, witness: Any) -> Any:
    """How many states a value holds."""
    lanes = lanes_of(witness)
    count = 1 if lanes is None else lanes.width

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return ir.Constant(ir.IntType(64), count)

    return types.int64(witness), codegen


@intrinsic
def digits(typingctx: Any, witness: Any) -> Any:
    """How many binary digits a number of a value has: 53 or 24."""
    lanes = lanes_of(witness)
    count = 53 if lanes is None or lanes.element == types.float64 else 24

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return ir.Constant(ir.IntType(64), count)

    return types.int64(witness), codegen


def llvm_unary(builder: Any, name: str, value: Any) -> Any:
    """A call of LLVM's own function of one number or vector."""
    kind = value.type
    single = kind.element if isinstance(kind, ir.VectorType) else kind
    suffix = "f64" if single == ir.DoubleType() else "f32"
    if isinstance(kind, ir.VectorType):
        suffix = f"v{kind.count}{suffix}"
    function = cgutils.get_or_insert_function(
        builder.module, ir.FunctionType(kind, [kind]), f"llvm.{name}.{suffix}"
    )
    return builder.call(function, [value])


def _unary(name: str, doc: str) -> Any:
    """An intrinsic that is an LLVM intrinsic of one argument."""

    def typing(typingctx: Any, value: Any) -> Any:
        def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            return llvm_unary(builder, name, args[0])

        return value(value), codegen

    typing.__doc__ = doc
    return intrinsic(typing)


root = _unary("sqrt", "The square root of each lane.")
absolute = _unary("fabs", "The size of each lane.")
rounded = _unary("rint", "Each lane rounded to a whole number.")


@intrinsic
def where_less(typingctx: Any, left: Any, right: Any, then: Any, otherwise: Any) -> Any:
    """``then`` where left < right, else ``otherwise``, lane by lane; a NaN is never less."""
    kinds = (left, right, then, otherwise)
    lanes = lanes_of(*kinds)

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        if lanes is not None:
            args = _vectors(context, builder, args, sig, lanes)
        less = builder.fcmp_ordered("<", args[0], args[1])
        return builder.select(less, args[2], args[3])

    return (types.float64 if lanes is None else lanes)(*kinds), codegen


@intrinsic
def any_less(typingctx: Any, left: Any, right: Any) -> Any:
    """Whether left < right in any lane."""
    lanes = lanes_of(left, right)

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        if lanes is None:
            return builder.fcmp_ordered("<", args[0], args[1])
        args = _vectors(context, builder, args, sig, lanes)
        bits = builder.bitcast(builder.fcmp_ordered("<", args[0], args[1]), ir.IntType(lanes.width))
        return builder.icmp_unsigned("!=", bits, ir.Constant(ir.IntType(lanes.width), 0))

    return types.boolean(left, right), codegen
