"""``derivatives`` of an impact."""

from __future__ import annotations

import numpy as np

from ..._core import Derivation, Unavailable
from ...errors import check_kind
from ...errors.calls import public
from ..result import Impact
from .refusals import edge_words, refuse_invalid, unavailable
from .result import Derivatives, layout_of
from .status import DerivativeStatus

__all__ = ["derivatives"]


@public
def derivatives(impact: Impact) -> Derivatives:
    """Return the derivatives of v⁺ and of every impulse by all that the impact starts from.

    They are analytic, for the contact modes that were found; a contact point is fixed in its
    frame and moves with it. In a sequence every hit has its own modes; slip along the path is
    differentiated with its parameters. If a restitution function has a method ``derivative``
    of the approach speed, it is used; otherwise finite differences are, and the status reports it.
    Under ``restitution="lzb"`` and ``slip="compliant"`` contacts stick, slip and part in turn
    within an impact: there the contact impulses are differenced by the mobilities, velocities and
    coefficients at the contacts (2n (9n + 13) impacts for n contacts with friction), and all that
    these depend on is analytic.
    ``derivatives_batch`` and ``vjp`` are the same for many states.

    Args:
        impact: a solved impact.

    Raises:
        InputError: an impact without a valid solution; friction that presses a contact in again
            along its path; several contacts without friction that act on each other, beside
            such; a ``Collision`` whose points are not known in closed form: those of balls with
            balls, boxes, cylinders, capsules and flat faces are.

    Example:
        >>> from impulsekit import AppliedImpulse, Robot, Scene, solve
        >>> from impulsekit.models import pendulum_urdf
        >>> rod = Robot.from_urdf(pendulum_urdf(1))
        >>> blow = AppliedImpulse("link_1", linear=[3, 0, 0], at=[0, 0, -1], name="blow")
        >>> impact = solve(Scene(rod, [blow]), rod.neutral(), rod.velocity())
        >>> found = derivatives(impact)
        >>> found.status.exists, found["v_after", "q"].shape
        (True, (1, 1))
        >>> found["v_after", "impulses"]["blow"].shape
        (1, 6)
    """
    check_kind(impact, Impact, "derivatives")
    refuse_invalid(impact)
    scene = impact.scene
    layout = layout_of(scene, impact.solved.jump.flat)
    found = _derivation(impact, -1)

    def by_inertia(joint_id: int) -> np.ndarray:
        other = _derivation(impact, impact.solved.jump.flat.model.bodies[joint_id])
        return layout.pulled(other, "v_after")[:, -10:]

    edges = dict.fromkeys(edge_words(scene, edge) for edge in found.edges)
    status = DerivativeStatus[found.existence.name.upper()]
    return Derivatives(impact, status, tuple(edges), layout, found, by_inertia)


def _derivation(impact: Impact, inertia_of: int) -> Derivation:
    """The impact made linear in its modes; ``inertia_of``: a body of the core, or −1."""
    jump, _, core = impact.solved
    found = Derivation(jump.flat.core, jump.law, core, inertia_of)
    if found.unavailable is not Unavailable.none:
        raise unavailable(impact.scene, found.unavailable, found.contact)
    return found
