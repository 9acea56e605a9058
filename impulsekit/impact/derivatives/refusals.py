"""Words for what has no derivatives of this kind, and for the edges of modes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..._core import Edge, Unavailable
from ...errors import InputError
from ...scene.coefficients import is_plain
from ...scene.contacts import turns
from ..status import BY_CODE

if TYPE_CHECKING:
    from ..._core import ModeEdge
    from ...scene import Scene
    from ..result import Impact

__all__ = ["edge_words", "refuse_invalid", "refuse_what_has_none", "unavailable"]

# Of each edge; {other} is another contact.
_EDGES = {
    Edge.hardly_presses: "it hardly presses and hardly parts",
    Edge.edge_of_cone: "it sticks with its impulse at the edge of the cone",
    Edge.hardly_slips: "it hardly slips",
    Edge.out_of_proportion: "its impulse is out of all proportion to what it moves",
    Edge.at_table_point: "its approach speed is at a point of its restitution table",
    Edge.at_capture: "its approach speed is at the capture speed",
    Edge.hardly_approaches: "it hardly approaches, where restitution sets in",
    Edge.just_as_fast: "{other} approaches just as fast",
    Edge.hardly_parts: "it hardly approaches or hardly parts",
    Edge.stuck_at_edge: "what has stuck is at the edge of its cone",
    Edge.slip_ends_with_phase: "slip ends just as the compression or the impact does",
    Edge.hardly_slips_first: "it hardly slips when it meets",
    Edge.differences_disagree: "its differences at two lengths disagree, as where a mode ends",
}
# Why an impact is not differentiated; {name} is a contact.
_UNAVAILABLE = {
    Unavailable.drawn_in: (
        "friction holds all that moves, or draws the contact in again (Painlevé); there the "
        "impulse has no derivative of this kind"
    ),
    Unavailable.too_many_hits: (
        "an infinite series of hits at the contacts is not differentiated; "
        'use Law(order="simultaneous")'
    ),
    Unavailable.coupled: (
        "several contacts without friction act on each other beside others whose slip is followed "
        "along the path; put bodies that have nothing to do with each other into scenes of their "
        'own, or use slip="end"'
    ),
    Unavailable.no_closed_form: (
        "{name}: how the point moves at which its bodies meet is not known in closed form (of two "
        "balls, and of a corner, ball or capsule's end on a flat face of a polytope, it is); give "
        "it as a Contact"
    ),
    Unavailable.no_compression: ("the compression of this impact has no solution"),
    Unavailable.no_waves: (
        "an impact nearby is not solved, of which differences are taken; use finite differences of "
        "solve with steps of your own"
    ),
    Unavailable.functions: (
        "not available for scenes with a GapConstraint or a GapContact: they would take second "
        "derivatives of its functions"
    ),
    Unavailable.singular: (
        "the mass matrix is singular, and the constraints do not make up for it"
    ),
}


def edge_words(scene: Scene, edge: ModeEdge) -> str:
    """Return a sentence for an edge that the core found."""
    names = scene.entry_names("contacts")
    return f"{names[edge.contact]}: {_EDGES[edge.kind].format(other=names[edge.other])}"


def refuse_what_has_none(scene: Scene) -> None:
    """Refuse scenes that are not differentiated.

    Raises:
        InputError: it says what, and what to do instead.
    """
    if any(getattr(contact, "adhesion", 0.0) for contact in scene.contacts):
        raise InputError(
            "derivatives: not available for contacts with adhesion; where they hold, use a "
            "PointAnchor or FrameAnchor instead, or finite differences of solve"
        )
    if any(map(turns, scene.contacts)):
        raise InputError(
            "derivatives: not available for contacts with rolling or torsion; use finite "
            "differences of solve"
        )
    if not all(is_plain(getattr(c, "friction", 0.0)) for c in scene.contacts):
        raise InputError(
            "derivatives: not available for friction other than a number; use finite differences "
            "of solve"
        )


def unavailable(scene: Scene, why: Unavailable, contact: int) -> InputError:
    """Return the error of an impact that the core could not differentiate."""
    name = scene.entry_names("contacts")[contact] if contact >= 0 else ""
    return InputError(f"derivatives: {_UNAVAILABLE[why].format(name=name)}")


def refuse_invalid(impact: Impact) -> None:
    """Refuse an impact without a valid solution.

    Raises:
        InputError: it says what.
    """
    core = impact.solved.core
    # Others that obey the law as well do not matter here: the derivatives are of the v⁺ shown.
    if not BY_CODE[core.solution.status].obeys_law and core.rows.entries:
        raise InputError(
            f"derivatives: the impact has no valid solution. {impact.describe_status()}"
        )
