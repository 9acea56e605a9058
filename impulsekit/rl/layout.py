"""``Layout``: the order and the axes of q and v in the tensors of a simulator."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import torch

from ..errors import InputError, ShapeError, UnknownNameError, a_thing
from ..errors.calls import public
from ..robot import Robot

__all__ = ["Columns", "Layout"]

LAYOUTS = ("mujoco", "isaac", "pinocchio")
# nq and nv of joints whose columns differ between layouts.
_FREE, _BALL, _TURN = (7, 6), (4, 3), (2, 1)


@public
@dataclass(frozen=True)
class Layout:
    """The order and the axes of q and v in the tensors of a simulator.

    Attributes:
        kind: "mujoco": qpos and qvel, quaternions w, x, y, z, of a free joint the linear velocity
            in world axes and the angular one in the body's; "isaac": the same, but the angular
            velocity of the root in world axes as well (``root_link_pose_w`` with ``joint_pos``,
            ``root_link_vel_w`` with ``joint_vel``); "pinocchio": as everywhere else in impulsekit.
        joints: names in the order of q and v, the root joint first where there is one, such as
            ``["root_joint", *articulation.joint_names]``; None for the robot's own.

    Example:
        >>> Layout("isaac").kind
        'isaac'
    """

    kind: str = "mujoco"
    joints: Sequence[str] | None = None

    def __post_init__(self) -> None:
        if self.kind not in LAYOUTS:
            raise UnknownNameError.among("layout", str(self.kind), LAYOUTS)
        if self.joints is not None:
            object.__setattr__(self, "joints", tuple(self.joints))


class Columns:
    """The way from the columns of a simulator's q and v to Pinocchio's."""

    def __init__(self, robot: Robot, layout: Layout) -> None:
        self._kind, model = layout.kind, robot.model
        names = robot.joint_names if layout.joints is None else layout.joints
        if sorted(names) != sorted(robot.joint_names):
            for name in names:
                robot.joint_id(name, "layout: joints")
            raise InputError(
                f"layout: joints must name each of the robot's {len(robot.joint_names)} joints "
                f"once, got {len(names)} names"
            )
        # (kind, slice of q, slice of v) by joint, in the model's order.
        first_q = first_v = 0
        places = {}
        for name in names:
            joint = model.joints[model.getJointId(name)]
            size = (joint.nq, joint.nv)
            own_nq = 1 if size == _TURN and self._kind != "pinocchio" else joint.nq
            places[name] = (
                size, slice(first_q, first_q + own_nq), slice(first_v, first_v + joint.nv)
            )  # fmt: skip
            if joint.nq not in (7, 2, 1) and joint.shortname() != "JointModelSpherical":
                raise InputError(
                    f'layout: joint "{name}" ({joint.shortname()}) has no layout "{self._kind}"'
                )
            first_q, first_v = first_q + own_nq, first_v + joint.nv
        self._places = _runs([places[name] for name in robot.joint_names])
        self._shape = first_q, first_v

    def taken(self, q: Any, v: Any) -> tuple[torch.Tensor, torch.Tensor]:
        """Return q and v as Pinocchio has them, in float64, differentiable."""
        for what, given, size in zip("qv", (q, v), self._shape, strict=True):
            if not isinstance(given, torch.Tensor):
                raise InputError(f"Landing: {what} must be a torch tensor, got {a_thing(given)}")
            if given.ndim != 2 or given.shape[1] != size:
                raise ShapeError.of(f"Landing: {what}", ("N", size), tuple(given.shape))
        if len(q) != len(v):
            raise ShapeError.of("Landing: v", (len(q), self._shape[1]), tuple(v.shape))
        q, v = q.to(torch.float64), v.to(torch.float64)
        parts = [self._joint(size, q[:, of_q], v[:, of_v]) for size, of_q, of_v in self._places]
        return torch.cat([each[0] for each in parts], 1), torch.cat([each[1] for each in parts], 1)

    def _joint(
        self, size: tuple[int, int], q: torch.Tensor, v: torch.Tensor
    ) -> tuple[torch.Tensor, torch.Tensor]:
        if size == _TURN and q.shape[1] == 1:
            return torch.cat([torch.cos(q), torch.sin(q)], 1), v
        if size not in (_FREE, _BALL):
            return q, v
        turn = q[:, -4:] if self._kind == "pinocchio" else q[:, [-3, -2, -1, -4]]
        turn = turn / turn.norm(dim=1, keepdim=True)
        if size == _FREE and self._kind != "pinocchio":
            angular = _turned_back(turn, v[:, 3:]) if self._kind == "isaac" else v[:, 3:]
            v = torch.cat([_turned_back(turn, v[:, :3]), angular], 1)
        return torch.cat([q[:, :-4], turn], 1), v


def _runs(places: list[tuple[tuple[int, int], slice, slice]]) -> list[Any]:
    """Places of joints, with those that stay as they are and follow each other as one."""
    found: list[Any] = []
    for size, of_q, of_v in places:
        if found and size == found[-1][0] == (1, 1):
            _, q, v = found[-1]
            if (q.stop, v.stop) == (of_q.start, of_v.start):
                found[-1] = size, slice(q.start, of_q.stop), slice(v.start, of_v.stop)
                continue
        found.append((size, of_q, of_v))
    return found


def _turned_back(turn: torch.Tensor, vectors: torch.Tensor) -> torch.Tensor:
    """Rᵀ u of unit quaternions x, y, z, w."""
    axis, w = -turn[:, :3], turn[:, 3:]
    twice = 2.0 * torch.linalg.cross(axis, vectors)
    return vectors + w * twice + torch.linalg.cross(axis, twice)
