"""``Impact``: the answer, and what follows from it, imported and worked out when asked for."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ..display import Displayed, one_line
from ..laws.status import Status, judged
from ..laws.tolerances import RESIDUAL_LIMIT
from ..robot.arrays import read_only
from ..scene.numbers import not_negative
from .named import ByName, Named

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ..scene import Scene
    from .constraint_results import ConstraintResult
    from .contact_results import ContactResult
    from .energy import Energy
    from .joint_loads import JointLoad
    from .kinematics import PointVelocity
    from .links import LinkJump
    from .mechanics import Mechanics
    from .outcome import Outcome
    from .residuals import Residuals
    from .uniqueness import Uniqueness

__all__ = ["Impact"]


class Impact(Displayed):
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

    def __init__(
        self,
        scene: Scene,
        q: np.ndarray,
        v: np.ndarray,
        dv: np.ndarray,
        outcome: Outcome | Callable[[], Outcome] | None = None,
    ) -> None:
        self.scene = scene
        self._q = q
        self._v = v
        self._dv = dv
        self._outcome = outcome

    @property
    def q(self) -> np.ndarray:
        """(nq,) the configuration; an impact does not change it."""
        return read_only(self._q)

    @property
    def v_before(self) -> np.ndarray:
        """(nv,) the velocity before the impact."""
        return read_only(self._v)

    @property
    def dv(self) -> np.ndarray:
        """(nv,) the velocity jump Δv = v⁺ − v⁻."""
        return read_only(self._dv)

    @cached_property
    def v_after(self) -> np.ndarray:
        """(nv,) the velocity after the impact."""
        return read_only(self._v + self._dv)

    @cached_property
    def mechanics(self) -> Mechanics:
        """Mass matrix, placements and Jacobians at q, for all that is derived from ``dv``."""
        from .mechanics import Mechanics

        return Mechanics(self.scene, self._q, self._v)

    @cached_property
    def generalized_impulse(self) -> np.ndarray:
        """(nv,) I_l = Σ_k v_k^l·∫F_k dt + ω_k^l·∫M_k dt (Chang & Huston 1995, eq. (18))."""
        return read_only(sum(self.impulse_shares.values(), np.zeros(len(self._v))))

    @cached_property
    def impulse_shares(self) -> Mapping[str, np.ndarray]:
        """The books of momentum: by entry name, (nv,) its share in the generalized impulse."""
        shares = self.mechanics.known_impulses()
        if self.constraints:
            matrix, slices = self.mechanics.constraint_matrix, self.mechanics.flat.slices
            for result, where in zip(self.constraints, slices, strict=True):
                shares[result.name] = result.impulse @ matrix[where]
        shares.update(self._contact_shares())
        return ByName({n: read_only(share) for n, share in shares.items()}, "entry")

    def _contact_shares(self) -> dict[str, np.ndarray]:
        shares = {n: np.zeros(len(self._v)) for n in self.scene.entry_names("contacts")}
        outcome = self.outcome
        if outcome is not None and outcome.contacts is not None:
            names = tuple(shares)
            triples = outcome.contacts.impulse.reshape(-1, 3)
            for touch, impulse in zip(outcome.touches, triples, strict=True):
                shares[names[touch.entry]] += impulse @ touch.jacobian
        return shares

    @cached_property
    def constraints(self) -> Named[ConstraintResult]:
        """What each constraint of the scene carried, in their order; by name, too."""
        from .constraint_results import constraint_results

        found = (self.mechanics, self.outcome, self.v_before, self.v_after)
        return Named(constraint_results(*found), "constraint")

    @cached_property
    def contacts(self) -> Named[ContactResult]:
        """What happened at each contact of the scene, in their order; by name, too."""
        from .contact_results import contact_results

        return Named(contact_results(self), "contact")

    @property
    def outcome(self) -> Outcome | None:
        """What the solver found besides ``dv``; None where there was nothing else."""
        if callable(self._outcome):
            self._outcome = self._outcome()
        return self._outcome

    @cached_property
    def momentum_before(self) -> np.ndarray:
        """(nv,) P_l = a_lp y_p before the impact (Chang & Huston 1995, eq. (29))."""
        return read_only(self.mechanics.mass_matrix @ self._v)

    @cached_property
    def momentum_after(self) -> np.ndarray:
        """(nv,) P_l after the impact (Chang & Huston 1995, eq. (29))."""
        return read_only(self.mechanics.mass_matrix @ self.v_after)

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
        from .links import link_jumps

        return ByName(link_jumps(self), "link")

    @cached_property
    def reactions(self) -> Mapping[str, np.ndarray]:
        """By joint name, (6,) the wrench impulse that the parent gives the child.

        At the joint's origin, world axes, linear [N s] before angular [N m s]. Fixed
        joints of the URDF are there too, and "root_joint" is what the ground gives a
        robot on a fixed base.
        """
        from .reactions import joint_reactions

        return ByName(joint_reactions(self), "joint")

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
        """How well the answer satisfies its own equations, relative."""
        from .residuals import residuals_of

        return residuals_of(self)

    @cached_property
    def status(self) -> Status:
        """How the answer is to be taken; ``solve``, batches and commands ask it.

        Whether other v⁺ obey the law as well is no part of it: see ``uniqueness``.
        """
        outcome = self.outcome
        contacts = None if outcome is None else outcome.contacts
        return judged(
            Status.SOLVED if contacts is None else contacts.status,
            self.residuals.largest,
            nearly_dependent=outcome is not None and outcome.nearly_dependent,
        )

    @cached_property
    def uniqueness(self) -> Uniqueness:
        """Whether other v⁺ obey the law as well; computed on first access.

        Without friction, with friction that is weak against the coupling of the contacts, at one
        contact, and of up to four contacts in a plane it is proven or others are found; in space
        few contacts are searched, and of more what is beside the answer shown.
        """
        from .uniqueness import uniqueness_of

        return uniqueness_of(self)

    @cached_property
    def doubts(self) -> tuple[str, ...]:
        """What of the scene and its state is likely not meant, one sentence each.

        Contacts and anchors that are open, or overlap, by more than ``Scene.gap_bound``; a
        robot under its floor; joints outside their limits; a scene in which nothing strikes.
        The answer is right all the same for what was given. ``solve`` warns of them the first
        time that a scene is solved, with a ``SetupWarning``.
        """
        from .doubts import doubts_of

        return doubts_of(self)

    def is_valid(self, tol: float = RESIDUAL_LIMIT) -> bool:
        """Whether the status is good and every residual is within ``tol``.

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
        from .kinematics import point_velocity

        return point_velocity(self, frame, at)

    def to_dict(self) -> dict[str, Any]:
        """Everything, ready for JSON; SI units, world axes."""
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
            "contacts": [result.to_dict() for result in self.contacts],
            "energy": self.energy.to_dict(),
            "residuals": dataclasses.asdict(self.residuals),
        }

    def __getstate__(self) -> dict[str, Any]:
        # What follows from the answer is worked out again on the other side.
        _ = self.outcome
        return {name: vars(self)[name] for name in ("scene", "_q", "_v", "_dv", "_outcome")}

    def __repr__(self) -> str:
        name, jump = self.scene.robot.name, f"|dv|={np.linalg.norm(self._dv):.6g}"
        residual = f"largest residual {self.residuals.largest:.1e}"
        return one_line("Impact", self.status.name, repr(name), jump, residual)
