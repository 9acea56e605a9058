"""Accelerations: by the articulated-body algorithm in free flight, by rows where something holds.

M a = τ − h + Aᵀλ + JᵀP with A a = −Ȧ v for what is held, and Coulomb's law on J a + J̇ v for
the contacts that rest (Chang & Huston 1995, eq. (17), with multipliers) and for joints with dry
friction that stand still.
"""

from __future__ import annotations

from math import isfinite

import numpy as np
import pinocchio as pin

from ...geometry.point_table import Kinematics, Table
from ...impact.elimination import CONTRADICTION, Elimination
from ...impact.factor import DenseFactor, Factor, MassFactor
from ...impact.singular import check_pivots, pivots_are_safe
from ...laws.half import Factor as Halves
from ...laws.rank_tolerances import FAINT_PIVOT, SMALLEST_PIVOT
from ...laws.tolerances import RESIDUAL_LIMIT
from ...robot.masses import crba_of, is_always_regular, symmetric
from ...rows.reach import reached_model
from ...scene import Scene
from ..forces.field import ForceField
from ..gaps.contacts import Gaps
from ..rest.contacts import Resting
from ..rest.law import solve_rest
from ..tree.memory import Memory
from ..tree.pressed import Loaded, pressed
from .held import HeldRows

__all__ = ["Dynamics"]

# Dependent rows may differ by 1e-12 of what balances in them, by rounding: in units of what
# ``Elimination.solve`` lets them differ by.
ROUNDED = 1e-12 / CONTRADICTION
# Rows that constraints leave less than this of their mobility, in squares, move nothing.
IMMOBILE = 1e-20

# Bound once: this runs at every stage of every step.
_aba, _forward, _jacobians = pin.aba, pin.forwardKinematics, pin.computeJointJacobians
_crba, _decompose = pin.crba, pin.cholesky.decompose


