"""The bodies of a replay: one node for each joint, its frames, and ghosts of single poses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
import pinocchio as pin

from .bodies import BodyShape, body_shapes, corners_of
from .drawing import ROOT, Drawing, node_name
from .motions import Shown

# [m] The size of what has none, to draw it at all.
LEAST_REACH = 1e-6

GHOST_OPACITY = 0.22
# For the camera's fit a motion is looked at in so many poses.
LOOKS = 60


@dataclass(frozen=True, eq=False)
class Actors:
    """A robot's shapes and where its joints are in every frame.

    Attributes:
        shown: the motion.
        shapes: the surfaces on its joints.
        places: (F, njoints, 7) of every joint in the world, xyz [m] and quaternion xyzw.
        corners: (n, 3) corners of boxes around the shapes over the motion [m].
        subject: (m, 3) those of what moves, for the middle of the picture [m].
        reach: between the radius of one pose and that of the motion [m]; arrows go by it.
        notes: what is drawn otherwise than wished.
    """

    shown: Shown
    shapes: tuple[BodyShape, ...]
    places: np.ndarray
    corners: np.ndarray
    subject: np.ndarray
    reach: float
    notes: tuple[str, ...]

    @classmethod
    def of(cls, shown: Shown, times: np.ndarray) -> Actors:
        """The actors of a motion at (F,) ``times`` of it [s]."""
        shapes, notes = body_shapes(shown.robot)
        places = joint_places(shown, times)
        looks = np.unique(np.linspace(0, len(times) - 1, min(LOOKS, len(times))).astype(int))
        own = [corners_of(shapes, joint_id) for joint_id in range(places.shape[1])]
        poses = [_corners(own, places[i]) for i in looks]
        corners = np.concatenate(poses)
        moves = np.ptp(places, axis=0).max(axis=1) > 0.0
        moving = [x for x, one in zip(own, moves, strict=True) if one]
        subject = [_corners(moving, places[i, moves]) for i in looks] if moves.any() else poses
        size = max(float(np.linalg.norm(np.ptp(pose, axis=0))) for pose in poses)
        whole = float(np.linalg.norm(np.ptp(corners, axis=0)))
        reach = max(0.5 * float(np.sqrt(size * whole)), LEAST_REACH)
        return cls(shown, shapes, places, corners, np.concatenate(subject), reach, notes)

    @property
    def nodes(self) -> Mapping[str, str]:
        """By joint name, the path of its node in the player."""
        names = self.shown.robot.joint_names
        return MappingProxyType(
            {name: "/" + "/".join((ROOT, *_node(i + 1, name))) for i, name in enumerate(names)}
        )

    @property
    def names(self) -> list[tuple[str, str]]:
        """The node of every shape, with what the page calls it: its link and its joint."""
        joints = ("world", *self.shown.robot.joint_names)
        found = []
        for joint_id, joint in enumerate(joints):
            own = [shape for shape in self.shapes if shape.joint_id == joint_id]
            for i, shape in enumerate(own):
                path = "/".join((ROOT, *_node(joint_id, joint), node_name(i, shape.name)))
                behind = f", joint {joint}" if joint_id > 0 else ", fixed"
                found.append((f"/{path}", f"{shape.body or shape.name}{behind}"))
        return found

    @property
    def followed(self) -> list[tuple[str, float, list[float]]]:
        """The node, mass [kg] and mass centre in the node [m] of every moving joint."""
        model = self.shown.robot.model
        return [
            (path, float(body.mass), np.asarray(body.lever).tolist())
            for path, body in zip(self.nodes.values(), list(model.inertias)[1:], strict=True)
            if body.mass > 0.0
        ]

    def draw(self, drawing: Drawing, times: np.ndarray) -> None:
        """Draw the bodies and let them move at (F,) playback ``times`` [s]."""
        names = ("world", *self.shown.robot.joint_names)
        for joint_id, name in enumerate(names):
            own = [shape for shape in self.shapes if shape.joint_id == joint_id]
            if joint_id > 0:
                drawing.move(_node(joint_id, name), times, self.places[:, joint_id])
            for i, shape in enumerate(own):
                path = (*_node(joint_id, name), node_name(i, shape.name))
                drawing.add(path, shape.surface, shape.color)
                drawing.place(path, shape.placement)

    def draw_ghosts(self, drawing: Drawing, instants: Sequence[float]) -> None:
        """Draw faint copies of the moving bodies at ``instants`` of the motion [s]."""
        if not instants:
            return
        poses = joint_places(self.shown, np.array(instants))
        for i, shape in enumerate(self.shapes):
            if shape.joint_id == 0:
                continue
            placements = [
                pin.XYZQUATToSE3(pose[shape.joint_id]) * shape.placement for pose in poses
            ]
            color = (*shape.color[:3], GHOST_OPACITY)
            drawing.add(("ghosts", node_name(i, shape.name)), shape.surface, color, placements)


def joint_places(shown: Shown, times: np.ndarray) -> np.ndarray:
    """(F, njoints, 7) where the joints are at (F,) ``times`` of a motion [s]."""
    model = shown.robot.model
    data = model.createData()
    places = np.empty((len(times), model.njoints, 7))
    for row, q in zip(places, shown.at(times), strict=True):
        pin.forwardKinematics(model, data, q)
        for joint_id, placement in enumerate(data.oMi):
            row[joint_id] = pin.SE3ToXYZQUAT(placement)
    return places


def _node(joint_id: int, name: str) -> tuple[str, str]:
    return ("bodies", node_name(joint_id, name))


def _corners(own: Sequence[np.ndarray], pose: np.ndarray) -> np.ndarray:
    """(n, 3) corners in one pose, in the world; joints where there is no shape.

    ``own``: (n, 3) corners of the shapes on each joint, in its frame.
    """
    found = [
        corners @ placement.rotation.T + placement.translation
        for corners, place in zip(own, pose, strict=True)
        if len(corners)
        for placement in (pin.XYZQUATToSE3(place),)
    ]
    return np.concatenate(found) if found else pose[:, :3]
