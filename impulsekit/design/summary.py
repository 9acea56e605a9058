"""The design measures of points as text and as plain data."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from ..display.plain import plain
from ..errors import InputError
from ..scene import Scene
from ..scene.design import DesignPoint
from .ellipsoid import impact_ellipsoid
from .sparing import spare_joint, worst_blow

__all__ = ["design_as_dict", "design_as_text"]


def design_as_dict(scene: Scene, q: Any, points: Iterable[DesignPoint]) -> list[dict[str, Any]]:
    """By point, everything that is told of it, ready for JSON; world axes, SI units.

    An effective mass without end, where nothing moves, is None.

    Raises:
        As ``impact_ellipsoid`` and ``spare_joint``; InputError: ``until`` without ``joint``.
    """
    told: list[dict[str, Any]] = plain([_of(scene, q, point) for point in points])
    return told


def _of(scene: Scene, q: Any, point: DesignPoint) -> dict[str, Any]:
    found = impact_ellipsoid(scene, q, point.frame, point.at)
    told: dict[str, Any] = {
        "point": point.title,
        "frame": point.frame,
        "at": list(point.at),
        "position": found.position.tolist(),
        "axes": [
            {"direction": axis.tolist(), "effective_mass": mass}
            for axis, mass in zip(found.axes.T, found.masses, strict=True)
        ],
    }
    if point.direction is not None:
        told["direction"] = list(point.direction)
        told["effective_mass"] = found.effective_mass(point.direction)
    if point.joint is None:
        if point.until is not None:
            raise InputError(
                f"{point.title}: until is an end of the line on which a joint is "
                "spared; name the joint"
            )
        return told
    told["joint"] = point.joint
    for kind, unit in (("force", "worst_force"), ("couple", "worst_couple")):
        worst = worst_blow(scene, q, point.joint, point.frame, point.at, kind=kind)
        told[unit] = {"direction": worst.direction.tolist(), "share": worst.share}
        told[unit.replace("worst", "kindest")] = {
            "direction": worst.kindest.tolist(),
            "share": worst.kindest_share,
        }
    if point.until is not None:
        spared = spare_joint(
            scene, q, point.joint, point.frame, point.at, point.until, point.direction
        )
        told["spared"] = {
            "at": spared.at.tolist(),
            "along": spared.along,
            "direction": spared.direction.tolist(),
            "share": spared.share,
        }
    return told


def design_as_text(told: list[dict[str, Any]]) -> str:
    """The same for people; what ``design_as_dict`` gives."""
    lines: list[str] = []
    for item in told:
        lines += [f"{item['point']}, at {_vector(item['position'])} m in the world", ""]
        lines.append("  effective mass [kg]   along (world axes)")
        if "effective_mass" in item:
            lines.append(f"  {_mass(item['effective_mass'])}   {_vector(item['direction'])}  given")
        lines += [
            f"  {_mass(axis['effective_mass'])}   {_vector(axis['direction'])}  own axis"
            for axis in item["axes"]
        ]
        if "joint" in item:
            lines += ["", f"  {item['joint']} carries of a unit blow here:"]
            for key, words, unit in (
                ("worst_force", "impulse at most ", ""),
                ("kindest_force", "impulse at least", ""),
                ("worst_couple", "couple at most  ", " m"),
                ("kindest_couple", "couple at least ", " m"),
            ):
                own = item[key]
                lines.append(
                    f"    {words}  {own['share']:10.6f}{unit:2}  along {_vector(own['direction'])}"
                )
        if "spared" in item:
            own = item["spared"]
            lines.append(
                f"    spared best at {_vector(own['at'])} m in the frame, "
                f"{own['along']:.6f} of the line, along {_vector(own['direction'])}: "
                f"{own['share']:.6f}"
            )
        lines.append("")
    return "\n".join(lines)


def _mass(value: float | None) -> str:
    return f"{'infinite' if value is None else format(value, '.6g'):>19}"


def _vector(values: Any) -> str:
    # Without the sign of a zero.
    return "(" + ", ".join(f"{x:.6g}" for x in (np.round(values, 12) + 0.0)) + ")"
