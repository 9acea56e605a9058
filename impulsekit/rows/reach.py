"""Which branches of the tree an impact can reach, and the model of those alone.

Trees that hang on the world side by side do not feel each other: M is block
diagonal over them. What no blow reaches is neither built nor computed.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from .origin import (
    Places,
    at_origin,
    bring_roots_to_origin,
    float_freely,
    near_origin,
    root_translations,
)

if TYPE_CHECKING:
    from ..scene import Scene

__all__ = ["ReachedModel", "branch_of", "reached_model", "touched_joints"]


# Robots that are built stay below, or have bodies with next to no inertia.
UNEVEN_LENGTHS = 300.0


@dataclass(frozen=True, eq=False)
class ReachedModel:
    """The part of a model that an impact reaches.

    Attributes:
        model: without gravity, roots at the origin; free to be given frames of its own.
        whole: True where nothing was left out.
        q_index, v_index: where its entries stand in the whole q and v.
        joint_ids: (njoints of ``model``,) the joint of the whole model behind each of its own.
        translations: where its own q holds positions of roots that may be changed; None where
            there are none.
        together: whether the roots may only be moved all by the same way.
    """

    model: pin.Model
    whole: bool
    q_index: slice | np.ndarray
    v_index: slice | np.ndarray
    joint_ids: tuple[int, ...]
    translations: slice | np.ndarray | None
    together: bool = False

    @property
    def is_as_given(self) -> bool:
        """Whether its configuration is the whole q, unchanged."""
        return self.whole and self.translations is None

    @cached_property
    def has_uneven_lengths(self) -> bool:
        """Whether places in the world are many times as large as some body."""
        model = self.model
        farthest = [0.0] * model.njoints
        smallest = np.inf
        for joint_id in range(1, model.njoints):
            step = float(np.linalg.norm(model.jointPlacements[joint_id].translation))
            farthest[joint_id] = farthest[model.parents[joint_id]] + step
            body = model.inertias[joint_id]
            if body.mass > 0.0:
                turning = max(float(np.trace(body.inertia)), 0.0) / body.mass
                smallest = min(smallest, np.sqrt(turning + float(body.lever.dot(body.lever))))
        return max(farthest) > UNEVEN_LENGTHS * smallest

    def joint_id(self, joint_id_in_whole: int) -> int:
        """The joint of the reached model that is this joint of the whole one."""
        return self.joint_ids.index(joint_id_in_whole)

    def configuration(self, q: np.ndarray) -> np.ndarray:
        """Its own configuration, with the roots at the origin, out of the whole q."""
        own = q if self.whole else q[self.q_index]
        if self.together and self.translations is not None:
            return near_origin(own, self.translations)
        return at_origin(own, self.translations)


def touched_joints(scene: Scene) -> set[int]:
    """The joints of the bodies that a scene strikes or holds, without the world."""
    robot = scene.robot
    touched = set()
    for entry in (*scene.impulses, *scene.held, *scene.contacts):
        if getattr(entry, "of_whole_robot", False):
            return set(range(1, robot.model.njoints))
        touched |= {robot.model.frames[robot.frame_id(n)].parentJoint for n in entry.frame_names}
        touched |= {robot.joint_id(name) for name in entry.joint_names}
    if not scene.contacts:
        return touched - {0}

    from ..scene import Collision

    for contact in scene.contacts:
        if isinstance(contact, Collision):
            from ..robot.geometry import geometry_ids

            touched |= {geometry_ids(robot, name)[1] for name in (contact.first, contact.other)}
    return touched - {0}


def branch_of(model: pin.Model, joint_id: int) -> int:
    """The joint at the world behind which a joint hangs; 0 for the world itself."""
    while joint_id > 0 and model.parents[joint_id] > 0:
        joint_id = model.parents[joint_id]
    return joint_id


def reached_model(
    model: pin.Model, struck_joints: Iterable[int], *, keep_places: bool | Places = False
) -> ReachedModel:
    """The branches in which ``struck_joints`` lie, as a model of their own.

    ``keep_places`` leaves the roots where they stand, in the world or to each other, for
    scenes in which the place of one branch against another matters.
    """
    to_each_other = keep_places is Places.TO_EACH_OTHER
    branches = {branch_of(model, joint_id) for joint_id in struck_joints} - {0}
    branch = [branch_of(model, j) for j in range(model.njoints)]
    kept = [j for j in range(1, model.njoints) if branch[j] in branches]
    if len(kept) == model.njoints - 1 or model.nq == 0 or _has_mimic(model):
        alone = pin.Model(model)
        alone.gravity.setZero()
        joint_ids = tuple(range(model.njoints))
        translations = None
        if not keep_places:
            bring_roots_to_origin(alone)
            translations = root_translations(alone)
        together = to_each_other and float_freely(alone)
        if together:
            translations = root_translations(alone)
        return ReachedModel(
            alone, True, slice(None), slice(None), joint_ids, translations, together
        )
    joint_ids = (0, *kept)
    reduced = _of_joints(model, joint_ids)
    if not keep_places:
        bring_roots_to_origin(reduced)
    together = to_each_other and float_freely(reduced)
    return ReachedModel(
        reduced,
        False,
        _index(model, joint_ids, "idx_q", "nq"),
        _index(model, joint_ids, "idx_v", "nv"),
        joint_ids,
        None if keep_places and not together else root_translations(reduced),
        together,
    )


def _of_joints(model: pin.Model, joint_ids: tuple[int, ...]) -> pin.Model:
    """A model of whole branches, without gravity, limits and frames.

    Not Pinocchio's ``buildReducedModel``: it ends the process where a joint has no frame, and
    does not find those of joints that are called as a link is.
    """
    reduced = pin.Model()
    reduced.gravity.setZero()
    place = {joint_id: i for i, joint_id in enumerate(joint_ids)}
    armature: list[float] = []
    for joint_id in joint_ids[1:]:
        joint = model.joints[joint_id]
        own = reduced.addJoint(
            place[model.parents[joint_id]],
            joint,
            model.jointPlacements[joint_id],
            model.names[joint_id],
        )
        reduced.appendBodyToJoint(own, model.inertias[joint_id], pin.SE3.Identity())
        armature += model.armature[joint.idx_v : joint.idx_v + joint.nv].tolist()
    reduced.armature = np.array(armature)
    return reduced


def _has_mimic(model: pin.Model) -> bool:
    return any(joint.shortname() == "JointModelMimic" for joint in model.joints)


def _index(
    model: pin.Model, joint_ids: Iterable[int], start: str, count: str
) -> slice | np.ndarray:
    entries: list[int] = []
    for joint_id in joint_ids:
        if joint_id > 0:
            joint = model.joints[joint_id]
            first = getattr(joint, start)
            entries.extend(range(first, first + getattr(joint, count)))
    if not entries:
        return slice(0, 0)
    # A slice costs a view, an index array a copy.
    if entries == list(range(entries[0], entries[0] + len(entries))):
        return slice(entries[0], entries[0] + len(entries))
    return np.array(entries)
