"""``contact_problem``: an impact step by step, on Pinocchio alone.

M by composite rigid bodies, rows by joint Jacobians, constraints by elimination, impulses by the
law: the method of Chang & Huston (1995) with contacts, as it would be written by hand. ``solve``
does the same in one call of the core.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin
from scipy.linalg import cho_factor, cho_solve, lstsq

from ..errors import InputError, ShapeError, SingularMassError, check_kind
from ..errors.calls import public
from ..formatting import OneLine
from ..robot import state
from ..robot.arrays import read_only
from ..robot.base import RobotFrame
from ..robot.masses import crba_of, symmetric
from ..rows.entries import FramePair, FunctionRows, JointRows, Site, rows_of_entry
from ..scene import AppliedImpulse, JointStop, Scene
from ..scene.coefficients import EllipticFriction, restitution_at, static_friction
from ..scene.constraints import KEPT
from ..scene.scene import scene_at
from .contact_law import ContactProblem as LawProblem
from .contact_law import ContactSolution, Turning, solve_contacts
from .flat.scene import flat_of
from .status import Status

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ..scene.law import Law

__all__ = ["SceneProblem", "SceneProblemSolution", "contact_problem"]

# Constraints whose singular values are below this share of the largest are dependent.
DEPENDENT = 1e-9


@public
@dataclass(frozen=True, eq=False, repr=False)
class SceneProblem(OneLine):
    """The matrices and numbers of an impact, before the law decides.

    M Δv = I + Aᵀλ + JᵀP with A v⁺ = b and P by the law (Chang & Huston 1995, eqs. (18) to (32),
    with the impulses of constraints and contacts beside the given ones).

    Attributes:
        mass_matrix: (nv, nv) M, the generalized masses a_lp (eq. (30)).
        generalized_impulse: (nv,) I of the known impulses (eq. (18)).
        velocity: (nv,) v⁻.
        constraint_matrix, constraint_target: (m, nv) A, (m,) b; ``constraint_names`` (m,).
        jacobian: (r, nv) J: t₁, t₂, n of each point that touches, then the relative angular
            velocity about them of each that resists rolling or spin.
        names: (n,) the contact of each point. axes: (n, 3, 3) columns t₁, t₂, n in the world.
        delassus: (r, r) W = J K Jᵀ, K = M⁻¹ under A Δv = 0.
        velocity_before, velocity_free: (r,) u⁻ = J v⁻; u_free with the known impulses and the
            constraints, but without the contacts' impulses.
        law: by which ``solve`` decides.
        coefficients: of the points, as the law takes them; ``models``: friction that is more
            than numbers.
    """

    mass_matrix: np.ndarray
    generalized_impulse: np.ndarray
    velocity: np.ndarray
    constraint_matrix: np.ndarray
    constraint_target: np.ndarray
    constraint_names: tuple[str, ...]
    jacobian: np.ndarray
    names: tuple[str, ...]
    axes: np.ndarray
    delassus: np.ndarray
    velocity_before: np.ndarray
    velocity_free: np.ndarray
    law: Law
    coefficients: LawProblem
    models: tuple[Any, ...] = ()

    def __repr__(self) -> str:
        return (
            f"SceneProblem(nv={len(self.velocity)}, {len(self.constraint_target)} constraint rows, "
            f"{len(self.names)} contact points)"
        )

    def solve(self, law: Law | None = None) -> SceneProblemSolution:
        """Return the impulses by a law, the scene's own by default, and what they do.

        Raises:
            InputError: the law does not accept the contacts.
        """
        own = self.law if law is None else law
        found = solve_contacts(self.coefficients, own, self.models) if len(self.names) else None
        P = np.zeros(len(self.jacobian)) if found is None else found.impulse
        dv, multipliers = _respond(
            self.mass_matrix, self.constraint_matrix,
            self.generalized_impulse + self.jacobian.T @ P,
            self.constraint_target - self.constraint_matrix @ self.velocity,
        )  # fmt: skip
        return SceneProblemSolution(
            read_only(P), read_only(multipliers), read_only(dv), read_only(self.velocity + dv),
            Status.SOLVED if found is None else found.status,
            0.0 if found is None else found.residual, found,
        )  # fmt: skip

    def residual(self, impulses: ArrayLike) -> float:
        """Return how far impulses (r,) are from u⁺ = u_free + W P with P by Newton's law.

        ξ = u⁺ + e min(u⁻, 0) for normals and u_t⁺ for tangents; the natural map of Alart &
        Curnier 1991 with de Saxcé's correction, relative to u_free and the terms of W P.

        Raises:
            ShapeError: not as many impulses as rows.
        """
        P = np.asarray(impulses, dtype=float)
        if P.shape != (len(self.jacobian),):
            raise ShapeError.of("impulses", (len(self.jacobian),), P.shape)
        return _natural_map(self.coefficients, P)


@public
@dataclass(frozen=True, eq=False, repr=False)
class SceneProblemSolution(OneLine):
    """The impulses of a ``SceneProblem`` by a law.

    Attributes:
        impulses: (r,) P [N s; N m s]. constraint_impulses: (m,) λ, of least norm.
        dv, v_after: (nv,).
        status: of the law. residual: of its equations.
        contacts: the law's own answer; None where nothing touches.
    """

    impulses: np.ndarray
    constraint_impulses: np.ndarray
    dv: np.ndarray
    v_after: np.ndarray
    status: Status
    residual: float
    contacts: ContactSolution | None

    def __repr__(self) -> str:
        return f"SceneProblemSolution({self.status.name}, residual {self.residual:.1e})"


@public
def contact_problem(scene: Scene, q: ArrayLike, v: ArrayLike) -> SceneProblem:
    """Return the matrices of an impact, computed step by step on Pinocchio.

    Args:
        scene: what strikes, holds and touches. q, v: (nq,), (nv,) the state before.

    Raises:
        SingularMassError: M is singular; ``solve`` may do with the constraints.
        ShapeError, NotFiniteError, StateError: q or v.

    Example:
        >>> from impulsekit import Contact, Robot, Scene
        >>> ball = Robot.from_urdf("models/ball.urdf", root="freeflyer")  # 0.5 kg
        >>> floor = Contact("ball", restitution=0.5, name="floor")
        >>> fall = ball.velocity(root_joint=[0, 0, -2, 0, 0, 0])
        >>> problem = contact_problem(Scene(ball, contacts=[floor]), ball.neutral(), fall)
        >>> print(problem.delassus[2, 2].round(12), problem.velocity_free[2].round(12))
        2.0 -2.0
        >>> print(problem.solve().impulses[2].round(12))
        1.5
    """
    check_kind(scene, Scene, "contact_problem")
    model = scene.robot.model
    q = state.checked_configuration(model, q)
    v = state.checked_velocity(model, v)
    data = model.createData()
    pin.computeJointJacobians(model, data, q)
    masses = symmetric(crba_of(model)(model, data, q).reshape(model.nv, model.nv))
    impulse = _generalized_impulse(scene, data)
    A, target, held = _constraints(scene, data, q, v)
    points = flat_of(scene).rows(q, v)
    J, names, axes = _touching_rows(scene, data, q, points)
    moved = np.array([_respond(masses, A, row, np.zeros(len(A)))[0] for row in J])
    W = J @ moved.T if len(J) else np.zeros((0, 0))
    free, _ = _respond(masses, A, impulse, target - A @ v)
    before = J @ v
    law_problem, models = _coefficients(scene, points, names, before, W, J @ (v + free))
    return SceneProblem(
        mass_matrix=read_only(masses),
        generalized_impulse=read_only(impulse),
        velocity=read_only(v),
        constraint_matrix=read_only(A),
        constraint_target=read_only(target),
        constraint_names=held,
        jacobian=read_only(J),
        names=names,
        axes=read_only(axes),
        delassus=read_only(law_problem.delassus),
        velocity_before=read_only(before),
        velocity_free=read_only(law_problem.velocity_free),
        law=scene.law,
        coefficients=law_problem,
        models=models,
    )


def _site_jacobian(model: pin.Model, data: pin.Data, site: Site, at: np.ndarray) -> np.ndarray:
    """(6, nv) velocity of the body of a site at a point of the world, linear before angular."""
    if not site.joint_id:
        return np.zeros((6, model.nv))
    # Of one degree of freedom Pinocchio gives a vector.
    rows = pin.getJointJacobian(model, data, site.joint_id, pin.LOCAL_WORLD_ALIGNED)
    rows = rows.reshape(6, model.nv).copy()
    rows[:3] -= pin.skew(at - data.oMi[site.joint_id].translation) @ rows[3:]
    return rows


def _pair_rows(model: pin.Model, data: pin.Data, said: FramePair) -> np.ndarray:
    """(6, nv) the velocity of one frame relative to another along the axes of their rows."""
    first, other = said.places(lambda joint: data.oMi[joint])
    at = first.translation
    beside = at if said.coincides else other.translation
    relative = _site_jacobian(model, data, said.first, at) - _site_jacobian(
        model, data, said.other, beside
    )
    R = said.axes_at(first, other)
    return np.concatenate([R.T @ relative[:3], R.T @ relative[3:]])


def _generalized_impulse(scene: Scene, data: pin.Data) -> np.ndarray:
    """(nv,) I = Σ J_kᵀ p_k (Chang & Huston 1995, eq. (18))."""
    model, robot = scene.robot.model, scene.robot
    impulse = np.zeros(model.nv)
    for entry in scene.impulses:
        said = rows_of_entry(robot, entry)
        if isinstance(entry, AppliedImpulse) and isinstance(said, FramePair):
            impulse += _pair_rows(model, data, said).T @ np.array(entry.values)
        elif isinstance(said, JointRows):
            impulse += said.matrix(model).T @ np.array(entry.values)
    return impulse


def _constraints(
    scene: Scene, data: pin.Data, q: np.ndarray, v: np.ndarray
) -> tuple[np.ndarray, np.ndarray, tuple[str, ...]]:
    """A, b and names of the bilateral rows."""
    scene, model = scene_at(scene, 0.0), scene.robot.model
    blocks, target, names = [np.zeros((0, model.nv))], [np.zeros(0)], []
    for entry, name in zip(scene.held, scene.entry_names("held"), strict=True):
        said = rows_of_entry(scene.robot, entry)
        if isinstance(said, FramePair):
            rows = _pair_rows(model, data, said)[list(said.select)]
        else:
            rows = said.matrix_at(q) if isinstance(said, FunctionRows) else said.matrix(model)
        blocks.append(rows)
        asked = rows @ v if entry.velocity == KEPT else np.asarray(entry.velocity, dtype=float)
        target.append(np.broadcast_to(asked, len(rows)))
        names += [f"{name}.{label}" for label in said.labels]
    return np.concatenate(blocks), np.concatenate(target), tuple(names)


def _touching_rows(
    scene: Scene, data: pin.Data, q: np.ndarray, points: Any
) -> tuple[np.ndarray, tuple[str, ...], np.ndarray]:
    """J, names and axes of the points that touch; the core says which and where they are."""
    model, robot, flat = scene.robot.model, scene.robot, flat_of(scene)
    entry_names = scene.entry_names("contacts")
    places, axes = points.places.reshape(-1, 3), points.axes.reshape(-1, 3, 3)
    blocks: list[np.ndarray] = [np.zeros((0, model.nv))]
    turning: list[np.ndarray] = []
    for i, number in enumerate(points.entries):
        entry = scene.contacts[number]
        if isinstance(entry, JointStop):
            rows = np.zeros((3, model.nv))
            joint = model.joints[robot.joint_id(entry.joint)]
            lower, upper = entry.limits(robot)
            # Opening is positive: away from the limit that is reached.
            at = q[joint.idx_q]
            rows[2, joint.idx_v] = 1.0 if at - lower <= upper - at else -1.0
        elif points.of_bodies[i]:
            joints, frames = flat.ends[number]
            sites = (
                Site(RobotFrame.of(frame, joint, pin.SE3.Identity()))
                for joint, frame in zip(joints, frames, strict=True)
            )
            six = [_site_jacobian(model, data, site, places[i]) for site in sites]
            relative = six[0] - six[1]
            rows, about = axes[i].T @ relative[:3], axes[i].T @ relative[3:]
        else:
            said = rows_of_entry(robot, entry)
            if isinstance(said, FramePair):
                six_rows = _pair_rows(model, data, said)
                rows, about = six_rows[:3], six_rows[3:]
            elif isinstance(said, FunctionRows):
                rows = said.matrix_at(q)
        blocks.append(rows)
        if i in points.turning_of:
            turning.append(about)
    names = tuple(entry_names[number] for number in points.entries)
    return np.concatenate([*blocks, *turning]), names, axes[: len(names)]


def _respond(
    masses: np.ndarray, A: np.ndarray, impulse: np.ndarray, change: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Δv and λ of M Δv = I + Aᵀλ, A Δv = c; redundant rows share λ of least norm."""
    try:
        factor = cho_factor(masses)
    except np.linalg.LinAlgError:
        raise SingularMassError(
            "contact_problem: M is singular: a joint moves no mass; give its link an <inertial>, "
            "or use solve, which lets constraints make up for it",
            joints=(),
        ) from None
    free = cho_solve(factor, impulse)
    if not len(A):
        return free, np.zeros(0)
    through = cho_solve(factor, A.T)
    multipliers = lstsq(A @ through, change - A @ free, cond=DEPENDENT)[0]
    return free + through @ multipliers, multipliers


