"""``outcomes``: all outcomes of a scene at one state."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..errors.calls import public
from .all_outcomes import outcomes_of
from .solver import solve

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ..scene import Scene
    from .all_outcomes import Outcomes

__all__ = ["outcomes"]


@public
def outcomes(
    scene: Scene, q: ArrayLike, v: ArrayLike, *, samples: int = 4096, seed: int = 0
) -> Outcomes:
    """Return the v⁺ that the impact may end with when contacts compress in any order and shares.

    Rigid bodies that are hit at several points have no single answer: a law chooses one.

    Args:
        scene: with contacts. q, v: (nq,), (nv,) the state before.
        samples: how many processes are followed.
        seed: sample k depends on it and k alone, not on the number of threads.

    Raises:
        ShapeError, NotFiniteError, StateError: q or v.
        RangeError: samples below 1, a seed below 0.
        InputError: nothing touches; contacts with adhesion, rolling, torsion, tangential
            restitution, or friction that is no number; a law that the contacts do not accept.

    Example:
        >>> from impulsekit import Contact, Robot, Scene
        >>> ball = Robot.from_urdf("models/ball.urdf", root="freeflyer")
        >>> floor = Contact("ball", at=[0, 0, -0.1], friction=0.3)
        >>> scene = Scene(ball, contacts=[floor], gap_bound=1)
        >>> found = outcomes(scene, ball.neutral(), [1, 0, -2, 0, 0, 0], samples=16)
        >>> found.bounds[:, 0].round(9).tolist()
        [0.909090909, 0.909090909]
    """
    return outcomes_of(solve(scene, q, v), samples, seed)
