"""The rows of an impact and its mass matrix, with their derivatives by the configuration.

The core runs its tree and rows on numbers that carry their derivatives along the tangent of q; what
is differentiated is what ``solve`` takes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...errors import InputError
from ...scene import GapConstraint, GapContact
from ..flat.model import widest_core
from .meeting import touched_scene

if TYPE_CHECKING:
    from ..._core import DerivedRows
    from ...scene import Scene
    from ..flat.scene import FlatScene
    from ..outcome import Touch

__all__ = ["RowBlock", "StateRows"]


@dataclass(frozen=True, eq=False)
class RowBlock:
    """Rows of one entry or touching point.

    Attributes:
        matrix: (k, nv) G.
        by_q: (nv, k, nv) its derivative along each direction of the tangent of q.
        axes_by_q: (nv, 3, 3) likewise of a touching point's axes in the world; None of others.
    """

    matrix: np.ndarray
    by_q: np.ndarray
    axes_by_q: np.ndarray | None = None

    def change_of_velocity(self, v: np.ndarray) -> np.ndarray:
        """(k, nv) ∂(G v)/∂q."""
        return (self.by_q @ v).T

    def pull(self, impulse: np.ndarray) -> np.ndarray:
        """(nv, nv) ∂(Gᵀp)/∂q."""
        return np.matmul(impulse, self.by_q).T


class StateRows:
    """What the core differentiates of a scene at a state.

    Args:
        scene: of the impact. flat: it in the core. q: (nq,). touches: what touched.

    Attributes:
        masses: (nv, nv) M.
        blows: by known impulse of the scene, its rows: six in its own axes, or those of a joint.
        bilateral: by constraint.
        points: by touching point.

    Raises:
        InputError: rows that are functions of q, bodies that meet in ways without closed form.
    """

    def __init__(
        self, scene: Scene, flat: FlatScene, q: np.ndarray, touches: Sequence[Touch]
    ) -> None:
        contacts = [scene.contacts[touch.entry] for touch in touches]
        if any(isinstance(entry, GapConstraint | GapContact) for entry in (*scene.held, *contacts)):
            raise InputError(
                "derivatives of scenes with a GapConstraint or a GapContact are not available: "
                "they would take second derivatives of its functions"
            )
        found = _derived(scene, flat, q, touches)
        nv = scene.robot.nv
        self.masses = found.M.reshape(nv, nv)
        self._model, self._q = flat.model.core, q
        matrix, by_q = found.G.reshape(-1, nv), found.dG.reshape(nv, len(found.G) // max(nv, 1), nv)
        self.blows = [
            RowBlock(matrix[own], by_q[:, own]) for own in _places_of_impulses(scene, flat)
        ]
        at = len(flat.impulses)
        self.bilateral = [
            RowBlock(
                matrix[at + own.start : at + own.stop], by_q[:, at + own.start : at + own.stop]
            )
            for own in flat.slices
        ]
        at += len(flat.names)
        axes = found.daxes.reshape(nv, len(touches), 3, 3)
        self.points = [
            RowBlock(matrix[k : k + 3], by_q[:, k : k + 3], axes[:, i])
            for i, k in enumerate(range(at, at + 3 * len(touches), 3))
        ]

    def momentum_by_q(self, x: np.ndarray) -> np.ndarray:
        """(nv, nv) ∂(M x)/∂q."""
        by_q: np.ndarray = widest_core().momentum_by_q(self._model, self._q, np.array(x))
        return by_q.reshape(len(x), len(x)).T


def _derived(scene: Scene, flat: FlatScene, q: np.ndarray, touches: Sequence[Touch]) -> DerivedRows:
    entries = [touch.entry for touch in touches]
    derive_rows: Callable[..., DerivedRows] = widest_core().derive_rows
    if flat.shaped or flat.contact_functions:
        return derive_rows(touched_scene(scene, flat, q, touches), q, None)
    found = derive_rows(flat.core, q, None)
    if found.entries != entries:
        # In a motion some of the contacts take part.
        found = derive_rows(flat.core, q, [i in entries for i in range(len(scene.contacts))])
    return found


def _places_of_impulses(scene: Scene, flat: FlatScene) -> list[np.ndarray]:
    """By known impulse, where its rows stand: the core has those of blows first."""
    place = np.argsort(np.array(flat.order, dtype=int))
    sizes = [len(entry.values) for entry in scene.impulses]
    return np.split(place, np.cumsum(sizes)[:-1]) if sizes else []