def _coefficients(
    scene: Scene, points: Any, names: tuple[str, ...], before: np.ndarray,
    W: np.ndarray, free: np.ndarray,
) -> tuple[LawProblem, tuple[Any, ...]]:  # fmt: skip
    """The law's problem, and friction that is more than numbers."""
    entries = [scene.contacts[number] for number in points.entries]
    restitution = [
        restitution_at(entry.restitution, max(-u, 0.0), f"{name}: restitution")
        for entry, name, u in zip(entries, names, before[2::3].tolist(), strict=False)
    ]

    def numbers(what: str) -> np.ndarray:
        return np.array([getattr(entry, what, 0.0) or 0.0 for entry in entries], dtype=float)

    frictions = [getattr(entry, "friction", 0.0) for entry in entries]
    models: tuple[Any, ...] = ()
    if any(callable(mu) or isinstance(mu, EllipticFriction) for mu in frictions):
        ellipses = points.ellipses.reshape(-1, 2)
        models = tuple(
            (mu, ellipses[i] if isinstance(mu, EllipticFriction) else None)
            for i, mu in enumerate(frictions)
        )
    turning = None
    if len(points.turning_of):
        of = np.array(points.turning_of)
        turning = Turning(of, numbers("rolling")[of], numbers("torsion")[of])
    adhesion, stiffness = numbers("adhesion"), numbers("stiffness")
    problem = LawProblem(
        0.5 * (W + W.T), before, free, np.array(restitution, dtype=float),
        np.array([static_friction(mu) for mu in frictions], dtype=float),
        numbers("tangential_restitution"),
        stiffness if scene.law.restitution == "lzb" or scene.law.slip == "compliant" else None,
        adhesion if adhesion.any() else None, turning,
        numbers("stiffness_ratio") if scene.law.slip == "compliant" else None,
        numbers("tangential_damping") if scene.law.slip == "compliant" else None,
    )  # fmt: skip
    return problem, models


