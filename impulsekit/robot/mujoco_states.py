"""States of robots from MJCF in MuJoCo's layout and in Pinocchio's."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import ShapeError
from .arrays import array_of
from .mjcf_shapes import rotation_of

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

# mjJNT_FREE and mjJNT_BALL.
_FREE, _BALL = 0, 1


def mujoco_state(data: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return q (nq,) and v (nv,) of ``Robot.from_mjcf(data.model)`` at the state of MuJoCo's data.

    MuJoCo's quaternions are w, x, y, z; the linear velocity of its free joints is in world axes,
    the angular one in body axes.

    Args:
        data: a ``mujoco.MjData``; only ``model``, ``qpos`` and ``qvel`` are read.

    Raises:
        ShapeError: of qpos or qvel.

    Example:
        >>> import mujoco
        >>> ball = "<body><freejoint/><geom size='1'/></body>"
        >>> text = f"<mujoco><worldbody>{ball}</worldbody></mujoco>"
        >>> data = mujoco.MjData(mujoco.MjModel.from_xml_string(text))
        >>> mujoco_state(data)[0].tolist()
        [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]
    """
    q, v = np.array(data.qpos, dtype=float), np.array(data.qvel, dtype=float)
    for what, own, count in (("qpos", q, data.model.nq), ("qvel", v, data.model.nv)):
        if own.shape != (count,):
            raise ShapeError.of(what, (count,), own.shape)
    for turn, speed in _turns(data.model):
        if speed is not None:
            v[speed] = rotation_of(q[turn]).T @ v[speed]
        q[turn] = np.roll(q[turn], -1)
    return q, v


def set_mujoco_state(data: Any, q: ArrayLike, v: ArrayLike) -> None:
    """Write q (nq,) and v (nv,) of ``Robot.from_mjcf(data.model)`` into MuJoCo's data.

    Nothing else of the data changes: call ``mujoco.mj_forward(data.model, data)`` after it.

    Args:
        data: a ``mujoco.MjData``.
        q, v: the robot's state, as in ``Impact.q`` and ``Impact.v_after``.

    Raises:
        ShapeError, NotFiniteError.

    Example:
        >>> import mujoco
        >>> ball = "<body><freejoint/><geom size='1'/></body>"
        >>> text = f"<mujoco><worldbody>{ball}</worldbody></mujoco>"
        >>> data = mujoco.MjData(mujoco.MjModel.from_xml_string(text))
        >>> set_mujoco_state(data, [0, 0, 1, 1, 0, 0, 0], [0, 0, -1, 0, 0, 0])
        >>> data.qpos.tolist(), data.qvel.tolist()[:3]
        ([0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0])
    """
    qpos = array_of(q, (data.model.nq,), "set_mujoco_state: q")
    qvel = array_of(v, (data.model.nv,), "set_mujoco_state: v")
    for turn, speed in _turns(data.model):
        qpos[turn] = np.roll(qpos[turn], 1)
        if speed is not None:
            qvel[speed] = rotation_of(qpos[turn]) @ qvel[speed]
    data.qpos[:], data.qvel[:] = qpos, qvel


def _turns(mj: Any) -> Iterator[tuple[slice, slice | None]]:
    """Of free and ball joints the quaternion in qpos, and the velocity in world axes in qvel."""
    for kind, first, speed in zip(mj.jnt_type, mj.jnt_qposadr, mj.jnt_dofadr, strict=True):
        if kind == _FREE:
            yield slice(first + 3, first + 7), slice(speed, speed + 3)
        elif kind == _BALL:
            yield slice(first, first + 4), None
