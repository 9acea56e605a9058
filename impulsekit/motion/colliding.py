"""The gap of two bodies whose points of contact coal finds."""

from __future__ import annotations

import coal
import numpy as np
import pinocchio as pin

from ..impact.collision import convex_geometry, meeting_points, smallest_gap
from ..impact.reach import ReachedModel
from ..impact.touching import contact_axes
from ..robot import Robot
from ..robot.geometry import geometry_ids
from ..scene import Collision

__all__ = ["CollidingGap"]

# A resting pair is looked for up to this far apart [m].
RESTING = 1e-5
# How far the bodies move for the rates of their rows [m, rad].
MOVE = 1e-4


class CollidingGap:
    """Two bodies and the smallest distance between them."""

    has_rate = False

    def __init__(self, robot: Robot, reached: ReachedModel, entry: Collision, index: int) -> None:
        objects = robot.collision_model.geometryObjects
        self.entry, self.friction = index, entry.friction
        self._model = reached.model
        self._margin = max(entry.margin, RESTING)
        self._pieces = []
        self._joint_ids = []
        self._reaches = []
        for name in (entry.first, entry.other):
            ids, joint_id = geometry_ids(robot, name)
            pieces = [(convex_geometry(objects[i]), objects[i].placement) for i in ids]
            self._pieces.append(pieces)
            self._joint_ids.append(reached.joint_id(joint_id))
            self._reaches.append(_reach(pieces))
        self._shifted: pin.Data | None = None

    def _placed(self, data: pin.Data) -> list:
        return [
            [(shape, data.oMi[joint_id] * placement) for shape, placement in pieces]
            for pieces, joint_id in zip(self._pieces, self._joint_ids, strict=True)
        ]

    def distance(self, data: pin.Data) -> float:
        """The gap [m], negative where they overlap; ``data`` with placements."""
        first, other = self._placed(data)
        return float(smallest_gap(first, other))

    def speed_bound(self, data: pin.Data) -> float:
        """No gap of these two closes faster [m/s]; ``data`` with placements and velocities."""
        middles, turning = [], 0.0
        for joint_id, (centre, radius) in zip(self._joint_ids, self._reaches, strict=True):
            motion = data.v[joint_id]
            local = motion.linear + np.cross(motion.angular, centre)
            middles.append(data.oMi[joint_id].rotation.dot(local))
            turning += float(np.linalg.norm(motion.angular)) * radius
        return float(np.linalg.norm(middles[0] - middles[1])) + turning

    def _points(self, data: pin.Data) -> tuple[np.ndarray, np.ndarray]:
        """(3k, nv) rows and (k, 3) points; ``data`` with joint Jacobians."""
        first, other = self._placed(data)
        rows, points = [], []
        for point in meeting_points(first, other, self._margin):
            difference = np.zeros((3, self._model.nv))
            for sign, joint_id in zip((1.0, -1.0), self._joint_ids, strict=True):
                if joint_id > 0:
                    at = pin.SE3(np.eye(3), data.oMi[joint_id].actInv(point.position))
                    jacobian = pin.getFrameJacobian(
                        self._model, data, joint_id, at, pin.LOCAL_WORLD_ALIGNED
                    )
                    difference += sign * jacobian.reshape(6, -1)[:3]
            rows.append(contact_axes(point.normal).T.dot(difference))
            points.append(point.position)
        if not rows:
            return np.empty((0, self._model.nv)), np.empty((0, 3))
        return np.vstack(rows), np.array(points)

    def rows(self, data: pin.Data, q: np.ndarray) -> np.ndarray:
        """(3k, nv) of all points that touch."""
        return self._points(data)[0]

    def bias(self, data: pin.Data, q: np.ndarray, v: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """(3k,) the rows' rates along the motion, by central differences.

        The points wander over the bodies as these roll, so no point of either tells them.
        """
        size = float(np.abs(v).max(initial=0.0))
        if size == 0.0 or not len(rows):
            return np.zeros(len(rows))
        if self._shifted is None:
            self._shifted = self._model.createData()
        shifted, time = self._shifted, MOVE / max(size, 1e-3)
        here = self._points(data)[1]
        velocities = []
        for sign in (1.0, -1.0):
            there = pin.integrate(self._model, q, sign * time * v)
            pin.computeJointJacobians(self._model, shifted, there)
            found, points = self._points(shifted)
            if not len(points):
                return np.zeros(len(rows))
            nearest = [int(np.argmin(np.linalg.norm(points - point, axis=1))) for point in here]
            velocities.append(found.dot(v).reshape(-1, 3)[nearest])
        return ((velocities[0] - velocities[1]) / (2.0 * time)).ravel()


def _reach(pieces: list[tuple[coal.CollisionGeometry, pin.SE3]]) -> tuple[np.ndarray, float]:
    """A ball around all pieces of a body, in its joint's frame: centre [m] and radius [m]."""
    balls = []
    for shape, placement in pieces:
        shape.computeLocalAABB()
        balls.append((placement.act(np.array(shape.aabb_center)), float(shape.aabb_radius)))
    centre = np.mean([middle for middle, _ in balls], axis=0)
    return centre, max(float(np.linalg.norm(middle - centre)) + r for middle, r in balls)
