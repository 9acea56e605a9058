"""How large the outputs of a batch are."""

from __future__ import annotations

from ..rows.entries import rows_of_entry
from ..scene import Scene

__all__ = ["shape_of"]


def shape_of(scene: Scene, name: str) -> tuple[int, ...]:
    """The shape of an output for one row, by its name."""
    if name in ("energy_change", "uniqueness"):
        return ()
    if name in ("contact_impulses", "normal_components"):
        return (len(scene.contacts), 3)
    if name == "gaps":
        return (len(scene.contacts),)
    if name == "constraint_impulses":
        said = (rows_of_entry(scene.robot, entry) for entry in scene.held)
        return (sum(len(rows.labels) for rows in said),)
    if name == "reactions":
        return (scene.robot.model.njoints - 1, 6)
    if name == "bodies":
        return (len(scene.robot.links), 6)
    return (scene.robot.nv,)
