"""One contact under Newton's law and nothing that is held: the shortest way.

The same equations as for any scene (``derive``), in one stage and without what only several
rows need: at one contact the books of the general way cost more than its sums.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from types import MappingProxyType

import numpy as np
from scipy.linalg.lapack import dgesv

from ...scene import Contact
from ..outcome import Outcome
from ..result import Impact
from .building import Builder
from .linear import Rows
from .modes import Coefficients, coefficients_of, found_mode
from .motion import Motion
from .result import Derivatives, ImpulseDerivatives
from .stage import NULL_ROW, equations_of
from .status import DerivativeStatus
from .tables import parts_of
from .workspace import Workspace

__all__ = ["of_one_contact"]

_NONE: MappingProxyType = MappingProxyType({})
_EYE = np.eye(3)


def of_one_contact(
    impact: Impact,
    workspace: Workspace,
    outcome: Outcome,
    by_inertia: Callable[[int], np.ndarray],
) -> Derivatives | None:
    """The derivatives, or None where the general way has to be taken.

    Args:
        by_inertia: gives (nv, 10) for the index of a joint.
    """
    (touch,) = outcome.touches
    entry, solution = impact.scene.contacts[touch.entry], outcome.contacts
    if solution is None or solution.unique is not None or not isinstance(entry, Contact):
        return None
    impulse = solution.impulse
    if not impulse[2] > 0.0:
        return None
    nv = workspace.model.nv
    q = workspace.configuration(impact.q)
    # Pinocchio takes no arrays that are read-only.
    v, after = impact.v_before.copy(), impact.v_after.copy()
    motion = Motion(workspace.expanded, workspace.data, q, after)
    pair = workspace.touching_rows(touch.entry).placed(motion)
    rows = pair.matrix
    u, shifted = rows.dot(v), rows.dot(after)
    u1, u2, normal = u.tolist()
    scale = max(abs(u1), abs(u2), abs(normal), *map(abs, shifted.tolist()))
    name = workspace.contact_names[touch.entry]
    own = coefficients_of(entry, normal, scale, name)
    rates = pair.change_of_velocity()
    if own.slope or own.edge or own.differenced or rates is None:
        return None
    entering: float | np.ndarray = -1.0
    if own.e or own.e_t:
        shift = _given_back(own, normal)
        shifted += shift * u
        motion.set_speed(v)
        before = pair.change_of_velocity()
        shift = shift[:, None]
        if before is not None:
            rates = rates + shift * before
        entering = -1.0 - shift
    builder = Builder(workspace, motion, q, (), redundant=False)
    blows = [placed.placed(motion) for placed in workspace.blows]
    pulls = list(zip(blows, workspace.impulses, strict=True))
    load = builder.load(after - v, [*pulls, (pair, impulse)])
    width = workspace.width_of_state
    per_mass = 1.0 / builder.masses.diagonal()
    factor = builder.factor()
    if factor.is_filled:
        return None
    solved = factor.solve(_right_sides(rows, load, blows, width))
    moved, free = solved[:, :3], solved[:, 3:]
    mode = found_mode(impulse, shifted, own.mu, (rows * rows).dot(per_mass), scale, name)
    if mode.parted or mode.edges:
        return None
    mix, beside = equations_of(mode)
    by_direct = _inverse(rows.dot(moved), mix, beside)
    if by_direct is None:
        return None
    given = np.zeros((3, width + 2))
    lifted = rows.dot(free)
    np.subtract(-rates, lifted[:, :nv], out=given[:, :nv])
    np.multiply(rows, entering, out=given[:, nv : 2 * nv])
    if blows:
        given[:, 2 * nv : width] = -lifted[:, nv:]
    if normal < 0.0:
        given[2, width] = -normal
    change = by_direct.dot(mix).dot(given)
    if not mode.sticking:
        change[:, width + 1] = by_direct[:, :2].dot(-mode.normal_impulse * mode.slip)
    velocity = _change_of_velocity(change, moved, free, len(blows) > 0)
    told = change
    if not pair.is_level and touch.axes is not None:
        told = touch.axes.dot(change)
        turned = pair.turned(touch.axes.dot(impulse))
        if turned is not None:
            told[:, :nv] += turned
    places = workspace, [(name, width)], [(name, width + 1)]
    contact = MappingProxyType({name: ImpulseDerivatives(*parts_of(told, *places))})
    of_velocity = parts_of(velocity, *places)
    status = DerivativeStatus.EXISTS
    return Derivatives(impact, status, (), *of_velocity, _NONE, contact, by_inertia)


def _given_back(own: Coefficients, normal: float) -> np.ndarray:
    """(3,) shares of u⁻ that the law gives back."""
    by_tangent = own.e_t if own.mu > 0.0 else 0.0
    return np.array((by_tangent, by_tangent, own.e if normal < 0.0 else 0.0))


def _right_sides(
    rows: np.ndarray, load: np.ndarray, blows: Sequence[Rows], width: int
) -> np.ndarray:
    """(nv, 3 + width − nv) the rows, then what M d is given by q, then by each blow."""
    nv = rows.shape[1]
    right = np.empty((nv, 3 + width - nv), order="F")
    right[:, :3], right[:, 3 : 3 + nv] = rows.T, load
    at = 3 + nv
    for placed in blows:
        until = at + len(placed.matrix)
        right[:, at:until] = placed.matrix.T
        at = until
    return right


def _inverse(delassus: np.ndarray, mix: np.ndarray, beside: np.ndarray) -> np.ndarray | None:
    """(3, 3) of the equations of the mode; None where a row moves next to nothing."""
    sizes = delassus.diagonal()
    t1, t2, n = sizes.tolist()
    if min(t1, t2, n) <= NULL_ROW * max(t1, t2, n):
        return None
    unit = 1.0 / np.sqrt(sizes)
    square = unit * unit[:, None]
    _, _, inverse, failed = dgesv((mix.dot(delassus) + beside) * square, _EYE)
    if failed:
        return None
    inverse *= square
    return inverse


def _change_of_velocity(
    change: np.ndarray, moved: np.ndarray, free: np.ndarray, struck: bool
) -> np.ndarray:
    """(nv, width + 2) of v⁺, by the change of P, and by q, v and blows themselves."""
    nv, width = len(moved), change.shape[1] - 2
    # Column by column, so that a share of them lies together.
    columns = change.T.dot(moved.T)
    columns[:nv] += free[:, :nv].T
    columns[nv : 2 * nv].reshape(-1)[:: nv + 1] += 1.0
    if struck:
        columns[2 * nv : width] += free[:, nv:].T
    return columns.T
