"""A contact of a mechanism as Exudyn's sphere on a triangle."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from .exudyn_tree import ExudynTree, third_along
from .mechanism import Mechanism

__all__ = ["add_touch"]

# Of the triangle that stands for a plane [m].
REACH = 0.1


def add_touch(
    system: Any,
    tree: ExudynTree,
    mechanism: Mechanism,
    item: Any,
    touch: Any,
    radius: float,
    **contact: Any,
) -> None:
    """Give a system one contact of the mechanism.

    Args:
        system: not yet assembled.
        tree, item: of the mechanism in it.
        touch: one of ``mechanism.touches``.
        radius: of the sphere [m]; the plane is met by the point that is nearest to it.
        contact: Exudyn's own words for stiffness, restitution and friction.
    """
    import exudyn as exu
    from exudyn.itemInterface import (
        MarkerBodyRigid,
        NodeGenericData,
        ObjectContactSphereTriangle,
        ObjectGround,
    )

    centre = touch.place + radius * touch.normal
    sphere = system.AddMarker(tree.on_body(mechanism, item, touch.body, centre))
    turn = np.eye(3)
    if touch.other >= 0:
        plane = system.AddMarker(tree.on_body(mechanism, item, touch.other, touch.place))
        turn = (mechanism.rotations[touch.other] @ tree.axes[tree.last[touch.other]]).T
    else:
        ground = system.AddObject(ObjectGround())
        plane = system.AddMarker(MarkerBodyRigid(bodyNumber=ground, localPosition=touch.place))
    first, second = third_along(touch.normal)[:, :2].T
    corners = [
        REACH * (math.cos(angle) * first + math.sin(angle) * second)
        for angle in (0.0, 2.0 * math.pi / 3.0, 4.0 * math.pi / 3.0)
    ]
    # It was apart before: else the damper takes the impact for one that goes on.
    memory = system.AddNode(
        NodeGenericData(numberOfDataCoordinates=4, initialCoordinates=[radius, 0.0, 0.0, 0.0])
    )
    system.AddObject(
        ObjectContactSphereTriangle(
            markerNumbers=[sphere, plane],
            nodeNumber=memory,
            sphereRadius=radius,
            trianglePoints=exu.Vector3DList([turn @ corner for corner in corners]),
            includeEdges=0,
            **contact,
        )
    )
