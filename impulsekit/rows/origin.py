"""A robot far away is hit as it is at the origin, and with all its digits.

Neither M nor the Jacobian of a point depends on where a root stands in the world,
but Pinocchio forms world placements on the way: 10⁶ m cost six digits of a
Jacobian. So the roots are brought to the origin before anything is computed.
"""

from __future__ import annotations

import enum

import numpy as np
import pinocchio as pin

__all__ = [
    "Places",
    "at_origin",
    "bring_roots_to_origin",
    "float_freely",
    "near_origin",
    "root_translations",
]


class Places(enum.IntEnum):
    """Which places of roots a scene depends on. True counts as IN_WORLD."""

    NONE = 0
    IN_WORLD = 1
    TO_EACH_OTHER = 2


_TRANSLATIONS = {"JointModelFreeFlyer": 3, "JointModelTranslation": 3, "JointModelPlanar": 2}


def bring_roots_to_origin(model: pin.Model) -> None:
    """Put every joint that hangs on the world at the origin. The model is changed."""
    for joint_id in range(1, model.njoints):
        if model.parents[joint_id] == 0:
            placement = model.jointPlacements[joint_id]
            model.jointPlacements[joint_id] = pin.SE3(placement.rotation, np.zeros(3))


def root_translations(model: pin.Model) -> slice | np.ndarray | None:
    """Where q holds positions of roots in the world; None where it holds none."""
    entries: list[int] = []
    for joint_id in range(1, model.njoints):
        if model.parents[joint_id] == 0:
            joint = model.joints[joint_id]
            count = _TRANSLATIONS.get(joint.shortname(), 0)
            entries.extend(range(joint.idx_q, joint.idx_q + count))
    if not entries:
        return None
    if entries == list(range(entries[0], entries[0] + len(entries))):
        return slice(entries[0], entries[0] + len(entries))
    return np.array(entries)


def float_freely(model: pin.Model) -> bool:
    """Whether every root is a free-flyer in the axes of the world, so that all can be moved."""
    return all(
        model.joints[joint_id].shortname() == "JointModelFreeFlyer"
        and np.array_equal(model.jointPlacements[joint_id].rotation, np.eye(3))
        for joint_id in range(1, model.njoints)
        if model.parents[joint_id] == 0
    )


def near_origin(q: np.ndarray, translations: slice | np.ndarray) -> np.ndarray:
    """q with the first of several free-flyers at the origin, the others beside it as before.

    Differences of neighbours are exact, however far away they are.
    """
    q = q.copy()
    places = q[translations].reshape(-1, 3)
    q[translations] = (places - places[0]).reshape(-1)
    return q


def at_origin(q: np.ndarray, translations: slice | np.ndarray | None) -> np.ndarray:
    """q with its roots at the origin; q itself where none can move there."""
    if translations is None:
        return q
    q = q.copy()
    q[translations] = 0.0
    return q
