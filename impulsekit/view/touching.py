"""``touching``: what is near what, before anything is solved."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..display import decimals, table
from ..errors import check_kind
from ..impact.gaps import AnchorOpening, ContactGap, anchor_openings, contact_gaps
from ..impact.named import Named
from ..robot.placing import Posture
from ..scene import Scene
from .report import GAP_SCALE

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


@dataclass(frozen=True, eq=False)
class Touching:
    """Gaps and closing speeds of a scene at a state; printed, it is a table.

    Attributes:
        contacts: a ``ContactGap`` for each contact, by place or by name: ``gap`` [m, rad],
            ``closing_speed`` [m/s, rad/s], ``touching``.
        constraints: an ``AnchorOpening`` for each constraint: ``gap`` [m].
    """

    contacts: Named[ContactGap]
    constraints: Named[AnchorOpening]

    def __str__(self) -> str:
        lines: list[str] = []
        if self.contacts:
            rows = [
                [
                    item.name,
                    "yes" if item.touching else "no",
                    decimals(item.gap, GAP_SCALE),
                    decimals(item.closing_speed),
                    "rad, rad/s" if item.angular else "m, m/s",
                ]
                for item in self.contacts
            ]
            head = ["contact", "touching", "gap", "closing speed", "units"]
            lines += ["Contacts", *table(head, rows)]
        if self.constraints:
            rows = [[item.name, decimals(item.gap, GAP_SCALE)] for item in self.constraints]
            lines += ["Constraints", *table(["constraint", "open by, m"], rows)]
        return "\n".join(lines) or "The scene has no contacts and no constraints"

    __repr__ = __str__


def touching(scene: Scene, q: ArrayLike, v: ArrayLike | None = None) -> Touching:
    """Report the gaps of all contacts and anchors of a scene at one state, without solving it.

    Args:
        scene: the scene.
        q: (nq,) configuration.
        v: (nv,) velocity; None for a robot at rest.

    Raises:
        ShapeError, NotFiniteError, StateError: q or v is not valid.

    Example:
        >>> from impulsekit import Contact, Robot, Scene
        >>> robot = Robot.from_example("panda")
        >>> floor = Contact("panda_hand", at=[0, 0, 0.1], name="floor")
        >>> v = robot.velocity(panda_joint2=1.0)
        >>> print(touching(Scene(robot, contacts=[floor]), robot.neutral(), v))
        Contacts
          contact   touching     gap   closing speed   units
          -------   --------   -----   -------------   ------
          floor     yes        0.826           0.088   m, m/s
    """
    check_kind(scene, Scene, "touching")
    posture = Posture(scene.robot, q, v)
    return Touching(
        Named(contact_gaps(scene, posture), "contact"),
        Named(anchor_openings(scene, posture), "constraint"),
    )
