"""How large the outputs of a batch are."""

from __future__ import annotations

from typing import Any

from ..scene import FrameAnchor, GapConstraint, JointLock, PointAnchor, Scene

__all__ = ["shape_of"]


def shape_of(scene: Scene, name: str) -> tuple[int, ...]:
    """The shape of an output for one row, by its name."""
    if name == "energy_change":
        return ()
    if name in ("contact_impulses", "normal_components"):
        return (len(scene.contacts), 3)
    if name == "constraint_impulses":
        return (sum(_row_count(scene, entry) for entry in scene.held),)
    if name == "reactions":
        return (scene.robot.model.njoints - 1, 6)
    if name == "bodies":
        return (len(scene.robot.links), 6)
    return (scene.robot.nv,)


def _row_count(scene: Scene, entry: Any) -> int:
    """How many rows a constraint has."""
    if isinstance(entry, FrameAnchor):
        return len(entry.directions)
    if isinstance(entry, GapConstraint):
        return entry.rows
    if isinstance(entry, JointLock):
        return scene.robot.model.joints[scene.robot.joint_id(entry.joint)].nv
    return 3 if isinstance(entry, PointAnchor) else 1
