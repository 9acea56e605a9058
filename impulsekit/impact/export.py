"""An impact as plain data for JSON."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from .contact_results import ContactPoint
    from .result import Impact

__all__ = ["impact_to_dict"]


def impact_to_dict(impact: Impact) -> dict[str, Any]:
    """All parts of an impact by name; arrays become lists, SI units, world axes."""
    robot = impact.scene.robot
    energy = impact.energy
    residuals = impact.residuals
    return {
        "robot": robot.name,
        "joints": list(robot.joint_names),
        "status": impact.status.name,
        "advice": impact.status.value,
        "valid": impact.is_valid(),
        "doubts": list(impact.doubts),
        "uniqueness": impact.uniqueness.to_dict(),
        "q": impact.q.tolist(),
        "v_before": impact.v_before.tolist(),
        "v_after": impact.v_after.tolist(),
        "dv": impact.dv.tolist(),
        "generalized_impulse": impact.generalized_impulse.tolist(),
        "momentum_before": impact.momentum_before.tolist(),
        "momentum_after": impact.momentum_after.tolist(),
        "bodies": {
            name: {"dv_com": jump.dv_com.tolist(), "domega": jump.domega.tolist()}
            for name, jump in impact.bodies.items()
        },
        "reactions": {name: wrench.tolist() for name, wrench in impact.reactions.items()},
        "constraints": [
            {
                "name": result.name,
                "rows": list(result.rows),
                "impulse": result.impulse.tolist(),
                "unique": result.unique,
                "gap": result.gap,
                "velocity_before": result.velocity_before.tolist(),
                "velocity_after": result.velocity_after.tolist(),
                "work": result.work,
            }
            for result in impact.constraints
        ],
        "contacts": [
            {
                "name": result.name,
                "mode": result.mode,
                "gap": result.gap if math.isfinite(result.gap) else None,
                "impulse": result.impulse.tolist(),
                "velocity_before": _numbers_or_none(result.velocity_before),
                "velocity_after": _numbers_or_none(result.velocity_after),
                "work": result.work,
                "unique": result.unique,
                "points": [
                    {
                        "position": None if point.position is None else point.position.tolist(),
                        "normal": None if point.normal is None else point.normal.tolist(),
                        "impulse": point.impulse.tolist(),
                        "velocity_before": point.velocity_before.tolist(),
                        "velocity_after": point.velocity_after.tolist(),
                        "mode": point.mode,
                        "normal_work": point.normal_work,
                        "friction_work": point.friction_work,
                        "unique": point.unique,
                        **_turning(point),
                    }
                    for point in result.points
                ],
            }
            for result in impact.contacts
        ],
        "energy": {
            "before": energy.before,
            "after": energy.after,
            "change": energy.change,
            "of_lost_velocities": energy.of_lost_velocities,
            "work": dict(energy.work),
        },
        "residuals": {
            "momentum": residuals.momentum,
            "constraint": residuals.constraint,
            "complementarity": residuals.complementarity,
        },
    }


def _turning(point: ContactPoint) -> dict[str, Any]:
    own = point.turning
    if own is None:
        return {}
    return {
        "angular_impulse": own.impulse.tolist(),
        "rolling": own.rolling,
        "spin": own.spin,
        "angular_velocity_before": own.velocity_before.tolist(),
        "angular_velocity_after": own.velocity_after.tolist(),
        "turning_work": own.work,
    }


def _numbers_or_none(array: np.ndarray) -> list[float] | None:
    """A list, or None for what is not there: JSON knows no NaN."""
    return array.tolist() if np.isfinite(array).all() else None
