"""Masses, impulses and rows of a scene at one state, in 50 digits, by Kane's equations.

With each goes its size: what its terms add up to before any cancel. A program that works in
doubles knows M to eps √(M_ii M_jj) and a row to eps times its size, and no better.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from impulsekit.checking.demands import constraint_rows, known_impulses
from impulsekit.checking.system import ReferenceRobot, read_reference
from impulsekit.reference import Rows
from impulsekit.reference.arithmetic import Array
from impulsekit.reference.kane import generalized_impulse, generalized_masses
from impulsekit.reference.kinematics import Kinematics
from impulsekit.reference.loads import at_mass_centres
from impulsekit.reference.rows import point_velocity_rows, speed_rows
from impulsekit.reference.tree import WORLD
from impulsekit.scene import Contact, JointStop, Scene

from .numbers import truth_numbers


@dataclass(frozen=True, eq=False)
class Mechanics:
    """n speeds, r bilateral rows, c contacts of three rows t₁, t₂, n each.

    Attributes:
        masses: (n, n) M.
        weights: (n,) √M_ii.
        spans: (n,) the fastest that a unit of each speed moves matter: the largest root of a
            body's M_ii over its mass.
        known, known_size: (n,) I of the known impulses.
        rows, rows_size: (r, n) A.
        target: (r,) b.
        contacts, contacts_size: (3c, n) J; the tangent rows of a joint stop are zeros.
        axes: of each contact (3, 3), rows t₁, t₂, n in the world; None for a joint stop.
        signs: of each contact, +1 or −1 for a stop at the lower or upper limit.
    """

    masses: Array
    weights: Array
    spans: Array
    known: Array
    known_size: Array
    rows: Array
    rows_size: Array
    target: Array
    contacts: Array
    contacts_size: Array
    axes: tuple[Array | None, ...]
    signs: tuple[int, ...]


class SceneMechanics:
    """The mechanics of a scene at any of its states.

    Attributes:
        scene: the scene, on a robot that was read from a URDF; its joints may have armature.
        numbers: what everything is computed in.
    """

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.numbers = truth_numbers()
        self._known = known_impulses(self._reference, scene.impulses)

    @cached_property
    def _reference(self) -> ReferenceRobot:
        return read_reference(self.scene.robot, self.numbers)

    def at(self, q: np.ndarray, v: np.ndarray) -> Mechanics:
        """Everything at q and v.

        Raises:
            InputError: the reference cannot take the state.
        """
        numbers, tree = self.numbers, self._reference.system
        at = self._reference.system.kinematics(q)
        masses = generalized_masses(at)
        reach = self._reach(at)
        forces, couples = at_mass_centres(tree, at, self._known.loads)
        known = generalized_impulse(at, forces, couples)
        known_size = self._size(at, reach, forces[None], couples[None])[0]
        for name, impulse in self._known.in_joints.items():
            speeds = tree.joint(name).speeds
            known[speeds] += numbers.array(impulse)
            known_size[speeds] += np.abs(numbers.array(impulse))
        demands = constraint_rows(self._reference, at, v, self.scene.constraints)
        touching, axes, signs = self._contact_rows(at)
        return Mechanics(
            masses,
            np.array([numbers.sqrt(m) for m in np.diagonal(masses)], dtype=object),
            self._spans(at),
            known,
            known_size,
            *self._matrix(at, reach, demands),
            demands.target,
            *self._matrix(at, reach, touching),
            axes,
            signs,
        )

    def _matrix(self, at: Kinematics, reach: Array, rows: Rows) -> tuple[Array, Array]:
        matrix = rows.matrix(self.numbers, at.linear, at.angular) + rows.speeds
        return matrix, self._size(at, reach, rows.linear, rows.angular) + np.abs(rows.speeds)

    def _size(self, at: Kinematics, reach: Array, linear: Array, angular: Array) -> Array:
        """(r, n) what the entries of rows g·v + h·ω are sums of, whatever their axes."""
        return _lengths(linear) @ (_lengths(at.linear) + reach) + _lengths(angular) @ _lengths(
            at.angular
        )

    def _spans(self, at: Kinematics) -> Array:
        heavy = [k for k, mass in enumerate(at.masses) if mass > 0]
        moved = at.angular @ at.inertias
        spans = self.numbers.zeros(self._reference.system.n)
        for k in heavy:
            own = (at.linear[k] ** 2).sum(axis=1)
            own = own + (moved[k] * at.angular[k]).sum(axis=1) / at.masses[k]
            spans = np.maximum(spans, own)
        return np.array([self.numbers.sqrt(span) for span in spans], dtype=object)

    def _reach(self, at: Kinematics) -> Array:
        """(N, n) how far turning l moves the mass centre of k at most, links outstretched."""
        tree = self._reference.system
        away = self.numbers.zeros(len(tree.bodies))
        owner = np.zeros(tree.n, dtype=int)
        for k, body in enumerate(tree.bodies):
            if body.parent != WORLD:
                step = at.origins[k] - at.origins[body.parent]
                away[k] = away[body.parent] + self.numbers.norm(step)
            owner[body.joint.speeds] = k
        arms = _lengths(at.mass_centres - at.origins)
        reach = (away + arms)[:, None] - away[owner][None, :]
        return np.where(reach > 0, reach, self.numbers.number(0)) * _lengths(at.angular)

    def _contact_rows(
        self, at: Kinematics
    ) -> tuple[Rows, tuple[Array | None, ...], tuple[int, ...]]:
        tree, numbers = self._reference.system, self.numbers
        parts: list[Rows] = []
        axes: list[Array | None] = []
        signs: list[int] = []
        for entry in self.scene.contacts:
            if isinstance(entry, JointStop):
                matrix = numbers.zeros(3, tree.n)
                sign = 1 if entry.lower is not None else -1
                joint = tree.joint(self._reference.joint(entry.joint))
                matrix[2, joint.first_speed] = numbers.number(sign)
                parts.append(speed_rows(tree, matrix))
                axes.append(None)
                signs.append(sign)
                continue
            if not isinstance(entry, Contact):
                raise TypeError(type(entry).__name__)
            link, other = (self._reference.link(name) for name in entry.frame_names)
            first, second = tree.body_of_link(link), tree.body_of_link(other)
            place = at.origins[first] + at.rotations[first] @ numbers.array(entry.at)
            normal = numbers.array(entry.normal)
            if second != WORLD:
                normal = at.rotations[second] @ normal
                place = at.rotations[second].T @ (place - at.origins[second])
            triad = _triad(normal / numbers.norm(normal), numbers)
            parts.append(point_velocity_rows(tree, at, link, other, entry.at, place, triad))
            axes.append(triad)
            signs.append(1)
        return Rows.stack(tree, parts), tuple(axes), tuple(signs)


def _triad(normal: Array, numbers: Any) -> Array:
    """(3, 3) rows t₁, t₂, n."""
    axis = numbers.zeros(3)
    axis[int(np.argmin(np.abs(normal.astype(float))))] = numbers.number(1)
    first = axis - normal * (normal @ axis)
    first = first / numbers.norm(first)
    second = np.roll(normal, -1) * np.roll(first, -2) - np.roll(normal, -2) * np.roll(first, -1)
    return np.array([first, second, normal], dtype=object)


def _lengths(vectors: Array) -> Array:
    """The lengths of vectors along the last axis."""
    root = truth_numbers().sqrt
    squares = (vectors * vectors).sum(axis=-1)
    lengths = np.empty(squares.shape, dtype=object)
    for index in np.ndindex(squares.shape):
        lengths[index] = root(squares[index])
    return lengths
