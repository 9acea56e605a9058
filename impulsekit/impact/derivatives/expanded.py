"""A model in which every degree of freedom has an axis of its own, fixed in its body.

Pinocchio's derivatives take joints whose axes stand still in the body before them. One that
follows another, or whose axes turn with its own coordinates, is put as a chain of such
joints without masses between them: the motions are the same, with x(q) for q and T v for v.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from ...errors import InputError

__all__ = ["ExpandedModel", "expanded_model"]

# The axes of a joint out of Euler angles, in the order in which they turn.
_ZYX = ((0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0))
_SIMPLE = (
    "JointModelRUB",
    "JointModelR",
    "JointModelP",
    "JointModelH",
    "JointModelTranslation",
    "JointModelFreeFlyer",
    "JointModelSpherical",
)


@dataclass(frozen=True, eq=False)
class ExpandedModel:
    """A model with simple joints, and how its coordinates follow from the given ones.

    Attributes:
        model: the model with simple joints.
        joint_ids: by joint of the given model, the one that carries its body.
        still, nothing: (nv of ``model``,) and (6, nv) zeros.
        spread: (nv of ``model``, nv) T; None where the models are the same.
        before: (nv of ``model``, the same) [k, j] True where the joint of j is that of k, or
            stands before it on the way from the world.
    """

    model: pin.Model
    joint_ids: tuple[int, ...]
    still: np.ndarray
    nothing: np.ndarray
    spread: np.ndarray | None
    before: np.ndarray
    _coordinates: tuple[Callable[[np.ndarray], np.ndarray], ...]

    def configuration(self, q: np.ndarray) -> np.ndarray:
        """x(q)."""
        if self.spread is None:
            return q
        return np.concatenate([part(q) for part in self._coordinates])

    def speeds(self, v: np.ndarray) -> np.ndarray:
        """T v."""
        return v if self.spread is None else self.spread @ v

    def columns(self, table: np.ndarray) -> np.ndarray:
        """Derivatives by the given configuration or speeds, of those by this model's."""
        return table if self.spread is None else table @ self.spread

    def rows(self, table: np.ndarray) -> np.ndarray:
        """Generalized forces of the given speeds, of those of this model's."""
        return table if self.spread is None else self.spread.T @ table


def expanded_model(model: pin.Model) -> ExpandedModel:
    """The expanded model of a model; itself where all joints are simple.

    Raises:
        InputError: a joint that is no chain of simple ones.
    """
    if all(_is_simple(joint) for joint in list(model.joints)[1:]):
        still = np.zeros(model.nv)
        ids = tuple(range(model.njoints))
        nothing = np.zeros((6, model.nv))
        return ExpandedModel(model, ids, still, nothing, None, _before(model), ())
    build = _Build(model)
    for joint_id in range(1, model.njoints):
        build.add(joint_id)
    build.model.gravity.setZero()
    build.model.armature = np.array(build.armature)
    return ExpandedModel(
        build.model,
        tuple(build.joint_ids),
        np.zeros(build.model.nv),
        np.zeros((6, model.nv)),
        np.array(build.spread).reshape(build.model.nv, model.nv),
        _before(build.model),
        tuple(build.coordinates),
    )


def _before(model: pin.Model) -> np.ndarray:
    before = np.zeros((model.nv, model.nv), dtype=bool)
    for joint_id in range(1, model.njoints):
        own = slice(model.idx_vs[joint_id], model.idx_vs[joint_id] + model.nvs[joint_id])
        parent = model.parents[joint_id]
        if parent > 0:
            before[own] = before[model.idx_vs[parent]]
        before[own, own] = True
    return before


def _is_simple(joint: pin.JointModel) -> bool:
    name = joint.shortname()
    return name == "JointModelPlanar" or (
        name.startswith(_SIMPLE) and name != "JointModelSphericalZYX"
    )


