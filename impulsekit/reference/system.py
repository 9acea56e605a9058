"""The reference as one object: a system of bodies, its impacts and its accelerations.

Shares nothing with Pinocchio, neither its URDF reader nor its frames; only its order of
coordinates and speeds.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from impulsekit.errors import RangeError, ShapeError
from impulsekit.reference import freed, kane, loads
from impulsekit.reference.arithmetic import Arithmetic, Array, read_only
from impulsekit.reference.joint import joint_coordinate
from impulsekit.reference.kinematics import Kinematics, kinematics, partial_rates
from impulsekit.reference.loads import JointSpring, Load, PointSpring
from impulsekit.reference.rows import (
    Rows,
    angular_velocity_rows,
    point_velocity_rows,
    speed_rows,
)
from impulsekit.reference.tree import WORLD, Tree

__all__ = ["KaneImpact", "KaneSystem"]


@dataclass(frozen=True, eq=False)
class KaneImpact:
    """How an impact changes the motion. N bodies, n speeds, r rows; arrays are read-only.

    Attributes:
        dy, y_before, y_after: (n,) generalized speeds.
        generalized_impulse: (n,) all of I_l, those of constraint rows included.
        momentum_before, momentum_after: (n,) P_l.
        generalized_masses: (n, n) a_lp.
        body_dv: (N, 3) m/s, changes of the mass-centre velocities, world axes.
        body_domega: (N, 3) rad/s, changes of the angular velocities, world axes.
        energy_before, energy_after: kinetic energies in J.
        row_impulses: (r,) N s or N m s.
    """

    system: KaneSystem = field(repr=False)
    dy: Array
    y_before: Array
    y_after: Array
    generalized_impulse: Array
    momentum_before: Array
    momentum_after: Array
    generalized_masses: Array
    body_dv: Array
    body_domega: Array
    energy_before: Any
    energy_after: Any
    row_impulses: Array
    _at: Kinematics = field(repr=False)
    _impulses: Array = field(repr=False)
    _couples: Array = field(repr=False)
    _own_impulses: Mapping[str, Array] = field(repr=False)

    def __post_init__(self) -> None:
        read_only(*(value for value in vars(self).values() if isinstance(value, np.ndarray)))

    def body(self, link: str) -> tuple[Array, Array]:
        """Change of the mass-centre velocity and of the angular velocity of a link."""
        index = self.system.tree.body_of_link(link)
        if index == WORLD:
            zero = _closed(self.system.arithmetic.zeros(3))
            return zero, zero
        return self.body_dv[index], self.body_domega[index]

    def joint_reaction(self, joint: str) -> Array:
        """The impulsive wrench that the parent link gives the child through a joint.

        Found by freeing the joint (:mod:`impulsekit.reference.freed`).

        Returns:
            (6,) at the joint's origin, world axes, linear (N s) before angular (N m s).
        """
        tree = self.system.tree
        body = tree.body_of_joint(joint)
        return _closed(
            freed.reaction(
                tree,
                self._at,
                body,
                self.dy,
                self._impulses,
                self._couples,
                self._own_impulses[joint],
            )
        )

    def joint_reactions(self) -> dict[str, Array]:
        """:meth:`joint_reaction` of every joint, by name."""
        return {name: self.joint_reaction(name) for name in self.system.joint_names}


@dataclass(frozen=True, eq=False)
class KaneSystem:
    """A multibody system by Chang & Huston's method.

    Example:
        >>> rod = '''<robot name="rod"><link name="rod"><inertial>
        ...     <mass value="2"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>
        ... </inertial></link></robot>'''
        >>> system = KaneSystem.from_urdf(rod, root="freeflyer")
        >>> blow = Load("rod", linear=(0, 6, 0), at=(1, 0, 0))
        >>> impact = system.impact(system.neutral(), [0.0] * 6, [blow])
        >>> impact.body("rod")
        (array([0., 3., 0.]), array([0., 0., 6.]))
    """

    tree: Tree

    @classmethod
    def from_urdf(
        cls,
        urdf: str | os.PathLike[str],
        root: str = "fixed",
        mimic: bool = False,
        arithmetic: Arithmetic | None = None,
        exact_decimals: bool = False,
    ) -> KaneSystem:
        """Read a URDF; arguments and errors are those of :meth:`Tree.from_urdf`."""
        return cls(Tree.from_urdf(urdf, root, mimic, arithmetic, exact_decimals))

    @classmethod
    def combine(
        cls, placements: Mapping[str, tuple[Any, Any]] | None = None, /, **parts: KaneSystem
    ) -> KaneSystem:
        """Several systems in one world, names prefixed "part/"; see :meth:`Tree.combine`."""
        return cls(Tree.combine({name: part.tree for name, part in parts.items()}, placements))

    # -- names and states -------------------------------------------------------

    @property
    def arithmetic(self) -> Arithmetic:
        """The numbers that everything here is computed in."""
        return self.tree.arithmetic

    @property
    def n(self) -> int:
        """Number of generalized speeds."""
        return self.tree.n

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the generalized speeds."""
        return self.tree.speed_names

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints, fixed ones too, each in the place of the link below it."""
        return self.tree.joint_names

    @property
    def link_names(self) -> tuple[str, ...]:
        """Names of the links, each a body."""
        return self.tree.link_names

    def neutral(self) -> Array:
        """(nq,) the configuration with every joint at zero."""
        return self.tree.neutral()

    def kinematics(self, q: Any) -> Kinematics:
        """ω_klm, v_klm and all else that depends on the configuration alone."""
        return self._kinematics_of(self.tree.configuration(q))

    def _kinematics_of(self, q: Array) -> Kinematics:
        return kinematics(self.tree, q)

    @cached_property
    def _on_singular(self) -> Any:
        return kane.singular_at(self.names)

    # -- impact ------------------------------------------------------------------

    def generalized_masses(self, q: Any) -> Array:
        """(n, n) a_lp (eq. 30)."""
        return _closed(kane.generalized_masses(self.kinematics(q)))

    def generalized_impulse(
        self, q: Any, impulses: Iterable[Load] = (), joint_impulses: Mapping[str, Any] | None = None
    ) -> Array:
        """(n,) I_l of known impulses (eq. 18); arguments are those of :meth:`impact`."""
        at = self.kinematics(q)
        outside = kane.generalized_impulse(at, *loads.at_mass_centres(self.tree, at, impulses))
        return _closed(outside + self._on_speeds(self.in_joints(joint_impulses)))

    def impact(
        self,
        q: Any,
        y: Any,
        impulses: Iterable[Load] = (),
        joint_impulses: Mapping[str, Any] | None = None,
        rows: Rows | None = None,
    ) -> KaneImpact:
        """Solve the impact equations a_lp Δy_p = I_l (Chang & Huston 1995, eqs. 31-33).

        Args:
            q: (nq,) configuration. y: (n,) generalized speeds before.
            impulses: blows on links.
            joint_impulses: by joint, the impulse inside it along its own speeds, which the
                child receives and the parent opposes: a number, or one for each speed.
            rows: demands on the velocities after, such as :meth:`rows_at_point` makes them.

        Raises:
            InputError: something given cannot be used.
            SingularMassError: a motion without inertia.
            ContradictionError: rows that cannot hold together.
        """
        tree, numbers = self.tree, self.arithmetic
        before = tree.speeds(y)
        at = self.kinematics(q)
        demands = Rows.none(tree) if rows is None else self.checked_rows(rows)
        forces, couples = loads.at_mass_centres(tree, at, impulses)
        own = self.in_joints(joint_impulses)
        known = kane.generalized_impulse(at, forces, couples) + self._on_speeds(own)
        masses = kane.generalized_masses(at)
        dy = kane.solve_for_speeds(numbers, masses, known, self._on_singular)
        row_impulses = numbers.zeros(0)
        total = known
        if len(demands):
            matrix = demands.matrix(numbers, at.linear, at.angular) + demands.speeds
            missing = demands.target - matrix @ (before + dy)
            size = demands.size(matrix, before, dy)
            row_impulses = kane.impulses_of_rows(
                numbers, masses, matrix, missing, size, demands.names, self._on_singular
            )
            forces = forces + np.tensordot(row_impulses, demands.linear, axes=([0], [0]))
            couples = couples + np.tensordot(row_impulses, demands.angular, axes=([0], [0]))
            on_speeds = row_impulses @ demands.speeds
            for body in tree.bodies:
                if not body.joint.mimics:
                    own[body.joint.name] = own[body.joint.name] + on_speeds[body.joint.speeds]
            total = known + row_impulses @ matrix
            dy = kane.solve_for_speeds(numbers, masses, total, self._on_singular)
        after = before + dy
        momentum_before = kane.generalized_momentum(at, before)
        momentum_after = kane.generalized_momentum(at, after)
        body_dv, body_domega = at.velocities(dy)
        return KaneImpact(
            system=self,
            dy=dy,
            y_before=before,
            y_after=after,
            generalized_impulse=total,
            momentum_before=momentum_before,
            momentum_after=momentum_after,
            generalized_masses=masses,
            body_dv=body_dv,
            body_domega=body_domega,
            energy_before=before @ momentum_before / 2,
            energy_after=after @ momentum_after / 2,
            row_impulses=row_impulses,
            _at=at,
            _impulses=forces,
            _couples=couples,
            _own_impulses=own,
        )

    # -- constraint rows -----------------------------------------------------------

    def rows_at_point(
        self,
        q: Any,
        link: str,
        other: str = "world",
        at: Any = (0, 0, 0),
        other_at: Any = (0, 0, 0),
        directions: Any = None,
        target: Any = None,
    ) -> Rows:
        """Rows on the velocity of a point of ``link`` against one of ``other``.

        See :func:`~impulsekit.reference.rows.point_velocity_rows`.
        """
        where = self.kinematics(q)
        return point_velocity_rows(self.tree, where, link, other, at, other_at, directions, target)

    def rows_of_turning(
        self, link: str, other: str = "world", directions: Any = None, target: Any = None
    ) -> Rows:
        """Rows on the angular velocity of ``link`` against ``other``, world directions."""
        return angular_velocity_rows(self.tree, link, other, directions, target)

    def rows_on_speeds(self, matrix: Any, target: Any = None) -> Rows:
        """Rows matrix (r, n) @ y = target (r,) on the generalized speeds themselves."""
        return speed_rows(self.tree, matrix, target)

    def stack(self, *rows: Rows) -> Rows:
        """All rows of several sets."""
        return Rows.stack(self.tree, rows)

    # -- motion --------------------------------------------------------------------

    def generalized_active_force(
        self,
        q: Any,
        y: Any,
        gravity: Any = (0, 0, 0),
        forces: Iterable[Load] = (),
        joint_torques: Mapping[str, Any] | None = None,
        springs: Iterable[JointSpring | PointSpring] = (),
    ) -> Array:
        """(n,) F_l (eqs. 7-10); arguments are those of :meth:`accelerations`."""
        checked = self.tree.configuration(q)
        at = self._kinematics_of(checked)
        return _closed(
            self._active(checked, at, self.tree.speeds(y), gravity, forces, joint_torques, springs)
        )

    def accelerations(
        self,
        q: Any,
        y: Any,
        gravity: Any = (0, 0, 0),
        forces: Iterable[Load] = (),
        joint_torques: Mapping[str, Any] | None = None,
        springs: Iterable[JointSpring | PointSpring] = (),
    ) -> Array:
        """(n,) ẏ from Kane's equations F_l + F*_l = 0 (Chang & Huston 1995, eq. 17).

        Args:
            q: (nq,) configuration. y: (n,) generalized speeds.
            gravity: (3,) m/s², world axes.
            forces: forces and couples on links.
            joint_torques: by joint, a number or one for each of its speeds.
            springs: in joints, and between points.
        """
        checked, speeds = self.tree.configuration(q), self.tree.speeds(y)
        at = self._kinematics_of(checked)
        active = self._active(checked, at, speeds, gravity, forces, joint_torques, springs)
        rates = partial_rates(self.tree, at, speeds)
        return _closed(
            kane.accelerations(self.arithmetic, at, rates, speeds, active, self._on_singular)
        )

    def _active(
        self,
        q: Array,
        at: Kinematics,
        y: Array,
        gravity: Any,
        forces: Iterable[Load],
        joint_torques: Mapping[str, Any] | None,
        springs: Iterable[JointSpring | PointSpring],
    ) -> Array:
        outside, couples = loads.at_mass_centres(self.tree, at, forces)
        outside += at.masses[:, None] * loads.vector(self.tree, gravity, "gravity")
        in_joints = self.in_joints(joint_torques)
        for spring in springs:
            if isinstance(spring, PointSpring):
                pull, turn = loads.pull_of(spring, self.tree, at, y)
                outside += pull
                couples += turn
                continue
            joint = self.tree.joint(spring.joint)
            if len(joint.linear) != 1:
                raise RangeError.of(
                    f'joint of a spring, "{joint.name}"', joint.kind, "one with a single speed"
                )
            number = self.arithmetic.number
            stretch = joint_coordinate(joint, q, self.arithmetic) - number(spring.rest)
            rate = joint.multiplier * y[joint.first_speed]
            in_joints[joint.name] = in_joints[joint.name] - (
                number(spring.stiffness) * stretch + number(spring.damping) * rate
            )
        return kane.generalized_active_force(at, outside, couples) + self._on_speeds(in_joints)

    # -- inside joints ---------------------------------------------------------------

    def checked_rows(self, rows: Rows) -> Rows:
        """The rows given, if they belong to this system."""
        wanted = (len(rows), len(self.tree.bodies), 3)
        if rows.linear.shape != wanted or rows.speeds.shape != (len(rows), self.n):
            raise ShapeError.of("constraint rows", wanted, rows.linear.shape, "of another system")
        return rows

    def in_joints(self, given: Mapping[str, Any] | None) -> dict[str, Array]:
        """What acts inside each joint along its own speeds, by name: zeros unless given.

        A joint that mimics another may have an impulse or torque of its own as well.
        """
        numbers = self.arithmetic
        own = {b.joint.name: numbers.zeros(len(b.joint.linear)) for b in self.tree.bodies}
        for name, value in (given or {}).items():
            joint = self.tree.joint(name)
            what = f'joint "{name}"'
            checked = numbers.finite_array(np.atleast_1d(np.asarray(value)), what)
            if checked.shape != own[joint.name].shape:
                raise ShapeError.of(what, own[joint.name].shape, checked.shape)
            own[joint.name] = checked
        return own

    def _on_speeds(self, own: Mapping[str, Array]) -> Array:
        """The same on the generalized speeds, (n,)."""
        total = self.arithmetic.zeros(self.n)
        for body in self.tree.bodies:
            total[body.joint.speeds] += body.joint.multiplier * own[body.joint.name]
        return total


def _closed(values: Array) -> Array:
    read_only(values)
    return values
