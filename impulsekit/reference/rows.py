"""Bilateral constraint rows: scalar demands on the velocities right after the impact.

A row is Σ_k (g_k·v_k + h_k·ω_k) + w_l y_l = b, over mass-centre velocities v_k, angular
velocities ω_k and generalized speeds y_l. Written on the bodies it means the same whether
joints are intact, freed or replaced by rows of their own. Its impulse λ is an outside
impulse λ g_k and λ h_k on each body and λ w_l on each speed.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from impulsekit.errors import ShapeError
from impulsekit.reference import rotation
from impulsekit.reference.arithmetic import Arithmetic, Array, read_only
from impulsekit.reference.kinematics import Kinematics
from impulsekit.reference.loads import point_on
from impulsekit.reference.tree import WORLD, Tree


@dataclass(frozen=True, eq=False)
class Rows:
    """r constraint rows on N bodies and n speeds.

    Attributes:
        linear: (r, N, 3) g, coefficients of mass-centre velocities, world axes.
        angular: (r, N, 3) h, coefficients of angular velocities, world axes.
        speeds: (r, n) w, coefficients of the generalized speeds.
        target: (r,) b, the values right after the impact.
        names: (r,) for messages.
    """

    linear: Array
    angular: Array
    speeds: Array
    target: Array
    names: tuple[str, ...]

    def __post_init__(self) -> None:
        read_only(self.linear, self.angular, self.speeds, self.target)

    def __len__(self) -> int:
        return len(self.target)

    @classmethod
    def none(cls, tree: Tree) -> Rows:
        """Return no row at all."""
        zeros, count = tree.arithmetic.zeros, len(tree.bodies)
        return cls(zeros(0, count, 3), zeros(0, count, 3), zeros(0, tree.n), zeros(0), ())

    @classmethod
    def stack(cls, tree: Tree, parts: Iterable[Rows]) -> Rows:
        """Return the rows of all parts, one after the other."""
        all_parts = [cls.none(tree), *parts]
        return cls(
            np.concatenate([part.linear for part in all_parts]),
            np.concatenate([part.angular for part in all_parts]),
            np.concatenate([part.speeds for part in all_parts]),
            np.concatenate([part.target for part in all_parts]),
            tuple(name for part in all_parts for name in part.names),
        )

    def matrix(self, arithmetic: Arithmetic, linear: Array, angular: Array) -> Array:
        """Return the body part of the rows on speeds with these partial velocities, (r, d).

        Where the terms of an entry cancel to within the rounding of the partial
        velocities, the entry is zero: a row between two bodies that are rigidly joined
        must move nothing, rather than move something by 1e-17.

        Args:
            linear, angular: (N, d, 3) partial velocities.
        """
        over = ([1, 2], [0, 2])
        entries = np.tensordot(self.linear, linear, axes=over)
        entries += np.tensordot(self.angular, angular, axes=over)
        terms = np.tensordot(np.abs(self.linear), np.abs(linear), axes=over)
        terms += np.tensordot(np.abs(self.angular), np.abs(angular), axes=over)
        # Rounding grows from body to body on the way out from the root.
        rounding = 8 * (8 + self.linear.shape[1]) * arithmetic.epsilon
        entries[np.abs(entries) <= rounding * terms] = arithmetic.number(0)
        return entries

    def size(self, matrix: Array, *motions: Array) -> Any:
        """Return the largest velocity that occurs in the rows, before any terms cancel.

        Args:
            matrix: (r, d) the rows on some speeds.
            motions: (d,) each, values of these speeds.
        """
        terms = np.abs(self.target)
        for motion in motions:
            terms = terms + np.abs(matrix) @ np.abs(motion)
        return max(terms)


def point_velocity_rows(
    tree: Tree,
    at: Kinematics,
    link: str,
    other: str = "world",
    point: Any = (0, 0, 0),
    other_point: Any = (0, 0, 0),
    directions: Any = None,
    target: Any = None,
    name: str = "",
) -> Rows:
    """Return velocity of a point of ``link`` against a point of ``other``, along directions.

    Args:
        link, other: links, or "world".
        point, other_point: (3,) m, in the frames of the links.
        directions: (r, 3) in world axes; x, y and z unless given.
        target: (r,) m/s after the impact; zeros unless given.

    Returns:
        Rows whose impulses are those that ``link`` receives, along the directions.
    """
    numbers = tree.arithmetic
    along, wanted = _directions(tree, directions, target)
    linear = numbers.zeros(len(along), len(tree.bodies), 3)
    angular = numbers.zeros(len(along), len(tree.bodies), 3)
    for side, sign, place in ((link, 1, point), (other, -1, other_point)):
        body = tree.body_of_link(side)
        where = point_on(tree, at, body, place, f'point of "{side}"')
        if body == WORLD:
            continue
        # d·(v + ω x r) = d·v + (r x d)·ω
        arm = rotation.skew(where - at.mass_centres[body], numbers)
        linear[:, body] += sign * along
        angular[:, body] += sign * (along @ arm.T)
    return _rows(tree, linear, angular, wanted, name or f"point of {link} against {other}")


def angular_velocity_rows(
    tree: Tree,
    link: str,
    other: str = "world",
    directions: Any = None,
    target: Any = None,
    name: str = "",
) -> Rows:
    """Return the rows on the angular velocity of ``link`` against ``other``; args as there."""
    along, wanted = _directions(tree, directions, target)
    linear = tree.arithmetic.zeros(len(along), len(tree.bodies), 3)
    angular = tree.arithmetic.zeros(len(along), len(tree.bodies), 3)
    for side, sign in ((link, 1), (other, -1)):
        body = tree.body_of_link(side)
        if body != WORLD:
            angular[:, body] += sign * along
    return _rows(tree, linear, angular, wanted, name or f"turning of {link} against {other}")


def speed_rows(tree: Tree, matrix: Any, target: Any = None, name: str = "row") -> Rows:
    """Return the rows on the generalized speeds themselves: matrix (r, n) @ y = target (r,)."""
    checked = tree.arithmetic.finite_array(matrix, "matrix of constraint rows")
    if checked.ndim != 2 or checked.shape[1] != tree.n:
        rows = checked.shape[0] if checked.ndim else 1
        raise ShapeError.of("matrix of constraint rows", (rows, tree.n), checked.shape)
    wanted = _target(tree, target, len(checked))
    none = tree.arithmetic.zeros(len(checked), len(tree.bodies), 3)
    return Rows(none, none, checked, wanted, _numbered(name, len(checked)))


def _directions(tree: Tree, directions: Any, target: Any) -> tuple[Array, Array]:
    numbers = tree.arithmetic
    if directions is None:
        along = numbers.eye(3)
    else:
        along = numbers.finite_array(directions, "directions")
        if along.ndim != 2 or along.shape[1] != 3:
            raise ShapeError.of("directions", (len(np.atleast_1d(along)), 3), along.shape)
    return along, _target(tree, target, len(along))


def _target(tree: Tree, target: Any, count: int) -> Array:
    if target is None:
        return tree.arithmetic.zeros(count)
    wanted = tree.arithmetic.finite_array(target, "target of constraint rows")
    if wanted.shape != (count,):
        raise ShapeError.of("target of constraint rows", (count,), wanted.shape)
    return wanted


def _rows(tree: Tree, linear: Array, angular: Array, target: Array, name: str) -> Rows:
    speeds = tree.arithmetic.zeros(len(target), tree.n)
    return Rows(linear, angular, speeds, target, _numbered(name, len(target)))


def _numbered(name: str, count: int) -> tuple[str, ...]:
    return tuple(f"{name}, row {i}" for i in range(count))
