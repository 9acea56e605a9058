"""Control beside impacts: what they cannot change, and the velocity after them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InputError, ShapeError, check_kind
from ..errors.calls import public
from ..formatting import OneLine
from ..impact import ImpactSolver
from ..robot import state
from ..robot.arrays import array_of, lock
from ..scene import Scene
from .response import Response

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

# Singular values below this share of the largest belong to directions that no impulse moves.
NOTHING = 1e-10


@public
@dataclass(frozen=True, eq=False, repr=False)
class ImpactInvariant(OneLine):
    """Velocities that impacts at the contacts of a scene cannot change, whenever they come.

    An impulse Λ at the contacts moves v by M⁻¹JᵀΛ. Rows N with N M⁻¹Jᵀ = 0 see the same velocity
    before, within and after the impact, so that feedback on N v needs no knowledge of its time
    (Yang & Posa, "Impact invariant control with applications to bipedal locomotion", 2021).

    Attributes:
        basis: (nv − r, nv) N: orthonormal rows, r the rank of the contacts.
        moved: (nv, m) M⁻¹Jᵀ, under the constraints of the scene.
        after: (nv, nv) v⁺ = after @ v⁻ where all contacts close with their restitution and those
            with friction stick: rows of the velocity after the impact for a QP.

    Example:
        >>> from impulsekit import Contact, Robot
        >>> ball = Robot.from_urdf("models/ball.urdf", root="freeflyer")
        >>> scene = Scene(ball, contacts=[Contact("ball", restitution=0.5)])
        >>> found = impact_invariant(scene, ball.neutral())
        >>> found.project([1, 2, 3, 0, 0, 0]).round(12)[:3].tolist()
        [1.0, 2.0, 0.0]
        >>> float(found.after[2, 2].round(9))
        -0.5
    """

    basis: np.ndarray
    moved: np.ndarray
    after: np.ndarray

    def project(self, v: ArrayLike) -> np.ndarray:
        """Return the part NᵀN v (nv,) of a velocity, or of its error, that no impact changes.

        Raises:
            ShapeError, NotFiniteError.
        """
        part: np.ndarray = self.basis.T @ (self.basis @ array_of(v, (len(self.after),), "v"))
        return part

    def corrected(self, jacobian: ArrayLike, wanted: ArrayLike, v: ArrayLike) -> np.ndarray:
        """Return the error (k,) of outputs ẏ = J_y v that the best impulse leaves.

        min over Λ of |wanted − J_y (v + M⁻¹JᵀΛ)|: errors that an impact could explain are not
        acted on.

        Args:
            jacobian: (k, nv) J_y.
            wanted: (k,) the desired ẏ.
            v: (nv,) the measured velocity.

        Raises:
            ShapeError, NotFiniteError.
        """
        rows = np.array(jacobian, dtype=float)
        nv = len(self.after)
        if rows.ndim != 2 or rows.shape[1] != nv:
            raise ShapeError.of("jacobian", ("k", nv), rows.shape)
        error = array_of(wanted, (len(rows),), "wanted") - rows @ array_of(v, (nv,), "v")
        push = rows @ self.moved
        impulse = np.linalg.lstsq(push, error, rcond=NOTHING)[0]
        left: np.ndarray = error - push @ impulse
        return left


@public
def impact_invariant(scene: Scene, q: ArrayLike) -> ImpactInvariant:
    """Return the velocities that impacts at a scene's contacts leave alone, at a configuration.

    Args:
        scene: its contacts that touch at q count, with their tangents where they have friction;
            its constraints hold. Its impulses are ignored.
        q: (nq,) configuration.

    Raises:
        InputError: no contact touches.
        ShapeError, NotFiniteError, StateError.

    Example:
        >>> from impulsekit import Contact, Robot
        >>> from impulsekit.models import pendulum_urdf
        >>> arm = Robot.from_urdf(pendulum_urdf(2))
        >>> wall = Contact("link_2", at=[0, 0, -1], normal=[1, 0, 0])
        >>> impact_invariant(Scene(arm, contacts=[wall], gap_bound=9), [0.1, 0.4]).basis.shape
        (1, 2)
    """
    check_kind(scene, Scene, "impact_invariant")
    robot = scene.robot
    place = state.checked_configuration(robot.model, q)
    bare = replace(scene, impulses=())
    outcome = ImpactSolver(bare).solve(place, robot.velocity()).outcome
    if outcome is None or not outcome.touches:
        raise InputError("impact_invariant: no contact touches at this configuration")
    rows, aims = [], []
    for touch in outcome.touches:
        entry: Any = scene.contacts[touch.entry]
        if touch.turns >= 0:
            raise InputError(
                "impact_invariant: not available with rolling or torsion, whose moments are not "
                "linear in the impulses; set both to 0"
            )
        if callable(entry.restitution):
            raise InputError(
                "impact_invariant: a restitution that depends on speed is not linear; give a number"
            )
        if getattr(entry, "friction", 0.0):
            rows.append(touch.jacobian[:2])
            aims += [getattr(entry, "tangential_restitution", 0.0)] * 2
        rows.append(touch.jacobian[2:])
        aims.append(entry.restitution)
    jacobian = np.vstack(rows)
    moved = Response(scene, place).mobility @ jacobian.T
    left, values, _ = np.linalg.svd(moved, full_matrices=True)
    rank = int((values > NOTHING * values.max(initial=0.0)).sum())
    basis = left[:, rank:].T.copy()
    aim = (1.0 + np.array(aims))[:, None] * jacobian
    after = np.eye(robot.nv) - moved @ np.linalg.lstsq(jacobian @ moved, aim, rcond=NOTHING)[0]
    lock(basis, moved, after)
    return ImpactInvariant(basis, moved, after)
