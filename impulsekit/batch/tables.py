"""The outputs of a batch as a labelled table."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import MissingExtraError
from ..motion.record.tables import coordinate_names

if TYPE_CHECKING:
    from collections.abc import Mapping

    from ..scene import Scene

__all__ = ["batch_table"]

# The axes of each output behind "row".
AXES = {
    "status": (),
    "energy_change": (),
    "uniqueness": (),
    "contact_impulses": ("contact", "axis"),
    "normal_components": ("contact", "normal"),
    "gaps": ("contact",),
    "constraint_impulses": ("constraint_row",),
    "reactions": ("joint", "wrench"),
    "bodies": ("link", "twist"),
    "outcome_bounds": ("bound", "speed"),
}


def batch_table(outputs: Mapping[str, np.ndarray], scene: Scene | None) -> Any:
    """Return outputs, the status among them, as an ``xarray.Dataset``."""
    with MissingExtraError.unless("xarray", "study", "ImpactBatch.to_xarray"):
        import xarray
    found = {name: (("row", *AXES.get(name, ("speed",))), own) for name, own in outputs.items()}
    names: dict[str, Any] = {
        "axis": ["x", "y", "z"],
        "normal": ["before", "after", "impulse"],
        "wrench": ["fx", "fy", "fz", "mx", "my", "mz"],
        "bound": ["least", "largest"],
        "twist": ["vx", "vy", "vz", "wx", "wy", "wz"],
    }
    if scene is not None:
        robot = scene.robot
        names |= {
            "speed": coordinate_names(robot.model)[1],
            "contact": list(scene.entry_names("contacts")),
            "joint": list(robot.joint_names),
            "link": list(robot.link_names),
        }
    used = {axis for axes, _ in found.values() for axis in axes}
    coords = {axis: own for axis, own in names.items() if axis in used}
    return xarray.Dataset(found, coords={"row": np.arange(len(outputs["status"])), **coords})
