"""``derivatives`` of an impact."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..._core import derive
from ...errors import check_kind
from ...errors.calls import public
from ...scene.scene import SceneCache
from ..flat.law import contact_law
from ..flat.scene import FlatScene, flat_of
from ..result import Impact
from .refusals import edge_words, refuse_what_has_none, refuse_what_was_not_found
from .result import Derivatives, Layout
from .status import DerivativeStatus

if TYPE_CHECKING:
    from ..._core import ContactLaw, Derivation
    from ...scene import Scene

__all__ = ["derivatives"]


@public
def derivatives(impact: Impact) -> Derivatives:
    """Return the derivatives of v⁺ and of every impulse by all that the impact starts from.

    They are analytic, for the contact modes that were found; a contact point is fixed in its
    frame and moves with it. In a sequence every hit has its own modes; slip along the path is
    differentiated with its parameters. If a restitution function has a method ``derivative``
    of the approach speed, it is used; otherwise finite differences are, and the status reports it.
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
    refuse_what_was_not_found(impact)
    found = _derivation(impact, -1)
    scene = impact.scene
    layout = _kept.of(scene)[2]

    def by_inertia(joint_id: int) -> np.ndarray:
        other = _derivation(impact, _kept.of(scene)[0].model.bodies[joint_id])
        return layout.pulled(other, "v_after")[:, -10:]

    edges = dict.fromkeys(edge_words(scene, *edge) for edge in found.edges)
    status = _STATUS[found.existence]
    return Derivatives(impact, status, tuple(edges), layout, found, by_inertia)


_STATUS = tuple(DerivativeStatus)


def _made(scene: Scene) -> tuple[FlatScene, ContactLaw, Layout]:
    refuse_what_has_none(scene)
    flat = flat_of(scene)
    return flat, contact_law(scene), Layout(scene, flat)


_kept = SceneCache(_made)


def _derivation(impact: Impact, inertia_of: int) -> Derivation:
    """The impact made linear in its modes; ``inertia_of``: a body of the core, or −1."""
    scene, outcome = impact.scene, impact.outcome
    flat, law, _ = _kept.of(scene)
    touches = () if outcome is None else outcome.touches
    contacts = None if outcome is None else outcome.contacts
    count, rows = len(touches), len(flat.names)
    multipliers, unique, shared = np.zeros(rows), np.ones(rows), np.ones(count)
    impulse = np.zeros(3 * count)
    if outcome is not None and len(outcome.constraint_impulses):
        multipliers = outcome.constraint_impulses
        unique = unique if outcome.unique is None else outcome.unique
    if contacts is not None:
        impulse = contacts.impulse
        shared = shared if contacts.unique is None else contacts.unique
    places = np.zeros((count, 3))
    for i, touch in enumerate(touches):
        if touch.position is not None:
            places[i] = touch.position
    found = derive(
        flat.core, law, impact.q, impact.v_before, flat.impulses,
        [touch.entry for touch in touches], places,
        (impact.dv, multipliers, unique.astype(float), impulse, shared.astype(float)), inertia_of,
    )  # fmt: skip
    if found.unavailable:
        refuse_what_was_not_found(impact, found.unavailable, found.contact)
    return found
