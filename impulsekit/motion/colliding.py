"""The gap of two bodies whose points of contact coal finds."""

from __future__ import annotations

from dataclasses import dataclass

import coal
import numpy as np
import pinocchio as pin

from ..impact.collision import convex_geometry, meeting_points, smallest_gap
from ..impact.reach import ReachedModel
from ..impact.touching import contact_axes
from ..robot import Robot
from ..robot.geometry import geometry_ids
from ..scene import Collision
from .corners import corners_of, nearest, point_gap
from .points import cross

__all__ = ["CollidingGap"]

# A resting pair is looked for up to this far apart [m].
RESTING = 1e-5
# Bodies with corners that approach more slowly stay [m/s]: they would hop some 1e-9 m high.
SLOW = 2e-4
# Corners that rise more slowly rest: they would hop some 5e-12 m high. That much speed [m/s] is
# left by impacts, whose points are those of coal's patches.
RISING = 1e-5
# How far the bodies move for the rates of their rows [m, rad].
MOVE = 1e-4
# Corners further away than this are not looked at more closely [m].
NEAR_CORNER = 1e-3


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
        # Corners stay on their bodies; on smooth bodies the points of contact wander.
        self._corners = [
            corners for own in self._pieces if (corners := corners_of(own)) is not None
        ]
        self.has_corners = len(self._corners) == 2
        # Hops lower than what coal can tell are none.
        self.capture_speed = SLOW if self.has_corners else 0.0
        self.rest_speed = RISING if self.has_corners else 0.0
        self._held: list[_HeldPoint] | None = None

    @property
    def smaller_radius(self) -> float:
        """Of the balls around the two bodies that of the smaller one [m]."""
        return min(radius for _, radius in self._reaches)

    def _placed(self, data: pin.Data) -> list:
        return [
            [(shape, data.oMi[joint_id] * placement) for shape, placement in pieces]
            for pieces, joint_id in zip(self._pieces, self._joint_ids, strict=True)
        ]

    def distance(self, data: pin.Data) -> float:
        """The gap [m], negative where they overlap; ``data`` with placements."""
        first, other = self._placed(data)
        return smallest_gap(first, other)

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

    def hold(self, data: pin.Data | None) -> None:
        """Take the points that touch now as fixed on both bodies, or with None let go of them.

        Only for bodies with corners; ``data`` with placements.
        """
        self._held = None
        if data is None or not self.has_corners:
            return
        first, other = self._placed(data)
        places = [data.oMi[joint_id] for joint_id in self._joint_ids]
        self._held = []
        for point in meeting_points(first, other, self._margin):
            position, corner = point.position, self._corner_at(places, point.position)
            if corner is not None:
                gap = self._corner_gap(data, [first, other], corner, point.normal)
                # A corner that has slid off the face is no corner on it.
                corner = corner if abs(gap) <= RESTING else None
            if corner is not None:
                if any(held.corner == corner for held in self._held):
                    continue
                position = places[corner[0]].act(self._corners[corner[0]][corner[1]])
            on_bodies = (places[0].actInv(position), places[1].actInv(position))
            plane = 0 if corner is not None and corner[0] == 1 else 1
            axes = places[plane].rotation.T.dot(contact_axes(point.normal))
            # Where edges cross it is that of the bodies: no face tells the point's own.
            gap = smallest_gap(first, other)
            self._held.append(_HeldPoint(on_bodies, axes, plane, gap, corner))

    def _corner_at(self, places: list[pin.SE3], position: np.ndarray) -> tuple[int, int] | None:
        """Which body's corner a point of the world is, and which of its corners."""
        for side, corners in enumerate(self._corners):
            found = nearest(corners, places[side].actInv(position))
            if found is not None:
                return side, found
        return None

    def held_gaps(self, data: pin.Data) -> np.ndarray:
        """(k,) the gap of each held point [m]; ``data`` with placements."""
        placed = self._placed(data)
        places = [data.oMi[joint_id] for joint_id in self._joint_ids]
        found = []
        for point in self._held or ():
            normal = point.normal(places)
            if point.corner is None:
                # Where two edges cross: how far they have come since they were taken hold of.
                first, other = (place.act(at) for place, at in zip(places, point.at, strict=True))
                way = first - other
                found.append(point.gap + float(normal.dot(way)))
            else:
                found.append(self._corner_gap(data, placed, point.corner, normal))
        return np.array(found)

    def free_corner(self, data: pin.Data) -> float:
        """The smallest gap of a corner that is near but not held [m]; infinite for none."""
        if not self._held:
            return np.inf
        placed, point = self._placed(data), self._held[0]
        places = [data.oMi[joint_id] for joint_id in self._joint_ids]
        normal = point.normal(places)
        ground = float(normal.dot(places[point.carrier].act(point.at[point.carrier])))
        held = {held.corner for held in self._held}
        least = np.inf
        for side, place in enumerate(places):
            sign = 1.0 if side == 0 else -1.0
            world = self._corners[side].dot(place.rotation.T) + place.translation
            centre, radius = self._reaches[1 - side]
            centre = places[1 - side].act(centre)
            near = sign * (world.dot(normal) - ground) < NEAR_CORNER
            near &= np.linalg.norm(world - centre, axis=1) < radius + NEAR_CORNER
            for i in np.flatnonzero(near).tolist():
                if (side, i) not in held:
                    least = min(least, self._corner_gap(data, placed, (side, i), normal))
        return least

    def _corner_gap(
        self, data: pin.Data, placed: list, corner: tuple[int, int], normal: np.ndarray
    ) -> float:
        side, i = corner
        at = data.oMi[self._joint_ids[side]].act(self._corners[side][i])
        return point_gap(at, normal if side == 0 else -normal, placed[1 - side])

    @property
    def holds(self) -> bool:
        """Whether points are held."""
        return self._held is not None

    def keep(self, points: np.ndarray) -> None:
        """Let go of held points but those told: (k,) True for what stays."""
        self._held = [p for p, stays in zip(self._held or (), points, strict=True) if stays]

    def _held_rows(self, data: pin.Data) -> np.ndarray:
        rows = np.zeros((3 * len(self._held or ()), self._model.nv))
        places = [data.oMi[joint_id] for joint_id in self._joint_ids]
        for i, point in enumerate(self._held or ()):
            position = places[point.carrier].act(point.at[point.carrier])
            difference = np.zeros((3, self._model.nv))
            for sign, joint_id in zip((1.0, -1.0), self._joint_ids, strict=True):
                if joint_id > 0:
                    at = pin.SE3(np.eye(3), data.oMi[joint_id].actInv(position))
                    jacobian = pin.getFrameJacobian(
                        self._model, data, joint_id, at, pin.LOCAL_WORLD_ALIGNED
                    )
                    difference += sign * jacobian.reshape(6, -1)[:3]
            axes = places[point.plane].rotation.dot(point.axes_in_plane)
            rows[3 * i : 3 * i + 3] = axes.T.dot(difference)
        return rows

    def _held_bias(self, data: pin.Data) -> np.ndarray:
        """As ``Pair.bias``: the point of one body, that of the other which coincides, its axes."""
        found = []
        for point in self._held or ():
            own, plane = self._joint_ids[point.carrier], self._joint_ids[point.plane]
            place, ground = data.oMi[own], data.oMi[plane]
            turning = ground.rotation.dot(data.v[plane].angular)
            at = point.at[point.carrier]
            velocity, rate = _point_motion(data.v[own], data.a[own], at)
            velocity, rate = place.rotation.dot(velocity), place.rotation.dot(rate)
            there = ground.actInv(place.act(at))
            below, below_rate = _point_motion(data.v[plane], data.a[plane], there)
            below, below_rate = ground.rotation.dot(below), ground.rotation.dot(below_rate)
            # The coinciding point moves over its body at the velocity between the two.
            rate = rate - below_rate - 2.0 * cross(turning, velocity - below)
            axes = ground.rotation.dot(point.axes_in_plane)
            found.append((1.0 if point.carrier == 0 else -1.0) * axes.T.dot(rate))
        return np.concatenate(found) if found else np.empty(0)

    def rows(self, data: pin.Data, q: np.ndarray) -> np.ndarray:
        """(3k, nv) of all points that touch."""
        return self._points(data)[0] if self._held is None else self._held_rows(data)

    def bias(self, data: pin.Data, q: np.ndarray, v: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """(3k,) the rows' rates along the motion, by central differences.

        The points wander over the bodies as these roll, so no point of either tells them.
        """
        if self._held is not None:
            return self._held_bias(data)
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


@dataclass(frozen=True, eq=False)
class _HeldPoint:
    """A point that touches: carried along by one body over a plane of the other.

    Attributes:
        at: (3,) where it was on either body, in the frames of their joints.
        axes_in_plane: (3, 3) t₁, t₂, n in the frame of the body with the plane.
        plane: which body that is, 0 or 1.
        gap: [m] when it was taken hold of.
        corner: which body's it is, 0 or 1, and which of its corners; None where edges cross.
    """

    at: tuple[np.ndarray, np.ndarray]
    axes_in_plane: np.ndarray
    plane: int
    gap: float
    corner: tuple[int, int] | None

    @property
    def carrier(self) -> int:
        """The body that carries it along."""
        return 1 - self.plane

    def normal(self, places: list[pin.SE3]) -> np.ndarray:
        """(3,) n in the world, from the second body to the first."""
        return places[self.plane].rotation.dot(self.axes_in_plane[:, 2])


def _point_motion(v: pin.Motion, a: pin.Motion, at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(3,) velocity and (3,) acceleration of a body's point, in the body's axes."""
    spin = v.angular
    velocity = v.linear + cross(spin, at)
    return velocity, a.linear + cross(a.angular, at) + cross(spin, velocity)


def _reach(pieces: list[tuple[coal.CollisionGeometry, pin.SE3]]) -> tuple[np.ndarray, float]:
    """A ball around all pieces of a body, in its joint's frame: centre [m] and radius [m]."""
    balls = []
    for shape, placement in pieces:
        shape.computeLocalAABB()
        balls.append((placement.act(np.array(shape.aabb_center)), float(shape.aabb_radius)))
    centre = np.mean([middle for middle, _ in balls], axis=0)
    return centre, max(float(np.linalg.norm(middle - centre)) + r for middle, r in balls)
