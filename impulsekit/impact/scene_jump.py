"""Δv of a scene with constraints or contacts: M Δv = I + Aᵀλ + JᵀP, A v⁺ = b, P by law.

The core has the scene. For each state it builds rows and mass matrix, eliminates the bilateral
rows, solves the law of contact in what is left, and measures the answer, in one call.
"""

from __future__ import annotations

from collections.abc import Container, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from .._core import Failure, Inputs, SceneImpact, solve_scene
from ..errors import ContradictionError, InputError
from ..scene.scene import SceneCache
from .flat.law import contact_law
from .flat.scene import NamedPoint, check_directions, flat_of
from .singular import singular_joints, singular_mass

if TYPE_CHECKING:
    from .._core import StateRows
    from ..scene import Scene

__all__ = ["SceneJump", "Solved", "jump_of"]

# Rows that contradict each other are named, so many at most.
MOST_NAMED = 6


class Solved(NamedTuple):
    """An impact as the core solved it.

    Attributes:
        jump: by which. scene: that it is of. core: the impact, with all that it was solved from.
    """

    jump: SceneJump
    scene: Scene
    core: SceneImpact


class SceneJump:
    """Δv under bilateral rows and contacts.

    Attributes:
        flat, law: the scene and its law in the core.
    """

    def __init__(self, scene: Scene) -> None:
        self.flat, self.law = flat_of(scene), contact_law(scene)
        self._count = len(scene.contacts)
        self._without: dict[tuple[str, ...], Scene] = {}
        self._is_given = bool(self.flat.functions or self.flat.contact_functions)

    def solve(
        self,
        scene: Scene,
        q: np.ndarray,
        v: np.ndarray,
        touching: Container[int] | None = None,
        features: Sequence[NamedPoint] | None = None,
        numbers: np.ndarray | None = None,
    ) -> Solved:
        """Return the impact at q and v.

        A joint whose control keeps its velocity and whose stop turns it back has no solution: the
        stop is the stiffer of the two, and the scene that is solved is without that control.

        ``touching``: the indices of the contacts that take part; None for all that touch.
        ``features``: the points of bodies by contact; None for those within the margin.
        ``numbers``: (columns,) of the known impulses; None for their own.

        Raises:
            ContradictionError: dependent rows demand different things.
            SingularMassError: M is singular and the constraints do not make up for it.
            InputError, RangeError: what the contact law refuses.
        """
        inputs = self._inputs(q, touching, features)
        own = self.flat.impulses if numbers is None else numbers[self.flat.order]
        found = solve_scene(self.flat.core, self.law, q, v, own, inputs)
        return self.solved(scene, found)

    def rows(
        self,
        q: np.ndarray,
        v: np.ndarray,
        touching: Container[int] | None,
        features: Sequence[NamedPoint] | None,
    ) -> StateRows:
        """Return the rows of an impact, see ``solve``."""
        return self.flat.core.rows(q, v, None, self._inputs(q, touching, features))

    def _inputs(
        self,
        q: np.ndarray,
        touching: Container[int] | None,
        features: Sequence[NamedPoint] | None,
    ) -> Inputs | None:
        more: dict[str, Any] = self.flat.given(q) if self._is_given else {}
        if touching is not None:
            more["only"] = [i in touching for i in range(self._count)]
        if features is not None:
            more["features"] = features
        return Inputs(**more) if more else None

    def solved(self, scene: Scene, found: SceneImpact) -> Solved:
        """Return an impact that the core has solved.

        Raises:
            As ``solve``.
        """
        if not found.is_solved:
            self._refuse(scene, found)
        if scene.controlled and found.rows.yielded:
            scene = self._freed(scene, found.rows.yielded)
            return Solved(jump_of(scene), scene, found)
        return Solved(self, scene, found)

    def _freed(self, scene: Scene, yielded: list[int]) -> Scene:
        """The scene without the controls of joints that their stops turn back."""
        slices = self.flat.slices[len(scene.constraints) :]
        left = tuple(
            name
            for name, where in zip(scene.controlled, slices, strict=True)
            if where.start not in yielded
        )
        if left not in self._without:
            self._without[left] = replace(scene, controlled=left)
        return self._without[left]

    def _refuse(self, scene: Scene, found: SceneImpact) -> None:
        """Raise the error of an impact without a solution."""
        check_directions(found.rows)
        solution = found.solution
        if solution.failure == Failure.refused:
            raise InputError(solution.contact.refused)
        if solution.failure == Failure.singular_mass:
            model, rows = scene.robot.model, found.rows.A.reshape(-1, scene.robot.nv)
            masses = self.flat.model.core.mass_matrix(found.q).reshape(model.nv, model.nv)
            raise singular_mass(model, singular_joints(model, masses, rows))
        names = [self.flat.names[i] for i in solution.failed]
        named = ", ".join(names[:MOST_NAMED]) + (", …" if len(names) > MOST_NAMED else "")
        raise ContradictionError(
            f"these rows cannot hold together: {named}; they are dependent and their velocities "
            f"after the impact are {solution.apart:.3g} apart. Leave one out, or prescribe "
            "velocities that agree",
            rows=tuple(names),
        )


def jump_of(scene: Scene) -> SceneJump:
    """The solver of a scene, made once and kept with it."""
    return _jumps.of(scene)


_jumps: SceneCache[SceneJump] = SceneCache(SceneJump)
