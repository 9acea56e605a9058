"""Impacts as steps of optimal control: x⁺ = f(x) of x = (q, v), and costs on their impulses.

The blocks are plain arrays, as Crocoddyl (``Fx``, ``Lx``, ``Lxx``) and Aligator (``Jx``) lay them
out, in the tangent of Pinocchio's states: δx = (δq, δv) with q ⊕ δq as ``integrate`` has it.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from .batch.outputs import OUTPUTS, ImpactOutputs
from .errors import InputError, RangeError, ShapeError, UnknownNameError
from .errors.calls import public
from .formatting import OneLine
from .impact.derivatives import DerivativeStatus, derivatives
from .impact.derivatives.loads import joint_load_slopes
from .impact.solver import ImpactSolver
from .impact.status import BY_CODE
from .robot.arrays import array_of, floats, lock

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from .impact import Impact
    from .scene import Scene

__all__ = ["ImpactBlocks", "ImpactCost", "ImpactStep"]


@public
@dataclass(frozen=True, eq=False)
class ImpactCost:
    """The cost ½ weight |y − reference|² of a result y of an impact.

    Attributes:
        output: "contact_impulses" (3 C,) [N s] in world axes, contact after contact, of a joint
            stop [N m s, N s] along its coordinate, then two zeros;
            "joint_loads" (6 J,) [N s, N m s] as in ``Impact.joint_loads``; or "v_after" (nv,).
        weight: above 0, or one for each entry of y, each 0 or more.
        reference: one number for all entries, or one for each.

    Raises:
        UnknownNameError: no such output. RangeError: a negative weight. NotFiniteError.

    Example:
        >>> ImpactCost("contact_impulses", 0.1).weight
        array(0.1)
    """

    output: str
    weight: Any = 1.0
    reference: Any = 0.0

    def __post_init__(self) -> None:
        if self.output not in OUTPUTS:
            raise UnknownNameError.among("output", str(self.output), OUTPUTS)
        for name in ("weight", "reference"):
            array = floats(getattr(self, name), name)
            array = array_of(array, array.shape, name)
            lock(array)
            object.__setattr__(self, name, array)
        if (self.weight < 0.0).any():
            raise RangeError.of("weight", float(self.weight.min()), "0 or more")


@public
@dataclass(frozen=True, eq=False, repr=False)
class ImpactStep(OneLine):
    """An impact as a step from x to x⁺; arrays are read-only.

    Attributes:
        impact: as ``solve`` gives it.
        x_after: (nq + nv,) q and v⁺.
        outputs: by output of the costs its entries.
        cost: the sum of all costs.
    """

    impact: Impact = field(repr=False)
    x_after: np.ndarray
    outputs: dict[str, np.ndarray] = field(repr=False)
    cost: float


@public
@dataclass(frozen=True, eq=False, repr=False)
class ImpactStepSlopes(OneLine):
    """Derivatives of a step on the tangent of x; arrays are read-only.

    Attributes:
        fx: (2 nv, 2 nv) of x⁺.
        outputs: by output of the costs (entries, 2 nv).
        lx: (2 nv,) the gradient of the cost. lxx: (2 nv, 2 nv) its Gauss–Newton Hessian.
        status: whether they exist; on the edge of a mode they are those of the mode found.
    """

    fx: np.ndarray
    outputs: dict[str, np.ndarray] = field(repr=False)
    lx: np.ndarray
    lxx: np.ndarray
    status: DerivativeStatus


@public
class ImpactBlocks:
    """The impact of a scene as a step x⁺ = f(x) with costs, and its derivatives.

    Args:
        scene: the robot, its contacts and constraints, and the law of contact.
        costs: on results of the impact.

    Attributes:
        nx: nq + nv. ndx: 2 nv.
        statuses: how many steps were differentiated with which ``DerivativeStatus``.

    Raises:
        InputError: a scene without contacts and constraints, one that ``derivatives`` refuses, or
            joint loads where other entries than ``Contact`` give impulses; what is no ImpactCost.
        ShapeError: a weight or reference with another number of entries than its result.

    Example:
        >>> from impulsekit import Contact, Robot, Scene
        >>> ball = Robot.from_urdf("models/ball.urdf", root="freeflyer")
        >>> scene = Scene(ball, contacts=[Contact("ball", restitution=0.5)])
        >>> blocks = ImpactBlocks(scene, [ImpactCost("contact_impulses")])
        >>> step = blocks.calc([*ball.neutral(), 0, 0, -2, 0, 0, 0])
        >>> float(step.x_after[9]), round(step.cost, 12)
        (1.0, 1.125)
        >>> slopes = blocks.calc_diff(step)
        >>> float(slopes.fx[8, 8]), float(slopes.lx[8].round(12))
        (-0.5, -1.125)
    """

    def __init__(self, scene: Scene, costs: Sequence[ImpactCost] = ()) -> None:
        self.costs = (costs,) if isinstance(costs, ImpactCost) else tuple(costs)
        for cost in self.costs:
            if not isinstance(cost, ImpactCost):
                raise InputError(f"costs: each must be an ImpactCost, got {type(cost).__name__}")
        names = dict.fromkeys(["v_after", *(cost.output for cost in self.costs)])
        own = ImpactOutputs(scene, tuple(names), "ImpactBlocks")
        for cost in self.costs:
            size = int(np.prod(own.shapes[cost.output]))
            for what in ("weight", "reference"):
                shape = getattr(cost, what).shape
                if shape not in ((), (size,)):
                    raise ShapeError.of(f'{what} of the cost on "{cost.output}"', (size,), shape)
        self.scene, self._solver = scene, ImpactSolver(scene)
        self._names = tuple(dict.fromkeys(cost.output for cost in self.costs))
        self.nx, self.ndx = scene.robot.nq + scene.robot.nv, 2 * scene.robot.nv
        # ∂x⁺/∂x but for the rows of v⁺.
        self._fixed = np.eye(self.ndx)
        pressed = {"contact_impulses", "joint_loads"} & set(self._names)
        self._results = ("v_after", "contact_impulses") if pressed else ("v_after",)
        self.statuses: Counter[DerivativeStatus] = Counter()

    def calc(self, x: ArrayLike) -> ImpactStep:
        """Solve the impact.

        Args:
            x: (nq + nv,) configuration and velocity before.

        Raises:
            ShapeError, NotFiniteError, StateError: x is no state of this robot.
            InputError: the impact has no valid solution.
        """
        after = array_of(floats(x, "x"), (self.nx,), "x")
        nq = self.scene.robot.nq
        impact = self._solver.solve(after[:nq], after[nq:])
        if not BY_CODE[impact.solved.core.solution.status].valid:
            raise InputError(f"x: no valid impact from here. {impact.describe_status()}")
        after[nq:] = impact.v_after
        found = {name: self._value(impact, name) for name in self._names}
        total = 0.0
        for cost in self.costs:
            off = found[cost.output] - cost.reference
            total += 0.5 * float(np.sum(cost.weight * off * off))
        lock(after, *found.values())
        return ImpactStep(impact, after, found, total)

    def calc_diff(self, step: ImpactStep) -> ImpactStepSlopes:
        """Differentiate a step, with its costs.

        Args:
            step: as ``calc`` gave it.

        Raises:
            InputError: as for ``derivatives``.
        """
        nv, found = self.ndx // 2, derivatives(step.impact)
        self.statuses[found.status] += 1
        blocks = found.by_state(*self._results)
        fx = self._fixed.copy()
        fx[nv:] = blocks["v_after"]
        tables = {name: self._table(step, blocks, name) for name in self._names}
        lx, lxx = np.zeros(2 * nv), np.zeros((2 * nv, 2 * nv))
        for cost in self.costs:
            table, off = tables[cost.output], step.outputs[cost.output] - cost.reference
            weighted = (cost.weight * table.T).T if cost.weight.ndim else cost.weight * table
            lx += off @ weighted
            lxx += table.T @ weighted
        lock(fx, lx, lxx, *tables.values())
        return ImpactStepSlopes(fx, tables, lx, lxx, found.status)

    def _value(self, impact: Impact, name: str) -> np.ndarray:
        if name == "v_after":
            return impact.v_after
        if name == "contact_impulses":
            return _impulses(impact)
        loads = impact.joint_loads
        names = list(self.scene.robot.model.names)[1:]
        return np.concatenate([part for n in names for part in (loads[n].force, loads[n].moment)])

    def _table(self, step: ImpactStep, blocks: dict[str, np.ndarray], name: str) -> np.ndarray:
        """(entries, 2 nv) of one output."""
        if name != "joint_loads":
            return blocks[name]
        nv, impact = self.ndx // 2, step.impact
        impulses = _impulses(impact).reshape(-1, 3)
        own = joint_load_slopes(self.scene, impact.q, impact.dv, impulses)
        moved = blocks["v_after"] - self._fixed[nv:]
        table = own.by_dv @ moved + own.by_impulses @ blocks["contact_impulses"]
        table[:, :nv] += own.by_q
        return table


def _impulses(impact: Impact) -> np.ndarray:
    """(3 C,) at all contacts, in world axes; of a joint stop along its coordinate, then zeros."""
    jump, _, core = impact.solved
    return core.contact_impulses(jump.flat.core)
