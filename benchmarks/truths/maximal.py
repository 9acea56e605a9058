"""A third truth: maximal coordinates, where every body is free and joints are rows.

No generalized speeds and no partial velocities enter. Each body has six speeds of its
own, those of its mass centre and its spin in world axes. Each joint is up to six rows on
the motion of its two links, and closed loops are more of the same. With the bodies'
masses M, the impulses f from outside, and rows J Δx = 0 of all joints,

    [ M  Jᵀ ] [ Δx ]   [ f ]
    [ J  0  ] [ −λ ] = [ 0 ]

gives the velocity changes Δx and, in λ, what each joint carries.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from impulsekit.errors import SingularMassError
from impulsekit.reference import loads, rotation
from impulsekit.reference.arithmetic import Arithmetic, Array, read_only
from impulsekit.reference.impact import freed_directions, joint_directions
from impulsekit.reference.kane import consistent_solution
from impulsekit.reference.kinematics import Kinematics
from impulsekit.reference.loads import Load, in_joints
from impulsekit.reference.rows import Rows
from impulsekit.reference.system import KaneSystem
from impulsekit.reference.tree import WORLD, Tree


@dataclass(frozen=True, eq=False)
class MaximalImpact:
    """How an impact changes the motion of N bodies; arrays are read-only.

    Attributes:
        body_dv, body_domega: (N, 3) m/s and rad/s, changes of the mass-centre velocities and
            of the angular velocities, world axes.
        dy: (n,) the same as changes of the generalized speeds.
        joint_reactions: by joint, the impulsive wrench (6,) that the parent link gives the
            child, at the joint's origin, world axes, linear before angular.
        row_impulses: (r,) of the rows that were given.
    """

    body_dv: Array
    body_domega: Array
    dy: Array
    joint_reactions: Mapping[str, Array]
    row_impulses: Array

    def __post_init__(self) -> None:
        read_only(self.body_dv, self.body_domega, self.dy, self.row_impulses)
        read_only(*self.joint_reactions.values())


def impact_of_free_bodies(
    system: KaneSystem,
    q: Any,
    y: Any,
    impulses: Iterable[Load] = (),
    joint_impulses: Mapping[str, Any] | None = None,
    rows: Rows | None = None,
) -> MaximalImpact:
    """Solve an impact in maximal coordinates.

    The arguments and errors are those of :meth:`KaneSystem.impact`.
    """
    tree, numbers = system, system.arithmetic
    before, at = tree.speeds(y), system.kinematics(q)
    given = Rows.none(tree) if rows is None else rows
    joints = _Joints(tree, at)
    forces, couples = loads.at_mass_centres(tree, at, impulses)
    for name, own in in_joints(system, joint_impulses).items():
        linear, angular = joints.own_motion[tree.body_of_joint(name)]
        forces += np.tensordot(own, linear, axes=([0], [0]))
        couples += np.tensordot(own, angular, axes=([0], [0]))

    # Rows on generalized speeds are rows on the motions that the speeds stand for.
    loop_linear = given.linear + np.tensordot(given.speeds, joints.speed_linear, axes=([1], [0]))
    loop_angular = given.angular + np.tensordot(given.speeds, joints.speed_angular, axes=([1], [0]))
    loops = _flat(loop_linear, loop_angular)
    held = _flat(joints.linear, joints.angular)
    outside = _flat(forces[None], couples[None])[0]

    size, extra = 6 * len(tree.bodies), len(held)
    matrix = numbers.zeros(size + extra, size + extra)
    for k in range(len(tree.bodies)):
        for i in range(3):
            matrix[6 * k + i, 6 * k + i] = at.masses[k]
        matrix[6 * k + 3 : 6 * k + 6, 6 * k + 3 : 6 * k + 6] = at.inertias[k]
    matrix[:size, size:] = held.T
    matrix[size:, :size] = held
    right = numbers.zeros(size + extra, 1 + len(loops))
    right[:size, 0] = outside
    right[:size, 1:] = loops.T
    solution = solve_general(numbers, matrix, right, _free_to_move)
    change, carried = solution[:size], -solution[size:]

    motion_before = _flat(*(part[None] for part in at.velocities(before)))[0]
    row_impulses = numbers.zeros(len(loops))
    if len(loops):
        missing = given.target - loops @ (motion_before + change[:, 0])
        mobility = loops @ change[:, 1:]
        for i in _demanded_of_joints(numbers, held, loops):
            mobility[i, :] = mobility[:, i] = numbers.number(0)
        size = given.size(loops, motion_before, change[:, 0])
        row_impulses = consistent_solution(numbers, mobility, missing, size, given.names)
    weights = np.concatenate([numbers.array([1]), row_impulses])
    dx, held_by = change @ weights, carried @ weights

    reactions = {}
    own_impulses = in_joints(system, joint_impulses)
    from_rows = row_impulses @ given.speeds
    for k, body in enumerate(tree.bodies):
        inside = own_impulses[body.joint.name]
        if not body.joint.mimics:
            inside = inside + from_rows[body.joint.speeds]
        reactions[body.joint.name] = (
            joints.own[k].T @ inside + joints.wrench_directions[k].T @ held_by
        )
    motion = dx.reshape(-1, 2, 3)
    return MaximalImpact(
        body_dv=motion[:, 0].copy(),
        body_domega=motion[:, 1].copy(),
        dy=_flat(joints.speed_linear, joints.speed_angular) @ dx,
        joint_reactions=reactions,
        row_impulses=row_impulses,
    )


class _Joints:
    """All joints of a tree as rows on the motion of free bodies.

    Attributes:
        linear, angular: (c, N, 3) coefficients of the rows that hold the joints together.
        wrench_directions: for each body (c, 6), what a unit impulse of each row gives it
            through the joint above it, at the joint's origin, world axes.
        own: for each body (d, 6), the directions in which its joint moves.
        own_motion: for each body, coefficients (d, N, 3) twice of the motion in them.
        speed_linear, speed_angular: (n, N, 3) the generalized speeds as bodies' motion.
    """

    def __init__(self, tree: Tree, at: Kinematics) -> None:
        numbers, count = tree.arithmetic, len(tree.bodies)
        self.own = [joint_directions(at, tree, k) for k in range(count)]
        self.own_motion = [self._between(tree, at, k, self.own[k]) for k in range(count)]
        self.speed_linear = numbers.zeros(tree.n, count, 3)
        self.speed_angular = numbers.zeros(tree.n, count, 3)
        rows: list[tuple[Array, Array]] = []
        gives: list[list[tuple[int, Array]]] = []  # by row: bodies and the wrench on each
        for k, body in enumerate(tree.bodies):
            freed = freed_directions(numbers, self.own[k])
            linear, angular = self._between(tree, at, k, freed)
            rows += list(zip(linear, angular, strict=True))
            gives += [[(k, direction)] for direction in freed]
            if not body.joint.mimics:
                self.speed_linear[body.joint.speeds] = self.own_motion[k][0]
                self.speed_angular[body.joint.speeds] = self.own_motion[k][1]
        for k, body in enumerate(tree.bodies):
            if body.joint.mimics:
                # own motion − multiplier · leader's motion = 0
                leader, ratio = tree.body_of_joint(body.joint.mimics), body.joint.multiplier
                (linear, angular), (led, turned) = self.own_motion[k], self.own_motion[leader]
                rows.append((linear[0] - ratio * led[0], angular[0] - ratio * turned[0]))
                gives.append([(k, self.own[k][0]), (leader, -ratio * self.own[leader][0])])
        self.linear = numbers.zeros(len(rows), count, 3)
        self.angular = numbers.zeros(len(rows), count, 3)
        self.wrench_directions = [numbers.zeros(len(rows), 6) for _ in range(count)]
        for index, (linear, angular) in enumerate(rows):
            self.linear[index], self.angular[index] = linear, angular
            for k, direction in gives[index]:
                self.wrench_directions[k][index] += direction

    @staticmethod
    def _between(tree: Tree, at: Kinematics, k: int, directions: Array) -> tuple[Array, Array]:
        """Motion of body k against its parent at its own origin, along directions (d, 6)."""
        linear = tree.arithmetic.zeros(len(directions), len(tree.bodies), 3)
        angular = tree.arithmetic.zeros(len(directions), len(tree.bodies), 3)
        for body, sign in ((k, 1), (tree.bodies[k].parent, -1)):
            if body == WORLD:
                continue
            # d·(v + ω x r) = d·v + (r x d)·ω
            arm = rotation.skew(at.origins[k] - at.mass_centres[body], tree.arithmetic)
            linear[:, body] = sign * directions[:, :3]
            angular[:, body] = sign * (directions[:, 3:] + directions[:, :3] @ arm.T)
        return linear, angular


def _demanded_of_joints(numbers: Arithmetic, held: Array, loops: Array) -> list[int]:
    """Which rows the joints rule out to move anything, such as between bodies joined rigidly.

    They are sums of the joints' own rows. What is left of them when that sum is taken away
    is rounding.
    """
    gram = held @ held.T
    left = loops - numbers.solve_symmetric(gram, held @ loops.T, _free_to_move).T @ held
    smallest = numbers.sqrt(numbers.epsilon) * numbers.sqrt(numbers.sqrt(numbers.epsilon))
    return [
        i for i in range(len(loops)) if numbers.norm(left[i]) <= smallest * numbers.norm(loops[i])
    ]


def _flat(linear: Array, angular: Array) -> Array:
    """(d, N, 3) twice as (d, 6 N), body by body."""
    return np.stack([linear, angular], axis=2).reshape(len(linear), linear.shape[1] * 6)


def _free_to_move(_: int) -> Exception:
    return SingularMassError(
        "a body without inertia is free to move, so its velocity is not determined", joints=()
    )


def solve_general(
    numbers: Arithmetic, matrix: Array, right: Array, on_singular: Callable[[int], Exception]
) -> Array:
    """Solve ``matrix @ x = right`` by Gauss's elimination with row exchanges.

    Args, returns: as ``Arithmetic.solve_symmetric``, the matrix any square one.
    """
    size = len(matrix)
    work = matrix.copy()
    columns = (right[:, None] if right.ndim == 1 else right).copy()
    largest = max((abs(entry) for entry in work.flat), default=numbers.number(0))
    for i in range(size):
        best = i + int(np.argmax(np.abs(work[i:, i])))
        if not abs(work[best, i]) > size * numbers.epsilon * largest:
            raise on_singular(i)
        if best != i:
            work[[i, best]] = work[[best, i]]
            columns[[i, best]] = columns[[best, i]]
        factors = work[i + 1 :, i] / work[i, i]
        work[i + 1 :, i + 1 :] -= np.outer(factors, work[i, i + 1 :])
        columns[i + 1 :] -= np.outer(factors, columns[i])
    for i in reversed(range(size)):
        columns[i] /= work[i, i]
        columns[:i] -= np.outer(work[:i, i], columns[i])
    return columns.reshape(right.shape)
