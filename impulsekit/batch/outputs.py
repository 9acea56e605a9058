"""``ImpactOutputs``: results of many impacts and their derivatives by the state (q, v).

Each result is an array (B, columns, rows), that is a matrix (rows, columns) of each state column
after column, as planners lay matrices out.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InputError, UnknownNameError, check_kind
from ..impact.derivatives.loads import JointLoadSlopes, joint_load_slopes, refuse_loads
from ..impact.derivatives.refusals import refuse_what_has_none
from ..impact.derivatives.status import DerivativeStatus
from ..impact.flat.model import flat_model_of
from ..scene import Scene
from .derivatives import BatchDerivatives, derivatives_batch, vjp
from .solve import solve_batch

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = ["OUTPUTS", "ImpactOutputs"]

OUTPUTS = ("v_after", "contact_impulses", "joint_loads")


class ImpactOutputs:
    """Results of a scene's impacts as functions of (q, v), on the tangent of q.

    Args:
        scene: with at least one contact or constraint. outputs: some of ``OUTPUTS``.
        what: the function that a user called, for messages.

    Attributes:
        shapes: by output the rows and columns for one state.
        statuses: how many derivatives were taken with which status.

    Raises:
        UnknownNameError: no such output. InputError: a scene without contacts and constraints, or
            one that ``derivatives`` refuses.
    """

    def __init__(self, scene: Scene, outputs: Sequence[str], what: str) -> None:
        check_kind(scene, Scene, what)
        outputs = (outputs,) if isinstance(outputs, str) else tuple(outputs)
        for name in outputs:
            if name not in OUTPUTS:
                raise UnknownNameError.among("output", str(name), OUTPUTS)
        if not (scene.contacts or scene.held):
            raise InputError(
                f"{what}: the scene has no contacts and no constraints, so no state leads to an "
                "impact; give Scene(contacts=[...])"
            )
        if not outputs or ("contact_impulses" in outputs and not scene.contacts):
            raise InputError(
                f"{what}: outputs must name at least one result that the scene has, got {outputs}"
            )
        refuse_what_has_none(scene)
        if "joint_loads" in outputs:
            refuse_loads(scene)
        self.scene, self.outputs = scene, outputs
        joints = scene.robot.model.njoints - 1
        shapes = {
            "v_after": (scene.robot.nv, 1),
            "contact_impulses": (3, len(scene.contacts)),
            "joint_loads": (6, joints),
        }
        self.shapes = {name: shapes[name] for name in outputs}
        self.statuses: Counter[DerivativeStatus] = Counter()

    def values(self, q: np.ndarray, v: np.ndarray) -> dict[str, np.ndarray]:
        """By output (B, columns, rows); NaN in rows without a valid impact.

        Args:
            q, v: (B, nq), (B, nv).
        """
        names = ["reactions" if name == "joint_loads" else name for name in self.outputs]
        solved = solve_batch(self.scene, q, v, outputs=names)
        found = {}
        for name in self.outputs:
            if name == "joint_loads":
                found[name] = self._in_joint_axes(q, solved.reactions)
            else:
                found[name] = solved.arrays[name].reshape(len(q), -1, self.shapes[name][0])
        return found

    def slopes(self, q: np.ndarray, v: np.ndarray) -> dict[str, np.ndarray]:
        """By output (B, entries, 2 nv) the derivatives by (q, v); those that exist not are NaN."""
        loaded = "joint_loads" in self.outputs
        needed = ("v_after", "contact_impulses") if loaded else self.outputs
        table = derivatives_batch(self.scene, q, v, of=needed)
        self.statuses.update(table.count())
        found = {
            name: np.concatenate(
                [table[name, by].reshape(len(q), -1, v.shape[1]) for by in ("q", "v")], axis=2
            )
            for name in needed
        }
        if loaded:
            rows = []
            for i, own in enumerate(self._load_slopes(q, v, table)):
                nv = v.shape[1]
                moved = found["v_after"][i] - np.eye(nv, 2 * nv, k=nv)
                rows.append(own.by_dv @ moved + own.by_impulses @ found["contact_impulses"][i])
                rows[-1][:, :nv] += own.by_q
            found["joint_loads"] = np.array(rows)
        return {name: found[name] for name in self.outputs}

    def pull(
        self, q: np.ndarray, v: np.ndarray, cotangents: Mapping[str, np.ndarray]
    ) -> tuple[np.ndarray, np.ndarray]:
        """(B, nv) and (B, nv) gradients of Σ cotangent · output by q, on its tangent, and by v.

        Args:
            cotangents: by output (B, entries).
        """
        count, contacts = len(q), len(self.scene.contacts)
        weights: dict[str, Any] = {
            "v_after": np.zeros(v.shape), "contact_impulses": np.zeros((count, 3 * contacts))
        }  # fmt: skip
        for name in weights.keys() & cotangents.keys():
            weights[name] = weights[name] + cotangents[name]
        direct = np.zeros((2, *v.shape))
        if "joint_loads" in cotangents:
            impacts = derivatives_batch(self.scene, q, v, of=(), by=())
            rows = zip(self._load_slopes(q, v, impacts), cotangents["joint_loads"], strict=True)
            for i, (own, weight) in enumerate(rows):
                moved = weight @ own.by_dv
                weights["v_after"][i] += moved
                weights["contact_impulses"][i] += weight @ own.by_impulses
                direct[:, i] = weight @ own.by_q, -moved
        weights["contact_impulses"] = weights["contact_impulses"].reshape(count, contacts, 3)
        table = vjp(self.scene, q, v, weights)
        self.statuses.update(table.count())
        return table["q"] + direct[0], table["v"] + direct[1]

    def _load_slopes(
        self, q: np.ndarray, v: np.ndarray, table: BatchDerivatives
    ) -> Iterator[JointLoadSlopes]:
        impulses = solve_batch(self.scene, q, v, outputs="contact_impulses").contact_impulses
        for row, after, before, own in zip(q, table.impacts.v_after, v, impulses, strict=True):
            yield joint_load_slopes(self.scene, row, after - before, own)

    def _in_joint_axes(self, q: np.ndarray, reactions: np.ndarray) -> np.ndarray:
        """(B, joints, 6) of reactions in world axes."""
        model = flat_model_of(self.scene.robot)
        turns = np.array([model.rotations(np.ascontiguousarray(row))[1:] for row in q])
        parts = reactions.reshape(*reactions.shape[:2], 2, 3)
        return np.asarray((parts @ turns).reshape(reactions.shape))
