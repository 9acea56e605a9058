"""The points with which feet of a MuJoCo model touch."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..errors import UnknownNameError

__all__ = ["lowest_points"]


def lowest_points(model: Any, name: str) -> list[tuple[str, str, np.ndarray]]:
    """Return the name, body and point in the body's axes of what a site or geom touches with.

    Raises:
        UnknownNameError: no such site or geom.
    """
    import mujoco

    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    kinds = mujoco.mjtObj.mjOBJ_SITE, mujoco.mjtObj.mjOBJ_GEOM
    site, geom = (mujoco.mj_name2id(model, kind, str(name)) for kind in kinds)
    if site < 0 and geom < 0:
        counts = zip(kinds, (model.nsite, model.ngeom), strict=True)
        known = [mujoco.mj_id2name(model, kind, i) for kind, n in counts for i in range(n)]
        raise UnknownNameError.among("site or geom", str(name), list(filter(None, known)))
    if site >= 0:
        body, points = int(model.site_bodyid[site]), data.site_xpos[site][None]
    else:
        body, turn = int(model.geom_bodyid[geom]), data.geom_xmat[geom].reshape(3, 3)
        points = data.geom_xpos[geom] + _offsets(model.geom_type[geom], model.geom_size[geom], turn)
    at = (points - data.xpos[body]) @ data.xmat[body].reshape(3, 3)
    # What has no name is called as Robot.from_mjcf calls it.
    frame = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_BODY, body) or f"body_{body}"
    names = [name] if len(at) == 1 else [f"{name} {i}" for i in range(len(at))]
    return [(own, frame, point) for own, point in zip(names, at, strict=True)]


def _offsets(kind: int, size: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """From the centre of a geom to its lowest points, in world axes."""
    from mujoco import mjtGeom

    down = np.array([0.0, 0.0, -1.0])
    if kind == mjtGeom.mjGEOM_SPHERE:
        return size[0] * down[None]
    if kind == mjtGeom.mjGEOM_CAPSULE:
        return np.outer([-size[1], size[1]], turn[:, 2]) + size[0] * down
    if kind == mjtGeom.mjGEOM_BOX:
        signs = np.stack(np.meshgrid(*3 * [[-1.0, 1.0]], indexing="ij"), axis=-1).reshape(-1, 3)
        corners = (signs * size) @ turn.T
        return corners[np.argsort(corners[:, 2], kind="stable")[:4]]
    return np.zeros((1, 3))