def _natural_map(problem: LawProblem, P: np.ndarray) -> float:
    """Return the distance of P from its projection after a step against ξ, over the terms."""
    if problem.turning is not None:
        raise InputError("residual: not for contacts that resist rolling or spin; see solve()")
    W, n = problem.delassus, len(problem.friction)
    after = problem.velocity_free + W @ P
    target = -problem.restitution * np.minimum(problem.velocity_before[2::3], 0.0)
    worst = 0.0
    terms = np.abs(problem.velocity_free).max(initial=0.0) + (np.abs(W) @ np.abs(P)).max(initial=0)
    for i in range(n):
        own = slice(3 * i, 3 * i + 3)
        xi, mu = after[own].copy(), problem.friction[i]
        slip = xi[:2] + problem.tangential_restitution[i] * problem.velocity_before[own][:2]
        xi = np.array([*slip, xi[2] - target[i] + mu * float(np.hypot(*slip))])
        step = 1.0 / max(np.trace(W[own, own]), np.finfo(float).tiny)
        moved = _projected(P[own] - step * xi, mu)
        worst = max(worst, float(np.abs(P[own] - moved).max()) / step)
    return worst / terms if terms > 0.0 else 0.0


def _projected(p: np.ndarray, mu: float) -> np.ndarray:
    """The nearest point of the cone |p_t| ≤ µ p_n; with µ = 0 the tangents are free of it."""
    along = float(np.hypot(p[0], p[1]))
    if mu == 0.0:
        return np.array([0.0, 0.0, max(p[2], 0.0)])
    if along <= mu * p[2]:
        return p
    if mu * along <= -p[2]:
        return np.zeros(3)
    normal = (mu * along + p[2]) / (1.0 + mu * mu)
    return np.array([*(mu * normal / along * p[:2]), normal])
