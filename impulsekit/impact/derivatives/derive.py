"""``derivatives`` of an impact, stage by stage."""

from __future__ import annotations

from ...errors import check_kind
from ..result import Impact
from .derivation import Derivation
from .refusals import refuse_what_has_none
from .result import Derivatives
from .workspace import workspace_of

__all__ = ["derivatives"]


def derivatives(impact: Impact) -> Derivatives:
    """Derivatives of v⁺ and of every impulse by q, v⁻, impulses, restitution and friction.

    They are analytic, for the contact modes that were found; a contact point is fixed in its
    frame and moves with it. In a sequence every hit has its own modes; slip along the path is
    differentiated with its parameters. If a restitution function has a method ``derivative``
    of the approach speed, it is used; otherwise finite differences are, and the status reports it.

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
        >>> found.status.exists, found.dv_after_dimpulse["blow"].shape
        (True, (1, 6))
    """
    check_kind(impact, Impact, "derivatives")
    refuse_what_has_none(impact)
    return Derivation(impact, workspace_of(impact.scene)).result()
