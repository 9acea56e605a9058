"""``Impact``: the result, and quantities derived from it on first access."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from .._core import RESIDUAL_LIMIT, judge
from .._core import Status as Code
from ..errors.calls import public
from ..formatting import one_line
from ..named import ByName
from ..robot.arrays import read_only
from ..scene.numbers import not_negative
from .status import BY_CODE, Status
from .touched import TouchedAnswer

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from .all_outcomes import Outcomes
    from .energy import Energy
    from .joint_loads import JointLoad
    from .residuals import Residuals
    from .uniqueness import Uniqueness
    from .velocities import LinkJump, PointVelocity

__all__ = ["Impact"]


@public
class Impact(TouchedAnswer):
    """The result of an impact at one state.

    ``dv`` is computed by ``solve``; everything else is computed on first access. All arrays
    are read-only.

    Attributes:
        scene: the scene that was solved.

    Example:
        >>> from impulsekit import AppliedImpulse, Robot, Scene, solve
        >>> robot = Robot.from_example("panda")
        >>> scene = Scene(robot, [AppliedImpulse("panda_hand", linear=[0, 0, 1])])
        >>> impact = solve(scene, robot.neutral(), robot.velocity())
        >>> impact.bodies["panda_hand"].dv_com.shape
        (3,)
        >>> bool(impact.energy.after > 0)
        True
    """

    @property
    def mass_matrix(self) -> np.ndarray:
        """(nv, nv) M at q, the generalized masses a_lp (Chang & Huston 1995, eq. (30))."""
        return read_only(self.mechanics.mass_matrix)

    @cached_property
    def jacobian(self) -> np.ndarray:
        """(3n, nv) J: u = J v of the n points that touch, two tangents, then the normal.

        In the order of the contacts; after all points come three rows of each that resists
        rolling or spin, of the relative angular velocity along the same axes.
        """
        touches = () if self.outcome is None else self.outcome.touches
        rows = [touch.jacobian for touch in touches]
        return read_only(np.concatenate([np.zeros((0, len(self._v))), *rows]))

    @cached_property
    def delassus(self) -> np.ndarray:
        """(3n, 3n) W = J M⁻¹ Jᵀ of the points that touch, the bilateral rows eliminated.

        u⁺ = u_free + W P with the impulses P along the rows of ``jacobian``.

        Example:
            >>> from impulsekit import Contact, Robot, Scene, solve
            >>> ball = Robot.from_urdf("models/ball.urdf", root="freeflyer")
            >>> scene = Scene(ball, contacts=[Contact("ball", restitution=0.5)])
            >>> impact = solve(scene, ball.neutral(), [0, 0, -2, 0, 0, 0])
            >>> bool(impact.delassus[2, 2] * impact.mass_matrix[0, 0] == 1.0)
            True
        """
        return read_only(self.mechanics.responses(self.jacobian).delassus)

    @cached_property
    def bodies(self) -> Mapping[str, LinkJump]:
        """Velocity change of every link of the URDF, links behind fixed joints too."""
        from .velocities import link_jumps

        return ByName(link_jumps(self), "link")

    @cached_property
    def reactions(self) -> Mapping[str, np.ndarray]:
        """By joint name, (6,) the wrench impulse that the parent gives the child.

        At the joint's origin, world axes, linear [N s] before angular [N m s]. Fixed
        joints of the URDF are there too, and "root_joint" is what the ground gives a
        robot on a fixed base.
        """
        from .flat.links import flat_links_of

        return ByName(flat_links_of(self.scene.robot).reactions(self.loads), "joint")

    @cached_property
    def joint_loads(self) -> Mapping[str, JointLoad]:
        """By joint name, its reaction in the joint's own axes.

        ``axial`` and ``shear`` force [N s], ``torque`` about the joint's axis and ``bending``
        moment [N m s]; ``force`` and ``moment`` (3,) in the axes of the joint's frame.

        Example:
            >>> from impulsekit import AppliedImpulse, Robot, Scene, solve
            >>> from impulsekit.models import pendulum_urdf
            >>> rod = Robot.from_urdf(pendulum_urdf(1))
            >>> blow = AppliedImpulse("link_1", linear=[3, 0, 0], at=[0, 0, -1])
            >>> impact = solve(Scene(rod, [blow]), rod.neutral(), rod.velocity())
            >>> load = impact.joint_loads["joint_1"]
            >>> round(load.shear, 12), round(load.axial, 12), round(load.torque, 12)
            (1.5, 0.0, 0.0)
        """
        from .joint_loads import joint_loads

        return ByName(joint_loads(self, self.reactions), "joint")

    @cached_property
    def energy(self) -> Energy:
        """Kinetic energy before and after, and the work of every entry [J]."""
        from .energy import energy_books

        return energy_books(self)

    @cached_property
    def residuals(self) -> Residuals:
        """Relative residuals of the impact's equations."""
        from .residuals import residuals_of

        return residuals_of(self)

    @cached_property
    def status(self) -> Status:
        """The status, with advice; the same for ``solve``, batches and commands.

        Whether other v⁺ obey the law as well is no part of it: see ``uniqueness``.
        """
        outcome = self.outcome
        contacts = None if outcome is None else outcome.contacts
        found = Code.solved if contacts is None else Code(int(contacts.status))
        nearly = outcome is not None and outcome.nearly_dependent
        return BY_CODE[judge(found, dataclasses.astuple(self.residuals), nearly)]

    @cached_property
    def uniqueness(self) -> Uniqueness:
        """The uniqueness of v⁺ among those that gain no energy; computed on first access.

        Without friction, with friction that is weak against the coupling of the contacts, at one
        contact, and of up to four contacts in a plane it is proven or others are found; in space
        few contacts are searched, and of more what is beside the answer shown.
        """
        from .uniqueness import uniqueness_of

        return uniqueness_of(self)

    def outcomes(self, samples: int = 4096, seed: int = 0) -> Outcomes:
        """Return the v⁺ that contacts may leave when they compress in any order and shares.

        Args, Raises: as ``impulsekit.outcomes``.
        """
        from .all_outcomes import outcomes_of

        return outcomes_of(self, samples, seed)

    @cached_property
    def doubts(self) -> tuple[str, ...]:
        """Warnings about likely mistakes in the scene and its state, one sentence each.

        Contacts and anchors that are open, or overlap, by more than ``Scene.gap_bound``; a
        robot under its floor; joints outside their limits; a scene in which nothing strikes.
        The answer is right all the same for what was given. ``solve`` warns of them the first
        time that a scene is solved, with a ``SetupWarning``.
        """
        from .doubts import doubts_of

        return doubts_of(self)

    def is_valid(self, tol: float = RESIDUAL_LIMIT) -> bool:
        """Return True if the status is valid and every residual is within ``tol``.

        Raises:
            NotFiniteError, RangeError: a ``tol`` that is no number from 0 up.
        """
        if tol is not RESIDUAL_LIMIT:
            tol = not_negative(tol, "tol")
        return self.status.valid and self.residuals.largest <= tol

    def describe_status(self) -> str:
        """The status, the largest residual and what to do about it, in one line."""
        residual = f"largest residual {self.residuals.largest:.2g}"
        return f"{self.status.name}, {residual}: {self.status.value}"

    def velocity_at(self, frame: str, at: ArrayLike = (0.0, 0.0, 0.0)) -> PointVelocity:
        """The velocity of a point of a frame, before and after the impact, in world axes.

        Args:
            frame: the frame that carries the point.
            at: the point in the frame's coordinates [m].

        Raises:
            UnknownNameError, ShapeError, NotFiniteError.
        """
        from .velocities import point_velocity

        return point_velocity(self, frame, at)

    def to_dict(self) -> dict[str, Any]:
        """Everything, ready for JSON; SI units, world axes. Contacts that do not touch by name."""
        return {
            "robot": self.scene.robot.name,
            "joints": list(self.scene.robot.joint_names),
            "status": self.status.name,
            "advice": self.status.value,
            "valid": self.is_valid(),
            "doubts": list(self.doubts),
            "uniqueness": self.uniqueness.to_dict(),
            "q": self.q.tolist(),
            "v_before": self.v_before.tolist(),
            "v_after": self.v_after.tolist(),
            "dv": self.dv.tolist(),
            "generalized_impulse": self.generalized_impulse.tolist(),
            "momentum_before": self.momentum_before.tolist(),
            "momentum_after": self.momentum_after.tolist(),
            "bodies": {
                name: {"dv_com": jump.dv_com.tolist(), "domega": jump.domega.tolist()}
                for name, jump in self.bodies.items()
            },
            "reactions": {name: wrench.tolist() for name, wrench in self.reactions.items()},
            "constraints": [result.to_dict() for result in self.constraints],
            "contacts": [result.to_dict() for result in self.contacts if result.touching],
            "not_touching": [result.name for result in self.contacts if not result.touching],
            "energy": self.energy.to_dict(),
            "residuals": dataclasses.asdict(self.residuals),
        }

    def __repr__(self) -> str:
        name, jump = self.scene.robot.name, f"|dv|={np.linalg.norm(self._dv):.6g}"
        residual = f"largest residual {self.residuals.largest:.1e}"
        return one_line("Impact", self.status.name, repr(name), jump, residual)
