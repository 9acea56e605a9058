"""``derivatives`` of an impact: in closed form where one contact is hit, else stage by stage."""

from __future__ import annotations

from ...errors import check_kind
from ..result import Impact
from .derivation import Derivation, acts_before
from .known_blows import of_known_blows
from .one_contact import of_one_contact
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
            such; a ``Collision`` of other shapes than balls with balls or flat
            faces; joints that are not chains of joints with fixed axes.

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
    workspace = workspace_of(impact.scene)
    outcome = impact.outcome
    if outcome is None or not (outcome.touches or len(outcome.constraint_impulses)):
        return of_known_blows(impact, workspace)
    if len(outcome.touches) == 1 and workspace.is_newton and not acts_before(impact):
        found = of_one_contact(
            impact,
            workspace,
            outcome,
            lambda joint_id: Derivation(impact, workspace, outcome).by_inertia(joint_id),
        )
        if found is not None:
            return found
    return Derivation(impact, workspace, outcome).result()
