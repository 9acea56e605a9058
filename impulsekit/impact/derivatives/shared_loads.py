"""Loads that redundant contacts share: by which rule, and where v⁺ hangs on it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..._core import HeldMass
from ..held_mass import Responses
from .modes import ContactMode

if TYPE_CHECKING:
    from ..result import Impact

__all__ = ["EvenShares", "even_shares", "is_split_open"]


# Eigenvalues of scaled normals below this share of the largest are those of redundant ones.
DEPENDENT = 1e-12


class EvenShares(NamedTuple):
    """Springs under normals between which load can be shifted.

    Attributes:
        rows: (k,) those of the normals.
        root, stiffness: (k, k) Π √D, and √D Π √D.
    """

    rows: np.ndarray
    root: np.ndarray
    stiffness: np.ndarray


def even_shares(
    held_mass: HeldMass,
    matrix: np.ndarray,
    bilateral: int,
    modes: Sequence[ContactMode],
) -> EvenShares | None:
    """Springs that keep shares of load even where contacts slip; None where nothing is shared.

    Args:
        held_mass: M under the bilateral rows.
        matrix: (r, nv) these, ``bilateral`` in number, then three for each contact.
    """
    pressing = [i for i, mode in enumerate(modes) if not mode.held]
    if len(pressing) < 2 or all(modes[i].sticking for i in pressing):
        return None
    rows = np.array([bilateral + 3 * i + 2 for i in pressing])
    delassus = Responses.of(held_mass, matrix[bilateral:]).delassus
    own = delassus[np.ix_(rows - bilateral, rows - bilateral)]
    if not (own.diagonal() > 0.0).all():
        return None
    roots = np.sqrt(own.diagonal())
    values, axes = np.linalg.eigh(own / np.outer(roots, roots))
    null = axes[:, values <= DEPENDENT * values[-1]]
    if not null.shape[1]:
        return None
    shift = null @ null.T
    return EvenShares(rows, shift * roots, shift * np.outer(roots, roots))


def is_split_open(impact: Impact) -> bool:
    """Whether v⁺ may depend on how redundant contacts share their load.

    Under Poisson's law e times each share comes back. Without friction, and with one e for all,
    that is e times the resultant; otherwise the share is that of a rule, which is not linear.
    """
    outcome, scene = impact.outcome, impact.scene
    if outcome is None or outcome.contacts is None or outcome.contacts.unique is None:
        return False
    if scene.law.restitution != "poisson":
        return False
    shared = [
        scene.contacts[touch.entry]
        for touch, unique in zip(outcome.touches, outcome.contacts.unique, strict=True)
        if not unique
    ]
    names = ("restitution", "friction")
    e, mu = ([getattr(entry, name, 0.0) for entry in shared] for name in names)
    return any(e) and (any(mu) or any(one != e[0] for one in e))
