"""What the derivatives of a scene's impacts share from state to state."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property

import numpy as np

from ...scene import JointStop, Law, Rope, Scene
from ...scene.constraints import KEPT
from ...scene.scene import KeptByThread
from ..flat.scene import flat_of
from ..solver import ImpactSolver
from .linear import Columns

__all__ = ["Workspace", "workspace_of"]


class Workspace:
    """The parts of a scene that stay from state to state. It does not hold the scene.

    Attributes:
        flat: the scene in the core.
        model: the robot's.
        kept: (m,) True for bilateral rows whose velocity is kept.
        vectors: (m,) which rows are axes of one velocity.
        impulses: by impulse of the scene, its wrench or joint impulse.
        constraint_names, contact_names: of the scene.
        blow_columns: by impulse of the scene, its columns behind those of q and v.
        width_of_state: how many columns are of q, v and the blows; redundant rows have to
            agree on them, while those of coefficients are told by NaN alone.
    """

    def __init__(self, scene: Scene) -> None:
        robot = scene.robot
        self.flat, self.model = flat_of(scene), robot.model
        self.impulses = [np.array(entry.values) for entry in scene.impulses]
        self.constraint_names = scene.entry_names("held")
        self.contact_names = scene.entry_names("contacts")
        at = 2 * robot.nv
        self.blow_columns: dict[str, slice] = {}
        for name, impulse in zip(scene.entry_names("impulses"), self.impulses, strict=True):
            self.blow_columns[name] = slice(at, at + len(impulse))
            at += len(impulse)
        self.width_of_state = at
        kept: list[bool] = []
        for constraint, rows in zip(scene.held, self.flat.slices, strict=True):
            kept += [constraint.velocity == KEPT] * (rows.stop - rows.start)
        self.kept, self.vectors = np.array(kept, dtype=bool), self.flat.vectors
        self._robot, self._parts = robot, (scene.impulses, scene.held, scene.contacts)

    def columns(self, entries: tuple[int, ...]) -> Columns:
        """The parameters of an impact in which these contacts touch."""
        once, nv = list(dict.fromkeys(entries)), self.model.nv
        at = self.width_of_state
        own = [slice(i, i + 1) for i in range(at, at + 2 * len(once))]
        return Columns(
            self.width_of_state + 2 * len(once),
            slice(0, nv),
            slice(nv, 2 * nv),
            dict(zip(once, own[: len(once)], strict=True)),
            dict(zip(once, own[len(once) :], strict=True)),
            names=tuple(self.contact_names[i] for i in once),
        )

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
        InputError: the robot has joints that the core does not know.
    """
    return _kept.of(scene)
