"""The reference as one object: a system of bodies, its impacts and its accelerations.

Shares nothing with Pinocchio, neither its URDF reader nor its frames; only its order of
coordinates and speeds.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from impulsekit.errors import ShapeError
from impulsekit.reference import kane, loads
from impulsekit.reference.arithmetic import Array, closed
from impulsekit.reference.impact import KaneImpact
from impulsekit.reference.kinematics import Kinematics, kinematics, partial_rates
from impulsekit.reference.loads import JointSpring, Load, PointSpring
from impulsekit.reference.rows import Rows, point_velocity_rows
from impulsekit.reference.tree import Tree


@dataclass(frozen=True, eq=False)
class KaneSystem(Tree):
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

    def kinematics(self, q: Any) -> Kinematics:
        """Return ω_klm, v_klm and all else that depends on the configuration alone."""
        return kinematics(self, self.configuration(q))

    @cached_property
    def _on_singular(self) -> Any:
        return kane.singular_at(self.speed_names)

    # -- impact ------------------------------------------------------------------

    def generalized_masses(self, q: Any) -> Array:
        """Return (n, n) a_lp (eq. 30)."""
        return closed(kane.generalized_masses(self.kinematics(q)))

    def generalized_impulse(
        self, q: Any, impulses: Iterable[Load] = (), joint_impulses: Mapping[str, Any] | None = None
    ) -> Array:
        """Return (n,) I_l of known impulses (eq. 18); arguments are those of :meth:`impact`."""
        at = self.kinematics(q)
        outside = kane.generalized_impulse(at, *loads.at_mass_centres(self, at, impulses))
        own = loads.in_joints(self, joint_impulses)
        return closed(outside + loads.on_speeds(self, own))

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
        tree, numbers = self, self.arithmetic
        before = tree.speeds(y)
        at = self.kinematics(q)
        demands = Rows.none(tree) if rows is None else rows
        wanted = (len(demands), len(self.bodies), 3)
        if demands.linear.shape != wanted or demands.speeds.shape != (len(demands), self.n):
            raise ShapeError.of(
                "constraint rows", wanted, demands.linear.shape, "of another system"
            )
        forces, couples = loads.at_mass_centres(tree, at, impulses)
        own = loads.in_joints(self, joint_impulses)
        known = kane.generalized_impulse(at, forces, couples) + loads.on_speeds(tree, own)
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
        after, jumps = before + dy, at.velocities(dy)
        momenta = [kane.generalized_momentum(at, each) for each in (before, after)]
        return KaneImpact(
            tree=self,
            dy=dy,
            y_before=before,
            y_after=after,
            generalized_impulse=total,
            momentum_before=momenta[0],
            momentum_after=momenta[1],
            generalized_masses=masses,
            body_dv=jumps[0],
            body_domega=jumps[1],
            energy_before=before @ momenta[0] / 2,
            energy_after=after @ momenta[1] / 2,
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
        """Return the rows on the velocity of a point of ``link`` against one of ``other``.

        See :func:`~impulsekit.reference.rows.point_velocity_rows`.
        """
        where = self.kinematics(q)
        return point_velocity_rows(self, where, link, other, at, other_at, directions, target)

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
        """Return (n,) F_l (eqs. 7-10); arguments are those of :meth:`accelerations`."""
        checked = self.configuration(q)
        at = kinematics(self, checked)
        speeds = self.speeds(y)
        return closed(
            loads.active(self, checked, at, speeds, gravity, forces, joint_torques, springs)
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
        """Return (n,) ẏ from Kane's equations F_l + F*_l = 0 (Chang & Huston 1995, eq. 17).

        Args:
            q: (nq,) configuration. y: (n,) generalized speeds.
            gravity: (3,) m/s², world axes.
            forces: forces and couples on links.
            joint_torques: by joint, a number or one for each of its speeds.
            springs: in joints, and between points.
        """
        checked, speeds = self.configuration(q), self.speeds(y)
        at = kinematics(self, checked)
        active = loads.active(self, checked, at, speeds, gravity, forces, joint_torques, springs)
        rates = partial_rates(self, at, speeds)
        return closed(
            kane.accelerations(self.arithmetic, at, rates, speeds, active, self._on_singular)
        )
