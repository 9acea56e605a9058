"""Results of a solve besides Δv: the impulses of constraints and of contacts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..scene import JointStop
from .contact_law import ContactSolution

if TYPE_CHECKING:
    from .._core import Feature, StateRows
    from ..scene import Scene
    from .flat.scene import FlatScene
    from .scene_jump import Solved

__all__ = ["Outcome", "Touch", "outcome_of", "touches_of"]


class Touch(NamedTuple):
    """One touching point.

    Attributes:
        entry: the index of the contact in the scene.
        axes: (3, 3) columns t₁, t₂, n in the world; None for a joint stop.
        joint_ids, frame_ids: of the two bodies in the robot's model, first the one that
            receives the impulse; (0, 0) for a joint stop and for a gap that is a function.
        jacobian: (3, nv) rows of the relative velocity along the axes.
        position: (3,) world [m]; None for a joint stop and for a gap that is a function.
        gap: [m], of a joint stop [rad, m].
        turns: −1; where the rows are those of the relative turning, Rᵀ (ω_frame − ω_against)
            [rad/s], the index of the touch whose point they belong to.
        feature: the name of the point where two bodies of any shapes touch.
    """

    entry: int
    axes: np.ndarray | None
    joint_ids: tuple[int, int]
    frame_ids: tuple[int, int]
    jacobian: np.ndarray
    position: np.ndarray | None = None
    gap: float | None = None
    turns: int = -1
    feature: Feature | None = None


@dataclass(frozen=True, eq=False)
class Outcome:
    """Results of a solve besides Δv.

    Attributes:
        constraint_impulses: (m,) λ by row of the bilateral constraints.
        unique: (m,) whether each is determined; None where all are.
        touches: the points at which contacts touched.
        contacts: the impulses there, by the law; None where nothing touched.
        nearly_dependent: whether rows were taken for dependent that are so only nearly.
        residuals: of the momentum, the constraints and the contacts, relative.
    """

    constraint_impulses: np.ndarray
    unique: np.ndarray | None
    touches: tuple[Touch, ...] = ()
    contacts: ContactSolution | None = None
    nearly_dependent: bool = False
    residuals: tuple[float, float, float] = (0.0, 0.0, 0.0)


def touches_of(rows: StateRows, flat: FlatScene, scene: Scene) -> tuple[Touch, ...]:
    """The touching points of a state, and after them the turning of those that resist it."""
    entries, turning_of, of_bodies = rows.entries, rows.turning_of, rows.of_bodies
    if not entries:
        return ()
    blocks = rows.J.reshape(len(entries) + len(turning_of), 3, -1)
    axes, places, gaps = rows.axes.reshape(-1, 3, 3), rows.places.reshape(-1, 3), rows.gaps
    features = rows.features if flat.shaped else ()
    points = [
        Touch(
            entry,
            None if isinstance(scene.contacts[entry], JointStop) else axes[i],
            *flat.ends[entry],
            blocks[i],
            places[i] if of_bodies[i] else None,
            float(gaps[i]),
            feature=features[i] if entry in flat.shaped else None,
        )
        for i, entry in enumerate(entries)
    ]
    turning = [
        points[i]._replace(jacobian=blocks[len(points) + k], turns=i)
        for k, i in enumerate(turning_of)
    ]
    return (*points, *turning)


def outcome_of(solved: Solved) -> Outcome:
    """Return the core's results for an impact of a scene."""
    solution = solved.core.solution
    unique = solution.unique
    touches = touches_of(solved.core.rows, solved.jump.flat, solved.scene)
    return Outcome(
        solution.multipliers,
        None if unique.all() else unique,
        touches,
        ContactSolution.of(solution.contact) if touches else None,
        solution.nearly_dependent,
        (solution.momentum_residual, solution.constraint_residual, solution.contact_residual),
    )
