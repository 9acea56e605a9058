"""The arrays of a study's rows: names, dimensions, units."""

from __future__ import annotations

from typing import Any

from ...impact.status import Status
from ...motion.record.status import MotionStatus
from ...motion.simulate import chosen_settings
from ..result import shape_of
from .study import Study

# The status of a row that was never written; no Status, and none of the core's codes.
UNWRITTEN = -128
# Dimensions of a row, and units. Arrays that are not listed count degrees of freedom.
_ARRAYS: dict[str, tuple[tuple[str, ...], str]] = {
    "status": ((), ""),
    "generalized_impulse": (("dof",), "N m s, N s"),
    "energy_change": ((), "J"),
    "contact_impulses": (("contact", "axis"), "N s"),
    "constraint_impulses": (("constraint_row",), "N s, N m s"),
    "normal_components": (("contact", "normal_component"), "m/s, rad/s, N s, N m s"),
    "gaps": (("contact",), "m, rad"),
    "reactions": (("joint", "wrench"), "N s, N m s"),
    "bodies": (("body", "twist"), "m/s, rad/s"),
    "uniqueness": ((), "1"),
    "end": ((), "s"),
    "impact_count": ((), "1"),
    "q": (("q_entry",), "rad, m"),
    "q_end": (("q_entry",), "rad, m"),
    "q_samples": (("time", "q_entry"), "rad, m"),
    "v_samples": (("time", "dof"), "rad/s, m/s"),
    "impulses": (("impulse_entry",), "N s, N m s"),
    "masses": (("link",), "1"),
    "restitution": (("contact",), "1"),
    "friction": (("contact",), "1"),
}
_OF_DOF = (("dof",), "rad/s, m/s")
_NOTES = {
    "status": {"meaning": "see the attribute status"},
    "impulses": {"order": "as in the scene, entry after entry"},
    "masses": {"meaning": "factors on mass and inertia of links"},
}


def layout_of(study: Study) -> dict[str, Any]:
    """All that is needed to open a study's rows, ready for JSON."""
    scene = study.scene
    robot = scene.robot
    coordinates = {
        "dof": _dof_names(robot),
        "axis": ["x", "y", "z"],
        "contact": list(scene.entry_names("contacts")),
        "link": list(study.scaled_links),
    }
    times: Any = () if study.motion is None else chosen_settings(study.motion, None, None, {})[1]
    sizes = {
        "q_entry": robot.nq,
        "normal_component": 3,
        "constraint_row": shape_of(scene, "constraint_impulses")[0],
        "joint": robot.model.njoints - 1,
        "wrench": 6,
        "body": len(robot.links),
        "twist": 6,
        "time": len(times),
        "impulse_entry": sum(len(entry.values) for entry in scene.impulses),
        **{name: len(names) for name, names in coordinates.items()},
    }
    arrays = {}
    for name in ("status", *study.names, *study.varied):
        dims, unit = _ARRAYS.get(name, _OF_DOF)
        arrays[name] = {
            "dims": dims,
            "shape": [sizes[dim] for dim in dims],
            "attributes": _NOTES.get(name, {}) | ({"units": unit} if unit else {}),
        }
    used = {dim for array in arrays.values() for dim in array["dims"]}
    statuses = Status if study.motion is None else MotionStatus
    return {
        "title": f"impulsekit study of {robot.name}",
        "rows": study.samples,
        "chunk": study.rows_of_chunk,
        "arrays": arrays,
        "coordinates": {dim: names for dim, names in coordinates.items() if dim in used},
        "status": {**{code.name: code.code for code in statuses}, "UNWRITTEN": UNWRITTEN},
    }


def _dof_names(robot: Any) -> list[str]:
    names = []
    for name, joint in zip(list(robot.model.names)[1:], list(robot.model.joints)[1:], strict=True):
        names.extend([name] if joint.nv == 1 else [f"{name}[{k}]" for k in range(joint.nv)])
    return names
