"""Simple bodies for links that have no picture of their own: the box with the link's inertia."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from .surfaces import Surface, box, ellipsoid

if TYPE_CHECKING:
    from ..robot.links import Link

__all__ = ["equivalent_box", "simple_body"]

# A box is drawn no thinner than this share of its longest edge.
THINNEST = 0.04
# A mass without inertia is drawn as a ball of this density [kg/m³].
DENSITY = 2000.0


def simple_body(link: Link) -> tuple[Surface, pin.SE3] | None:
    """A surface for a link and its placement in the link's joint; None for a massless link.

    The box is uniform, and has the link's mass, mass centre and inertia.
    """
    if link.mass <= 0.0:
        return None
    if not link.inertia_in_joint_axes.any():
        radius = (3.0 * link.mass / (4.0 * np.pi * DENSITY)) ** (1.0 / 3.0)
        return ellipsoid(np.full(3, radius)), pin.SE3(np.eye(3), link.com_in_joint)
    lengths, rotation = equivalent_box(link.mass, link.inertia_in_joint_axes)
    return box(lengths), pin.SE3(rotation, link.com_in_joint)


def equivalent_box(mass: float, inertia: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The uniform box with a ``mass`` [kg] and a (3, 3) ``inertia`` about its centre [kg m²].

    Returns:
        (3,) edge lengths [m], from I_x = m (b² + c²)/12 and the two like it, and (3, 3)
        the edges' directions as columns. Edges too thin to be seen are made thicker.

    Example:
        >>> lengths, _ = equivalent_box(12.0, np.diag([13.0, 10.0, 5.0]))
        >>> [round(float(x), 6) for x in sorted(lengths)]
        [1.0, 2.0, 3.0]
    """
    moments, axes = np.linalg.eigh(inertia)
    if np.count_nonzero(inertia - np.diag(np.diagonal(inertia))) == 0:
        moments, axes = np.diagonal(inertia), np.eye(3)
    if np.linalg.det(axes) < 0.0:
        axes = axes * [1.0, 1.0, -1.0]
    squares = 6.0 * (moments.sum() - 2.0 * moments) / mass
    lengths = np.sqrt(np.maximum(squares, 0.0))
    longest = float(lengths.max())
    if longest == 0.0:
        longest = (mass / DENSITY) ** (1.0 / 3.0)
    return np.maximum(lengths, THINNEST * longest), axes