class Dynamics:
    """The accelerations of a scene's robot, with all that acts during a motion.

    Attributes:
        model: the robot's, with the scene's gravity and frames of its own.
        forces: what acts besides weight, constraints and contacts.
        held: the bilateral constraints; None without any.
        gaps: the distances of the contacts; None without any.
        resting: the contacts that rest now.
        evaluations: how often accelerations were worked out.
        borne: what the constraints bore at the last evaluation (m,), and whether that of each is
            determined (m,), None where all are; None without any.
    """

    def __init__(self, scene: Scene) -> None:
        robot = scene.robot
        reached = reached_model(robot.model, range(1, robot.model.njoints), keep_places=True)
        self.model = reached.model
        self.model.gravity.linear = np.array(scene.gravity)
        self.forces = ForceField(scene)
        self.held = HeldRows(scene, reached) if scene.constraints else None
        self.gaps = Gaps(scene, reached) if scene.contacts else None
        # Frames for points are there now: from here on data may be made.
        self._data, memory = self.model.createData(), Memory(self.model)
        self._moving = memory.data
        self._memory, self._kinematics = memory, memory.kinematics
        self._own_factor = Halves(
            memory.factor, memory.pivots, memory.mass, memory.branch, SMALLEST_PIVOT
        )
        self._zero = np.zeros(self.model.nv)
        self._crba = crba_of(self.model)
        mimic = len(self.model.mimicking_joints) > 0
        # Rows have to make up for what M lacks at every configuration, whatever pivots say.
        self._singular = bool(robot.massless_motions)
        self._mass_factor = MassFactor(self.model, self._data, singular=self._singular)
        self._no_aba = mimic
        self._in_one_call = self.held is None and self._mass_factor.is_sparse
        self.resting = Resting(scene)
        # Free flight under constant torques needs nothing but one call.
        free = self.held is None and not mimic
        free = free and self.resting.joints is None
        self._torque = self.forces.constant_torque if free else None
        self.evaluations = 0
        self.borne: tuple[np.ndarray, np.ndarray | None] | None = None

    @property
    def needs_rows(self) -> bool:
        """Whether constraints, or a mass matrix that is not regular, ask for rows."""
        return self.held is not None or self._no_aba or self._singular

    def acceleration(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """(nv,) v̇.

        Raises:
            ContradictionError: constraints that cannot hold together.
            RestNotSolved: no forces at the resting contacts.
        """
        self.evaluations += 1
        if self._torque is not None and not self.resting.contacts:
            return _aba(self.model, self._data, q, v, self._torque)
        resting = self.resting
        joints, in_one_call = resting.joints, self._in_one_call and resting.is_compiled
        in_one_call = in_one_call and (joints is None or not len(joints.still))
        if in_one_call and resting.contacts and self.gaps is not None:
            table, kinematics = self.gaps.table(self.resting.contacts), self._kinematics
            if table is not None and kinematics is not None:
                found = self._pressed(table, kinematics, t, q, v)
                if found is not None:
                    return found
        if self.held is not None or resting.acts or self._no_aba:
            return self._with_rows(t, q, v)
        torque = self._torques(t, q, v)
        if self.forces.on_bodies:
            pin.forwardKinematics(self.model, self._moving, q, v)
            wrenches = self.forces.wrenches(t, self._memory)
            return _aba(self.model, self._data, q, v, torque, wrenches)
        return _aba(self.model, self._data, q, v, torque)

    def _torques(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """(nv,) what acts along the generalized speeds, dry friction of moving joints included."""
        torque, joints = self.forces.torque(t, q, v), self.resting.joints
        return torque if joints is None else joints.add_moving(torque)

    def moved(self, q: np.ndarray, rows: np.ndarray, change: np.ndarray) -> np.ndarray:
        """(nv,) the velocity change, least in the metric of M, that changes rows' velocities."""
        factor = self._factor(q, rows)
        impulse = Elimination(factor.half(rows)).solve(change).impulse
        # Of M + ρ AᵀA, too: it differs from M by what is prescribed.
        return factor.solve(impulse.dot(rows))

    def mass_matrix(self, q: np.ndarray) -> np.ndarray:
        """(nv, nv) M at q."""
        nv = self.model.nv
        return symmetric(np.array(self._crba(self.model, self._data, q)).reshape(nv, nv))

    def refuse_singular(self, q: np.ndarray) -> None:
        """Prove that M is regular at q; where it is not, rounding would say how bodies fall.

        Raises:
            SingularMassError: it names the joints that move no inertia.
        """
        model, data = self.model, self._data
        if model.nv == 0:
            return
        if self._mass_factor.is_dense:
            DenseFactor(model, self.mass_matrix(q), singular=True)
            return
        self._crba(model, data, q)
        _decompose(model, data)
        if not (pivots_are_safe(data, FAINT_PIVOT) or is_always_regular(model)):
            check_pivots(model, data)

    def _factor(self, q: np.ndarray, rows: np.ndarray) -> Factor:
        self._crba(self.model, self._data, q)
        return self._mass_factor.at(rows)

    def _pressed(
        self, table: Table, kinematics: Kinematics, t: float, q: np.ndarray, v: np.ndarray
    ) -> np.ndarray | None:
        """(nv,) v̇ where nothing but points that rest is held; None where M is nearly singular, or
        no forces were found."""
        model, data, resting = self.model, self._moving, self.resting
        if len(table.whole) > 1:
            pressed.load()
        _forward(model, data, q, v, self._zero)
        _jacobians(model, data)
        _crba(model, data, q)
        _decompose(model, data)
        load = self._torques(t, q, v)
        if self.forces.on_bodies:
            load = load - pin.rnea(
                model, self._data, q, v, self._zero, self.forces.wrenches(t, self._memory)
            )
        else:
            load = load - pin.nonLinearEffects(model, self._data, q, v)
        if not isfinite(load.sum()):
            return np.full(model.nv, np.nan)
        v = np.ascontiguousarray(v)
        state = Loaded(table, kinematics, self._own_factor, resting.sliding(), load, v)
        last = resting.last_forces(len(table.whole))
        residual, rate, forces, accelerations, slip = pressed(state, last)
        if not 0.0 <= residual <= RESIDUAL_LIMIT:
            return None
        resting.note(forces, accelerations, slip)
        return rate

    def _with_rows(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        model, data, moving = self.model, self._data, self._moving
        pin.forwardKinematics(model, moving, q, v, self._zero)
        load = self._torques(t, q, v)
        if self.forces.on_bodies:
            load = load - pin.rnea(
                model, data, q, v, self._zero, self.forces.wrenches(t, self._memory)
            )
        else:
            load = load - pin.rnea(model, data, q, v, self._zero)
        if not np.isfinite(load).all():
            return np.full(model.nv, np.nan)
        held = self.held
        rows = np.empty((0, model.nv)) if held is None else held.rows.matrix(data, q)
        wanted = np.empty(0) if held is None else held.rate_at(t) - held.rows.bias(moving, q, v)
        factor = self._factor(q, rows)
        load = factor.filled(load, wanted)
        if not self.resting.acts:
            half = factor.half(rows, load[None])
            eliminated = self._eliminated(half[:, :-1])
            multipliers = self._multipliers(eliminated, half[:, -1], wanted, q, v)
            return factor.solve(load + multipliers.dot(rows))
        return self._with_rest(factor, load, rows, wanted, q, v)

    def _with_rest(
        self,
        factor: Factor,
        load: np.ndarray,
        rows: np.ndarray,
        wanted: np.ndarray,
        q: np.ndarray,
        v: np.ndarray,
    ) -> np.ndarray:
        resting, count = self.resting, len(rows)
        jacobian, bias, used = self._rest_rows(q, v)
        if (pulls := resting.pulls()) is not None:
            load = load - pulls.dot(jacobian[2 : 3 * len(pulls) : 3])
        half = factor.half(rows, jacobian[used], load[None])
        half_rows, start = half[:, :count], half[:, -1]
        half_contacts = np.zeros((len(half), len(jacobian)))
        half_contacts[:, used] = half[:, count:-1]
        free = bias + start.dot(half_contacts)
        left = half_contacts
        if count:
            eliminated = self._eliminated(half_rows)
            held = self._multipliers(eliminated, start, wanted, q, v)
            free = free + (half_rows.dot(held)).dot(half_contacts)
            left = eliminated.off_the_span(half_contacts)
        if np.abs(free).max(initial=0.0) <= resting.negligible:
            free = np.zeros_like(free)
        slip, points = jacobian.dot(v), 3 * len(resting.friction())
        delassus = left.T.dot(left)
        resting.size = float(np.abs(free[:points]).max(initial=0.0))
        if pulls is not None:
            # What they hold may hang in balance with them.
            alone = delassus.diagonal()[2:points:3] * pulls
            resting.size = max(resting.size, float(alone.max()))
        if resting.rolling is not None:
            forces = resting.rolling.forces(resting, delassus, free, slip)
        else:
            moves = delassus.diagonal() > IMMOBILE * np.einsum("ij,ij->j", *2 * [half_contacts])
            forces = self._forces_at_rest(delassus, free, slip, moves)
        total = load + forces.dot(jacobian)
        if count:
            start = start + half_contacts.dot(forces)
            total = total + self._multipliers(eliminated, start, wanted, q, v).dot(rows)
        return factor.solve(total)

    def _rest_rows(self, q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(r, nv) the rows of what rests, (r,) their rates without accelerations, and which count:
        points, three rows each, then their turning, or joints that stand still."""
        resting, gaps, nv = self.resting, self.gaps, self.model.nv
        jacobian, bias, used = np.empty((0, nv)), np.empty(0), np.empty(0, dtype=bool)
        if gaps is not None and resting.contacts:
            jacobian, bias = gaps.rows_and_bias(resting.contacts, q, v, self._memory)
            # Tangents without friction carry nothing: they are left zero.
            used = np.repeat(resting.friction() > 0.0, 3)
            used[2::3] = True
        rolling, joints = resting.rolling, resting.joints
        more, rates = np.empty((0, nv)), np.empty(0)
        if gaps is not None and rolling is not None:
            rates = rolling.rates_of(gaps, resting.contacts, self._moving, q, v)
            more = rolling.rows(gaps, resting.contacts, self._moving)
        elif joints is not None:
            more = np.eye(nv)[joints.rows[joints.still]]
            rates = np.zeros(len(more))
        if not len(more):
            return jacobian, bias, used
        used = np.concatenate([used, np.ones(len(more), dtype=bool)])
        return np.vstack([jacobian, more]), np.concatenate([bias, rates]), used

    def _forces_at_rest(
        self, delassus: np.ndarray, free: np.ndarray, slip: np.ndarray, moves: np.ndarray
    ) -> np.ndarray:
        """(r,) forces of points, two tangents and the normal of each, and of joints.

        ``moves``: by row, whether a force along it moves anything that constraints leave.
        """
        resting, joints = self.resting, self.resting.joints
        friction = resting.friction()
        points, last, bounds = 3 * len(friction), resting.last_forces(len(friction)), None
        still = np.empty(0, dtype=int) if joints is None else joints.still
        if joints is not None:
            bounds = np.where(moves[points:], joints.bounds[still], 0.0)
            last = np.concatenate([last, joints.last(still)])
        if resting.slide():
            ways = np.eye(len(free))
            ways[:points, :points], friction = resting.ways(slip[:points], friction)
            found = solve_rest(delassus, free, friction, last, ways, bounds)
            forces = ways.dot(found)
        else:
            forces = found = solve_rest(delassus, free, friction, last, None, bounds)
        rates = free + delassus.dot(forces)
        resting.note(found[:points], rates[:points], slip[:points])
        if joints is not None:
            rates = np.where(moves[points:], rates[points:], 0.0)
            joints.note(still, found[points:], rates, float(np.abs(free).max(initial=0.0)))
        return forces

    def _eliminated(self, half_rows: np.ndarray) -> Elimination:
        if self.held is None:
            return Elimination(half_rows)
        return Elimination(half_rows, self.held.rows.names, self.held.rows.triples)

    def _multipliers(
        self,
        eliminated: Elimination,
        start: np.ndarray,
        wanted: np.ndarray,
        q: np.ndarray,
        v: np.ndarray,
    ) -> np.ndarray:
        """λ that brings the rows' accelerations to what is wanted."""
        half_rows, held, data = eliminated.half, self.held, self._data

        def scale() -> np.ndarray:
            sums = np.abs(half_rows.T @ start) + np.abs(half_rows).T @ np.abs(start)
            if held is None:
                return sums
            # What hangs or turns in balance has accelerations of rounding alone, which is small
            # beside what balances: weights, and the turning of all that moves.
            # Not by a power, which fails where a product is infinite.
            fastest = float(np.abs(v).max())
            turning = held.rows.magnitude(data, q).sum(axis=1) * (fastest * fastest)
            weight = float(np.linalg.norm(self.model.gravity.linear))
            return sums + ROUNDED * (turning + weight)

        solution = eliminated.solve(wanted - start.dot(half_rows), scale)
        self.borne = solution.impulse, solution.unique
        return solution.impulse
