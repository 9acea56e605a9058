"""``Differentiable``: a scene's impacts as a function of arrays, for frameworks that differentiate.

Gradients by the configuration are taken from its tangent to the entries of q, for q of which
quaternions, and cosines with sines, are brought to unit length first.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from .._core import slopes_by_entries, unit_parts
from ..errors import InputError
from .derivatives import VARIED, derivatives_batch, vjp
from .inputs import batch_inputs
from .program import program_of

if TYPE_CHECKING:
    from ..scene import Scene

__all__ = ["Differentiable", "Leaf", "leaves_of"]

# By which parameter of ``vjp`` an argument is differentiated.
_BY = {"points": "at", "masses": "mass"}


@dataclass(frozen=True)
class Leaf:
    """One array among the parameters.

    Attributes:
        argument: of ``solve_batch``. name: the entry, of a mapping; None of an array alone.
        scalar: whether a row has one number.
    """

    argument: str
    name: str | None
    scalar: bool


def leaves_of(parameters: Mapping[str, Any]) -> tuple[list[Leaf], list[Any]]:
    """Return the arrays among the parameters, and what each is.

    Raises:
        InputError: no such parameter.
    """
    leaves, arrays = [], []
    for argument, value in parameters.items():
        if argument not in VARIED:
            raise InputError(f'no parameter "{argument}"; parameters are {", ".join(VARIED)}')
        for name, own in value.items() if isinstance(value, Mapping) else ((None, value),):
            scalar = argument == "masses" or (
                argument in ("restitution", "friction") and name is not None
            )
            leaves.append(Leaf(argument, name, scalar))
            arrays.append(own)
    return leaves, arrays


class Differentiable:
    """v⁺ of a scene as a function of q, v and parameters, each (B, …), in float64.

    Args:
        scene: the scene. leaves: what the parameters are.

    Attributes:
        nv: of the robot.
    """

    def __init__(self, scene: Scene, leaves: Sequence[Leaf], threads: int | None = None) -> None:
        self._scene, self._leaves, self._threads = scene, tuple(leaves), threads
        self.nv = scene.robot.nv
        self._model = program_of(scene).flat.model.core
        self._units = [slice(i, i + count) for i, count in unit_parts(self._model)]

    def solve(self, arrays: Sequence[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
        """(B, nv) v⁺, NaN in rows without an impact, and (B,) whether derivatives exist."""
        q, v, varied = self._given(arrays)
        found = derivatives_batch(
            self._scene, self.unit(q), v, of=(), by=(), threads=self._threads, **varied
        )
        return found.impacts.v_after, found.exists

    def shapes(self, given: Sequence[tuple[int, ...]]) -> list[tuple[tuple[int, ...], int]]:
        """By array the shape with the leading axes of all, and how many axes are its own.

        Raises:
            InputError: leading axes that do not go together.
            ShapeError, UnknownNameError: an array whose own axes, or whose name, the scene lacks.
        """
        bases = [1, 1, *(0 if leaf.scalar else 1 for leaf in self._leaves)]
        own = [shape[len(shape) - base :] for shape, base in zip(given, bases, strict=True)]
        count = len(self._scene.contacts)
        for i, leaf in enumerate(self._leaves, 2):
            # One number for all contacts.
            if leaf.argument in ("restitution", "friction") and given[i] == ():
                own[i] = (count,) if not leaf.scalar else ()
        leads = [s[: max(len(s) - base, 0)] for s, base in zip(given, bases, strict=True)]
        try:
            lead = np.broadcast_shapes(*leads)
        except ValueError:
            raise InputError(f"leading axes do not go together: {leads}") from None
        # Frameworks wrap what a callback raises in errors of their own: one row of these shapes,
        # with numbers that are fine, is checked before.
        row = [np.ones((1, *shape)) for shape in own]
        if own[0] == (self._scene.robot.nq,):
            row[0] = self._scene.robot.neutral()[None]
        row_q, row_v, varied = self._given(row)
        batch_inputs(self._scene, row_q, row_v, **varied)
        return [((*lead, *o), base) for o, base in zip(own, bases, strict=True)]

    def pull(
        self, arrays: Sequence[np.ndarray], cotangent: np.ndarray | Mapping[str, np.ndarray]
    ) -> list[np.ndarray]:
        """Return the gradients by all arrays, 0 in rows that have none; as ``vjp`` takes them."""
        q, v, varied = self._given(arrays)
        q = self.unit(q)
        by = {leaf.argument for leaf in self._leaves}
        kinds = ("q", "v", *(_BY.get(name, name) for name in by))
        found = vjp(self._scene, q, v, cotangent, by=kinds, threads=self._threads, **varied)
        table = {kind: np.nan_to_num(found[kind], nan=0.0) for kind in kinds}
        gradients = [self.by_entries(arrays[0], q, table["q"]), table["v"]]
        for leaf, array in zip(self._leaves, arrays[2:], strict=True):
            own = table[_BY.get(leaf.argument, leaf.argument)]
            gradients.append(self._part(leaf, own, found.links, array).reshape(array.shape))
        return gradients

    def _given(self, arrays: Sequence[np.ndarray]) -> tuple[np.ndarray, np.ndarray, dict[str, Any]]:
        varied: dict[str, Any] = {}
        for leaf, array in zip(self._leaves, arrays[2:], strict=True):
            if leaf.name is None:
                varied[leaf.argument] = array
            else:
                varied.setdefault(leaf.argument, {})[leaf.name] = array
        return arrays[0], arrays[1], varied

    def _part(
        self, leaf: Leaf, table: np.ndarray, links: Sequence[str], array: np.ndarray
    ) -> np.ndarray:
        """The columns of one array among those of its kind."""
        scene = self._scene
        if leaf.argument == "masses":
            return table[:, list(links).index(str(leaf.name))]
        if leaf.argument == "impulses":
            start = 0
            for name, entry in zip(scene.entry_names("impulses"), scene.impulses, strict=True):
                if leaf.name in (None, name):
                    return table[:, start : start + array.shape[1]]
                start += len(entry.values)
        if leaf.name is None:
            return table
        return table[:, scene.entry_names("contacts").index(leaf.name)]

    def unit(self, q: np.ndarray) -> np.ndarray:
        """Return q with its unit vectors of unit length."""
        q = np.array(q)
        for where in self._units:
            q[:, where] /= np.linalg.norm(q[:, where], axis=1, keepdims=True)
        return q

    def by_entries(self, given: np.ndarray, q: np.ndarray, slopes: np.ndarray) -> np.ndarray:
        """Return (B, nq) of slopes (B, nv), at q of unit length."""
        found = slopes_by_entries(self._model, q, np.ascontiguousarray(slopes)).reshape(q.shape)
        for where in self._units:
            found[:, where] /= np.linalg.norm(given[:, where], axis=1, keepdims=True)
        return found
