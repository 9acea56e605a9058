"""Links with moments of inertia that no body has: likely wrong, and taken as written."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from .urdf_elements import LinkInertial

__all__ = ["told_if_impossible"]

# A principal moment may exceed the sum of the others by this share of it: files round to few
# digits.
EXCESS = 1e-2
# Links whose largest moment is below this share of the robot's largest are markers and dummies.
DUMMY = 1e-4
# So many links are named.
NAMED = 3


def told_if_impossible(links: Mapping[str, LinkInertial]) -> list[str]:
    """A sentence on the links with a principal moment below zero or above the sum of the others.

    Args:
        links: the inertia of every link by name.
    """
    names, tensors = [], []
    for name, link in links.items():
        ixx, ixy, ixz, iyy, iyz, izz = link.moments
        if ixx or iyy or izz:
            names.append(name)
            tensors.append(((ixx, ixy, ixz), (ixy, iyy, iyz), (ixz, iyz, izz)))
    if not names:
        return []
    # In units of the largest, whose squares are doubles.
    entries = np.array(tensors)
    unit = np.abs(entries).max()
    moments = np.linalg.eigvalsh(entries / unit)
    first, second, third = moments.T
    wrong = (first < -EXCESS * third) | (third > (1.0 + EXCESS) * (first + second))
    found = np.flatnonzero(wrong & (third > DUMMY * third.max()))
    if not len(found):
        return []
    named = ", ".join(
        f'"{names[k]}" ({", ".join(f"{unit * one:.3g}" for one in moments[k])} kg m²)'
        for k in found[:NAMED]
    )
    more = f" and {len(found) - NAMED} more" if len(found) > NAMED else ""
    return [
        f"no body has such principal moments of inertia, one below zero or above the sum of the "
        f"others, as {named}{more}: they are taken as written"
    ]
