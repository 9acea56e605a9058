"""What the derivatives of a scene's impacts share: the tree, the pairs, Pinocchio's data."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from ...robot.masses import is_always_regular
from ...rows.constraints import needs_places
from ...rows.entries import frame_pair, rows_of_entry, vectors_of_rows
from ...rows.reach import reached_model
from ...scene import (
    AppliedImpulse,
    Collision,
    JointStop,
    Law,
    Rope,
    Scene,
)
from ...scene.constraints import KEPT
from ...scene.scene import KeptByThread
from ..solver import ImpactSolver
from .expanded import expanded_model
from .linear import Columns
from .pairs import FixedRows, PairRows, entry_rows

if TYPE_CHECKING:
    from .meeting import Meetings

__all__ = ["Workspace", "workspace_of"]


class Workspace:
    """The parts of a scene that stay from state to state. It does not hold the scene.

    Attributes:
        blows: by impulse of the scene, its six rows; for a joint impulse its unit rows.
        bilateral: by constraint of the scene, its rows.
        kept: (m,) True for rows whose velocity is kept.
        vectors: (m,) which rows are axes of one velocity.
        impulses: by impulse of the scene, its wrench or joint impulse.
        model, data: the robot at rest in no gravity; ``data`` is that of ``expanded``.
        blow_columns: by impulse of the scene, its columns behind those of q and v.
        width_of_state: how many columns are of q, v and the blows; redundant rows have to
            agree on them, while those of coefficients are told by NaN alone.
        is_newton: whether the law is Newton's, with slip at the end.
        always_regular: whether M is regular at every configuration.
        singular: whether it is singular at every one, so that bilateral rows have to fill it.
        expanded: the model in which every axis stands still in its body.
    """

    def __init__(self, scene: Scene) -> None:
        robot = scene.robot
        every_joint = range(1, robot.model.njoints)
        self._reached = reached_model(
            robot.model, every_joint, keep_places=needs_places(robot, scene)
        )
        self.model = self._reached.model
        self.expanded = expanded_model(self.model)
        self.data = self.expanded.model.createData()
        self.is_newton = scene.law.restitution == "newton" and scene.law.slip == "end"
        self.always_regular = is_always_regular(self.model)
        self.singular = bool(robot.massless_motions)
        self.identity = np.eye(self.model.nv)
        self.no_rows = np.zeros((0, self.model.nv))
        self.identity.setflags(write=False)
        # Pinocchio is quicker when it is told of no outside forces than when it is not told.
        self.no_forces = pin.StdVec_Force()
        for _ in range(self.expanded.model.njoints):
            self.no_forces.append(pin.Force.Zero())
        self.blows: list[PairRows | FixedRows] = []
        self.impulses: list[np.ndarray] = []
        for entry in scene.impulses:
            self.blows.append(entry_rows(robot, self.expanded, entry))
            own = (
                np.array([*entry.linear, *entry.angular])
                if isinstance(entry, AppliedImpulse)
                else np.atleast_1d(np.array(entry.impulse, dtype=float))
            )
            self.impulses.append(own)
        self.blow_names = scene.entry_names("impulses")
        self.constraint_names = scene.entry_names("held")
        self.contact_names = scene.entry_names("contacts")
        at = 2 * self.model.nv
        self.blow_columns: dict[str, slice] = {}
        for name, impulse in zip(self.blow_names, self.impulses, strict=True):
            self.blow_columns[name] = slice(at, at + len(impulse))
            at += len(impulse)
        self.width_of_state = at
        self._contacts: dict[int, PairRows] = {}
        self._meetings: dict[int, Meetings] = {}
        self._columns: dict[tuple[int, ...], Columns] = {}
        self.bilateral: list[PairRows | FixedRows] = []
        kept: list[bool] = []
        for constraint in scene.held:
            rows = entry_rows(robot, self.expanded, constraint)
            self.bilateral.append(rows)
            kept += [constraint.velocity == KEPT] * rows.count
        self.kept = np.array(kept, dtype=bool)
        self.vectors = vectors_of_rows(rows_of_entry(robot, entry) for entry in scene.held)
        self.any_kept = any(kept)
        self._robot, self._parts = robot, (scene.impulses, scene.held, scene.contacts)

    def configuration(self, q: np.ndarray) -> np.ndarray:
        """The configuration of the expanded model, with the roots where it has them."""
        return self.expanded.configuration(self._reached.configuration(q))

    def columns(self, entries: tuple[int, ...]) -> Columns:
        """The parameters of an impact in which these contacts touch."""
        found = self._columns.get(entries)
        if found is None:
            once, nv = list(dict.fromkeys(entries)), self.model.nv
            at = self.width_of_state
            own = [slice(i, i + 1) for i in range(at, at + 2 * len(once))]
            found = Columns(
                self.width_of_state + 2 * len(once),
                slice(0, nv),
                slice(nv, 2 * nv),
                dict(zip(once, own[: len(once)], strict=True)),
                dict(zip(once, own[len(once) :], strict=True)),
                names=tuple(self.contact_names[i] for i in once),
            )
            self._columns[entries] = found
        return found

    def meetings(self, entry: int) -> Meetings:
        """What is known of the geometry of a ``Collision``, by its place in the scene."""
        found = self._meetings.get(entry)
        if found is None:
            from .meeting import Meetings

            collision, name = self._parts[2][entry], self.contact_names[entry]
            if not isinstance(collision, Collision):
                raise TypeError(type(collision).__name__)
            found = Meetings(self._robot, self.expanded, collision, name)
            self._meetings[entry] = found
        return found

    def touching_rows(self, index: int) -> PairRows:
        """The rows of a ``Contact`` of the scene."""
        rows = self._contacts.get(index)
        if rows is None:
            said = frame_pair(self._robot, self._parts[2][index])
            rows = self._contacts[index] = PairRows(self.expanded, said)
        return rows

    @cached_property
    def compression(self) -> ImpactSolver:
        """The solver whose answer is the end of the compression: no restitution."""
        impulses, constraints, contacts = self._parts
        plastic = [
            replace(entry, restitution=0.0)
            if isinstance(entry, JointStop | Rope)
            else replace(entry, restitution=0.0, tangential_restitution=0.0)
            for entry in contacts
        ]
        return ImpactSolver(Scene(self._robot, impulses, constraints, plastic, law=Law()))


_kept = KeptByThread(Workspace)


def workspace_of(scene: Scene) -> Workspace:
    """The workspace that this thread keeps for a scene.

    Raises:
        InputError: the robot has joints that derivatives do not take.
    """
    return _kept.of(scene)
