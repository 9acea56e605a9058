"""What the derivatives of a scene's impacts share: the tree, the pairs, Pinocchio's data."""

from __future__ import annotations

import threading
import weakref
from dataclasses import replace
from functools import cached_property

import numpy as np
import pinocchio as pin

from ...errors import InputError
from ...scene import AppliedImpulse, FrameAnchor, JointStop, Law, PointAnchor, Scene
from ...scene.constraints import KEPT
from ..plan import _VARYING_SUBSPACE
from ..reach import reached_model
from ..rows import needs_places
from ..solver import ImpactSolver
from .motion import Tree
from .pairs import FixedRows, PairRows, anchor_rows, blow_rows, joint_rows

__all__ = ["Workspace", "workspace_of"]


class Workspace:
    """The parts of a scene that stay from state to state. It does not hold the scene.

    Attributes:
        blows: by impulse of the scene, its six rows; for a joint impulse its unit rows.
        bilateral: by constraint of the scene, its rows.
        kept: (m,) True for rows whose velocity is kept.
        impulses: by impulse of the scene, its wrench or joint impulse.
    """

    def __init__(self, scene: Scene) -> None:
        robot = scene.robot
        for joint in robot.model.joints:
            if joint.shortname() in _VARYING_SUBSPACE:
                raise InputError(
                    f"derivatives: a joint of kind {joint.shortname()} moves along axes that turn "
                    "with its own coordinates, or follows another joint; such joints are not taken"
                )
        every_joint = range(1, robot.model.njoints)
        self._reached = reached_model(
            robot.model, every_joint, keep_places=needs_places(robot, scene)
        )
        self.model = self._reached.model
        self.data = self.model.createData()
        self.tree = Tree(self.model)
        self.zero = np.zeros(self.model.nv)
        self.identity = np.eye(self.model.nv)
        self.identity.setflags(write=False)
        self._no_force = pin.Force.Zero()
        self._forces = pin.StdVec_Force()
        for _ in range(self.model.njoints):
            self._forces.append(self._no_force)
        frames = robot.model.frames
        names = {
            n
            for entry in (*scene.impulses, *scene.constraints, *scene.contacts)
            for n in entry.frame_names
        }
        # The joints whose bodies a scene pushes.
        self._pushed = sorted({frames[robot.frame_id(name)].parentJoint for name in names} - {0})
        self.blows: list[PairRows | FixedRows] = []
        self.impulses: list[np.ndarray] = []
        for entry in scene.impulses:
            if isinstance(entry, AppliedImpulse):
                self.blows.append(blow_rows(robot, entry))
                self.impulses.append(np.array([*entry.linear, *entry.angular]))
            else:
                joint = self.model.joints[robot.joint_id(entry.joint)]
                unit = np.eye(self.model.nv)[joint.idx_v : joint.idx_v + joint.nv]
                self.blows.append(FixedRows(unit))
                self.impulses.append(np.atleast_1d(np.array(entry.impulse, dtype=float)))
        self.blow_names = scene.entry_names("impulses")
        self.blow_rows = sum(len(impulse) for impulse in self.impulses)
        self.bilateral: list[PairRows | FixedRows] = []
        kept: list[bool] = []
        for constraint in scene.constraints:
            if isinstance(constraint, PointAnchor | FrameAnchor):
                anchor = anchor_rows(robot, constraint)
                self.bilateral.append(anchor)
                count = len(anchor.select)
            else:
                fixed = joint_rows(robot, constraint)
                self.bilateral.append(fixed)
                count = len(fixed.matrix)
            kept += [constraint.velocity == KEPT] * count
        self.kept = np.array(kept, dtype=bool)
        self._robot, self._parts = robot, (scene.impulses, scene.constraints, scene.contacts)

    def configuration(self, q: np.ndarray) -> np.ndarray:
        """q with the roots where the model of this workspace has them."""
        return self._reached.configuration(q)

    def no_forces(self) -> pin.StdVec_Force:
        """A zero force for each joint, to be added to; there is one, and each call clears it."""
        for joint_id in self._pushed:
            self._forces[joint_id] = self._no_force
        return self._forces

    @cached_property
    def compression(self) -> ImpactSolver:
        """The solver whose answer is the end of the compression: no restitution."""
        impulses, constraints, contacts = self._parts
        plastic = [
            replace(entry, restitution=0.0)
            if isinstance(entry, JointStop)
            else replace(entry, restitution=0.0, tangential_restitution=0.0)
            for entry in contacts
        ]
        return ImpactSolver(Scene(self._robot, impulses, constraints, plastic, law=Law()))


class _Kept(threading.local):
    """The workspaces of this thread, by the identity of their scene."""

    def __init__(self) -> None:
        self.by_scene: dict[int, Workspace] = {}


_kept = _Kept()


def workspace_of(scene: Scene) -> Workspace:
    """The workspace that this thread keeps for a scene.

    Raises:
        InputError: the robot has joints that derivatives do not take.
    """
    workspace = _kept.by_scene.get(id(scene))
    if workspace is None:
        workspace = Workspace(scene)
        _kept.by_scene[id(scene)] = workspace
        weakref.finalize(scene, _kept.by_scene.pop, id(scene), None)
    return workspace