class _Build:
    """An expanded model in the making."""

    def __init__(self, source: pin.Model) -> None:
        self.source, self.model = source, pin.Model()
        self.joint_ids = [0]
        self.spread: list[np.ndarray] = []
        # By degree of freedom; what a mimic joint turns stands with its leader.
        self.armature: list[float] = []
        self.coordinates: list[Callable[[np.ndarray], np.ndarray]] = []
        self._leaders = dict(zip(source.mimicking_joints, source.mimicked_joints, strict=True))

    def add(self, joint_id: int) -> None:
        """Add a joint of the source with its body, as a chain."""
        joint = self.source.joints[joint_id]
        parent = self.joint_ids[self.source.parents[joint_id]]
        placement = pin.SE3(self.source.jointPlacements[joint_id])
        name = self.source.names[joint_id]
        if joint.shortname() == "JointModelMimic":
            last = self._add_mimic(joint_id, parent, placement)
        else:
            q, v = joint.idx_q, joint.idx_v
            last = self._chain(joint, parent, placement, name, q, v)
        self.model.appendBodyToJoint(last, self.source.inertias[joint_id], pin.SE3.Identity())
        self.joint_ids.append(last)

    def _chain(
        self, joint: pin.JointModel, parent: int, placement: pin.SE3, name: str, q: int, v: int
    ) -> int:
        """Joints in place of one whose coordinates start at q and v; the last of them."""
        kind = joint.shortname()
        inner = joint.extract() if hasattr(joint, "extract") else joint
        if _is_simple(joint):
            return self._simple(inner, parent, placement, name, q, v)
        axes: tuple[np.ndarray, ...]
        if kind == "JointModelUniversal":
            axes = (np.array(inner.axis1), np.array(inner.axis2))
        elif kind == "JointModelSphericalZYX":
            axes = tuple(np.array(axis) for axis in _ZYX)
        elif kind == "JointModelComposite":
            for i in range(inner.njoints):
                part = inner.joints[i]
                between = placement * inner.jointPlacements[i]
                parent = self._chain(part, parent, between, f"{name} {i}", q, v)
                placement = pin.SE3.Identity()
                q, v = q + part.nq, v + part.nv
            return parent
        else:
            raise InputError(
                f'derivatives: joint "{name}" is a {kind}, whose axes change with its own '
                "coordinates, and it is no chain of joints with fixed axes; build it of such joints"
            )
        for i, axis in enumerate(axes):
            turn = pin.JointModelRevoluteUnaligned(axis)
            parent = self._simple(turn, parent, placement, f"{name} {i}", q + i, v + i)
            placement = pin.SE3.Identity()
        return parent

    def _simple(
        self, joint: pin.JointModel, parent: int, placement: pin.SE3, name: str, q: int, v: int
    ) -> int:
        added = self.model.addJoint(parent, joint, placement, name)
        own = self.model.joints[added]
        self.coordinates.append(lambda whole: whole[q : q + own.nq])
        self.spread += list(np.eye(self.source.nv)[v : v + own.nv])
        self.armature += list(self.source.armature[v : v + own.nv])
        return added

    def _add_mimic(self, joint_id: int, parent: int, placement: pin.SE3) -> int:
        """A joint with one degree of freedom that follows its leader."""
        joint = self.source.joints[joint_id]
        leader = self.source.joints[self._leaders[joint_id]]
        inner = joint.extract()
        scaling, offset = inner.scaling, inner.offset
        data = joint.createData()
        joint.calc(data, pin.neutral(self.source))
        axis = np.asarray(data.S).reshape(6) / (scaling or 1.0)
        if not axis.any():
            raise InputError(
                f'derivatives: joint "{self.source.names[joint_id]}" mimics with multiplier 0'
            )
        turns = bool(axis[3:].any())
        if turns and axis[:3].any():
            raise InputError(
                f'derivatives: joint "{self.source.names[joint_id]}" is a screw that mimics another'
            )
        kind = pin.JointModelRevoluteUnaligned if turns else pin.JointModelPrismaticUnaligned
        at, on_circle = leader.idx_q, leader.nq == 2
        added = self.model.addJoint(
            parent, kind(axis[3:] if turns else axis[:3]), placement, self.source.names[joint_id]
        )

        def coordinate(whole: np.ndarray) -> np.ndarray:
            own = np.arctan2(whole[at + 1], whole[at]) if on_circle else whole[at]
            return np.array([scaling * own + offset])

        self.coordinates.append(coordinate)
        self.spread.append(scaling * np.eye(self.source.nv)[leader.idx_v])
        self.armature.append(0.0)
        return added
