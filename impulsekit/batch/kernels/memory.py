"""Lanes from arrays, and back into them.

Arrays of a kernel are flat. In the work array, whose numbers are those of the lanes, what
belongs together for all lanes is stored together: value k starts at ``k * width(witness)``.
The arrays that come from outside hold state after state; they are of doubles, and are
narrowed on the way where the lanes are.
"""

from __future__ import annotations

import math
from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from .lanes import FLAGS, LanesType, as_vector, lanes_of, llvm_unary

__all__ = ["collect", "collect_angle", "load", "put", "same", "store"]

TURN = 2.0 * math.pi
# What a double leaves of 2π.
TURN_REST = 2.4492935982947064e-16


def _pointer(context: Any, builder: Any, array_type: Any, array: Any, index: Any) -> Any:
    data = context.make_array(array_type)(context, builder, array).data
    return builder.gep(data, [index])


def _lane(number: int) -> Any:
    return ir.Constant(ir.IntType(32), number)


@intrinsic
def load(typingctx: Any, array: Any, index: Any, witness: Any) -> Any:
    """The value that starts at ``index`` of a flat array."""
    lanes = lanes_of(witness)

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        at = _pointer(context, builder, sig.args[0], args[0], args[1])
        if lanes is None:
            return builder.load(at, align=8)
        at = builder.bitcast(at, lanes.vector.as_pointer())
        return builder.load(at, align=lanes.element.bitwidth // 8)

    return (types.float64 if lanes is None else lanes)(array, types.int64, witness), codegen


@intrinsic
def store(typingctx: Any, array: Any, index: Any, value: Any) -> Any:
    """Write a value from ``index`` of a flat array on."""
    lanes = lanes_of(value)

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        at = _pointer(context, builder, sig.args[0], args[0], args[1])
        if lanes is not None:
            at = builder.bitcast(at, lanes.vector.as_pointer())
            builder.store(args[2], at, align=lanes.element.bitwidth // 8)
        else:
            builder.store(args[2], at, align=8)
        return context.get_dummy_value()

    return types.none(array, types.int64, value), codegen


def _collected(context: Any, builder: Any, sig: Any, args: Any, lanes: LanesType) -> Any:
    """Doubles out of an array as a vector."""
    array_value, at, step, _ = args
    found = ir.Constant(ir.VectorType(ir.DoubleType(), lanes.width), ir.Undefined)
    for lane in range(lanes.width):
        entry = builder.load(_pointer(context, builder, sig.args[0], array_value, at))
        found = builder.insert_element(found, entry, _lane(lane))
        at = builder.add(at, step)
    return found


@intrinsic
def collect(typingctx: Any, array: Any, index: Any, stride: Any, witness: Any) -> Any:
    """The entries ``index``, ``index + stride``, ... of a flat array, one a lane."""
    lanes = lanes_of(witness)

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        if lanes is None:
            return builder.load(_pointer(context, builder, sig.args[0], args[0], args[1]))
        found = _collected(context, builder, sig, args, lanes)
        return found if lanes.element == types.float64 else builder.fptrunc(found, lanes.vector)

    out = types.float64 if lanes is None else lanes
    return out(array, types.int64, types.int64, witness), codegen


@intrinsic
def collect_angle(typingctx: Any, array: Any, index: Any, stride: Any, witness: Any) -> Any:
    """``collect`` of angles. Before they lose digits, whole turns are taken from them."""
    lanes = lanes_of(witness)

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        if lanes is None:
            return builder.load(_pointer(context, builder, sig.args[0], args[0], args[1]))
        found = _collected(context, builder, sig, args, lanes)
        if lanes.element == types.float64:
            return found
        kind = found.type
        turns = builder.fmul(found, ir.Constant(kind, [1.0 / TURN] * lanes.width))
        turns = llvm_unary(builder, "rint", turns)
        for part in (TURN, TURN_REST):
            whole = builder.fmul(turns, ir.Constant(kind, [part] * lanes.width), flags=FLAGS)
            found = builder.fsub(found, whole, flags=FLAGS)
        return builder.fptrunc(found, lanes.vector)

    out = types.float64 if lanes is None else lanes
    return out(array, types.int64, types.int64, witness), codegen


@intrinsic
def put(typingctx: Any, array: Any, index: Any, stride: Any, value: Any) -> Any:
    """Write each lane to ``index``, ``index + stride``, ... of a flat array."""
    lanes = lanes_of(value)

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        array_value, at, step, value = args
        if lanes is None:
            builder.store(value, _pointer(context, builder, sig.args[0], array_value, at))
            return context.get_dummy_value()
        for lane in range(lanes.width):
            entry = builder.extract_element(value, _lane(lane))
            entry = context.cast(builder, entry, lanes.element, sig.args[0].dtype)
            builder.store(entry, _pointer(context, builder, sig.args[0], array_value, at))
            at = builder.add(at, step)
        return context.get_dummy_value()

    return types.none(array, types.int64, types.int64, value), codegen


@intrinsic
def same(typingctx: Any, number: Any, witness: Any) -> Any:
    """A number in all lanes."""
    lanes = lanes_of(witness)

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        if lanes is None:
            return args[0]
        return as_vector(context, builder, args[0], types.float64, lanes)

    return (types.float64 if lanes is None else lanes)(types.float64, witness), codegen
