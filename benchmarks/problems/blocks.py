"""Blocks on a floor: Housner's that rocks, and one that lands on many points at once."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from impulsekit.robot import Robot
from impulsekit.scene import Contact, Scene

from ..urdf import one_body
from .problem import Problem

__all__ = ["landing_blocks", "rocking_blocks"]

# Half width and half height [m].
WIDE, HIGH = 0.125, 0.25
MASS = 4.0  # kg


def rocking_blocks(quick: bool) -> Iterator[Problem]:
    """A block that rocks over from one edge to the other, in the plane and in space.

    It keeps (2 h² − b²)/(2 (h² + b²)) of its rate (Housner 1963). The size is the number
    of corners.
    """
    rate = (2 * HIGH**2 - WIDE**2) / (2 * (HIGH**2 + WIDE**2))
    flat = _block("planar")
    corners = [
        Contact("block", at=[x, -HIGH, 0], normal=[0, 1, 0], friction=2.0) for x in (-WIDE, WIDE)
    ]
    v = np.array([-HIGH, -WIDE, 1.0])  # about the edge on the right, which rests
    after = np.array([-HIGH * rate, WIDE * rate, rate])
    yield Problem(
        "rocking block",
        2,
        Scene(flat, contacts=corners),
        flat.configuration(root_joint=[0, HIGH, 1, 0]),
        v,
        lambda: after,
        "Housner 1963",
    )
    block = _block("freeflyer")
    corners = [
        Contact("block", at=[x, y, -HIGH], friction=2.0) for x in (-WIDE, WIDE) for y in (-0.2, 0.2)
    ]
    turned = np.array([-HIGH * rate, 0, WIDE * rate, 0, -rate, 0])
    yield Problem(
        "rocking block",
        4,
        Scene(block, contacts=corners),
        block.configuration(root_joint=[0, 0, HIGH, 0, 0, 0, 1]),
        np.array([-HIGH, 0, -WIDE, 0, -1.0, 0]),
        lambda: turned,
        "Housner 1963",
    )


def landing_blocks(quick: bool) -> Iterator[Problem]:
    """A block that slides as it lands flat on a ring of n points, whose rows have rank six.

    v_n⁺ = −e v_n and |v_t⁺| = |v_t| − µ (1 + e) |v_n|, whatever the points' share.
    """
    e, mu, down = 0.5, 0.25, 1.0
    along = np.array([1.5, 2.0])  # 2.5 m/s
    left = 1.0 - mu * (1.0 + e) * down / 2.5
    for points in (4, 16) if quick else (4, 8, 16, 32):
        block = _block("freeflyer")
        angles = 2.0 * np.pi * (np.arange(points) + 0.5) / points
        ring = [[np.cos(angle), np.sin(angle), -HIGH] for angle in angles]
        contacts = [Contact("block", at=at, restitution=e, friction=mu) for at in ring]
        yield Problem(
            "landing block",
            points,
            Scene(block, contacts=contacts),
            block.configuration(root_joint=[0, 0, HIGH, 0, 0, 0, 1]),
            np.array([*along, -down, 0, 0, 0]),
            lambda: np.array([*(left * along), e * down, 0, 0, 0]),
            "Coulomb's law on the whole block",
        )


def _block(root: str) -> Robot:
    """As wide along y, where it does not turn, as along x."""
    across = MASS * (WIDE**2 + HIGH**2) / 3.0
    upright = 2.0 * MASS * WIDE**2 / 3.0
    # In the plane it turns about z.
    about_z = across if root == "planar" else upright
    return one_body("block", MASS, (across, across, about_z), root=root)
