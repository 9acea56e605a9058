"""Impacts and whole motions as ``casadi.Function``, with exact first derivatives.

CasADi refers to callbacks weakly, so those made here live as long as the process. They have no
second derivatives: give IPOPT the option ``{"ipopt.hessian_approximation": "limited-memory"}``.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pinocchio as pin

from .batch.differentiable import Differentiable
from .batch.outputs import OUTPUTS, ImpactOutputs
from .errors import MissingExtraError, check_kind
from .errors.calls import public
from .impact.derivatives import DerivativeStatus
from .motion import simulate
from .motion.maps.sensitivity import sensitivity as sensitivity_of
from .scene import Scene
from .scene.numbers import whole

with MissingExtraError.unless("casadi", "casadi", "impulsekit.casadi"):
    import casadi

__all__ = ["impact", "sensitivity"]

_ALIVE: list[Any] = []
Shapes = Mapping[str, tuple[int, int]]


@public
def impact(scene: Scene, outputs: Sequence[str] = OUTPUTS, *, states: int = 1) -> Any:
    """Return the impacts of a scene as a ``casadi.Function`` F(q, v), in float64.

    Its jacobian and reverse mode are those of ``derivatives`` and ``vjp``, by the entries of q,
    of which quaternions, and cosines with sines, are brought to unit length first. On the edge of a
    mode they are those of the mode that was found; ``F.statuses`` counts the derivatives that were
    taken, by ``DerivativeStatus``. Derivatives that do not exist, and results of states
    without a valid impact, are NaN.

    Args:
        scene: the robot, its contacts and constraints, and the law of contact.
        outputs: "v_after" (nv, 1), "contact_impulses" (3, contacts) in world axes [N s],
            "joint_loads" (6, joints) force before moment in the axes of each joint's frame, as in
            ``Impact.joint_loads`` [N s, N m s].
        states: number of states that one call takes, all solved by one ``solve_batch``: q is
            (nq, states), v (nv, states), and results stand side by side as those of ``F.map``.

    Raises:
        InputError: a scene without contacts and constraints, or one that ``derivatives`` refuses;
            "joint_loads" where other entries than ``Contact`` give impulses.
        UnknownNameError: no such output. RangeError: states below 1.
        MissingExtraError: casadi is not installed (on import).

    Example:
        >>> import casadi
        >>> from impulsekit import Contact, Robot, Scene
        >>> from impulsekit.casadi import impact
        >>> ball = Robot.from_urdf("models/ball.urdf", root="freeflyer")
        >>> F = impact(Scene(ball, contacts=[Contact("ball", restitution=0.5)]), ["v_after"])
        >>> v = casadi.MX.sym("v", 6)
        >>> up = casadi.Function("up", [v], [casadi.jacobian(F(ball.neutral(), v), v)[2, 2]])
        >>> float(up([0, 0, -2, 0, 0, 0]))
        -0.5
    """
    own = ImpactOutputs(scene, outputs, "impulsekit.casadi.impact")
    return _Impact(own, whole(states, "states", 1))


@public
def sensitivity(scene: Scene, duration: float, **changes: Any) -> Any:
    """Return the end of a motion as a ``casadi.Function`` F(q, v), with its ``sensitivity``.

    F gives q_end (nq,) and v_end (nv,); its jacobian, by the entries of q, is that of
    ``impulsekit.sensitivity``, across all impacts. ``F.statuses`` counts the impacts that were
    differentiated. A motion that ends early gives NaN.

    Args:
        scene: the robot, its forces, contacts and constraints, and the law of contact.
        duration: of the motion [s].
        changes: as ``simulate`` takes them, such as rtol and atol.

    Raises:
        InputError: what is not a Scene. In CasADi's calls, as RuntimeError with the same words:
            what ``simulate`` and ``sensitivity`` refuse.

    Example:
        >>> from impulsekit import Contact, Robot, Scene
        >>> ball = Robot.from_urdf("models/ball.urdf", root="freeflyer")
        >>> F = sensitivity(Scene(ball, contacts=[Contact("ball", restitution=0.9)]), 0.8)
        >>> q, v = F([0, 0, 1, 0, 0, 0, 1], [0, 0, 0, 0, 0, 0])
        >>> round(float(q[2]), 6)
        0.793559
    """
    check_kind(scene, Scene, "impulsekit.casadi.sensitivity")
    return _Motion(scene, duration, changes)


class _Function(casadi.Callback):
    """A callback with given shapes of inputs and outputs, kept for as long as the process."""

    def __init__(self, name: str, inputs: Shapes, outputs: Mapping[str, Any]) -> None:
        casadi.Callback.__init__(self)
        self._inputs = {key: casadi.Sparsity.dense(*shape) for key, shape in inputs.items()}
        self._outputs = {
            key: casadi.Sparsity.dense(*each) if isinstance(each, tuple) else each
            for key, each in outputs.items()
        }
        self.construct(name, {})
        _ALIVE.append(self)

    def get_n_in(self) -> int:
        return len(self._inputs)

    def get_n_out(self) -> int:
        return len(self._outputs)

    def get_name_in(self, i: int) -> str:
        return list(self._inputs)[i]

    def get_name_out(self, i: int) -> str:
        return list(self._outputs)[i]

    def get_sparsity_in(self, i: int) -> Any:
        return list(self._inputs.values())[i]

    def get_sparsity_out(self, i: int) -> Any:
        return list(self._outputs.values())[i]


class _Derived(_Function):
    """A derivative, whose numbers a function of its inputs gives."""

    def __init__(self, name: str, inputs: Shapes, outputs: Mapping[str, Any], numbers: Any) -> None:
        self._numbers = numbers
        super().__init__(name, inputs, outputs)

    def eval(self, arg: Sequence[Any]) -> list[Any]:
        found = self._numbers([_rows(each) for each in arg])
        pairs = zip(self._outputs.values(), found, strict=True)
        return [casadi.DM(sparsity, np.ravel(own)) for sparsity, own in pairs]


class _WithJacobian(_Function):
    """A function of ``count`` columns of q and v, whose jacobian ``slopes`` gives."""

    count: int
    shapes: dict[str, tuple[int, int]]
    sizes: dict[str, int]

    def __init__(self, name: str, scene: Scene, shapes: Shapes, count: int) -> None:
        robot = scene.robot
        self.count, self.shapes, self.sizes = count, dict(shapes), {"q": robot.nq, "v": robot.nv}
        self.entries = Differentiable(scene, ())
        super().__init__(
            name,
            {key: (size, count) for key, size in self.sizes.items()},
            {key: (rows, columns * count) for key, (rows, columns) in shapes.items()},
        )

    def slopes(self, q: np.ndarray, v: np.ndarray) -> dict[str, np.ndarray]:
        """By output (count, entries, 2 nv) the derivatives on the tangent of q."""
        raise NotImplementedError

    def has_jacobian(self) -> bool:
        return True

    def get_jacobian(self, name: str, inames: Any, onames: Any, opts: Any) -> Any:
        own = [(size, self.count) for size in self.sizes.values()]
        after = [(rows, columns * self.count) for rows, columns in self.shapes.values()]
        blocks = [
            casadi.diagcat(*[casadi.Sparsity.dense(rows * columns, size)] * self.count)
            for rows, columns in self.shapes.values()
            for size in self.sizes.values()
        ]
        inputs = dict(zip(inames, [*own, *after], strict=True))
        outputs = dict(zip(onames, blocks, strict=True))
        return _Derived(name, inputs, outputs, self.jacobians)

    def jacobians(self, given: Sequence[np.ndarray]) -> list[np.ndarray]:
        """The entries of all blocks, column after column."""
        q, v = self.entries.unit(given[0]), given[1]
        found = []
        for table in self.slopes(q, v).values():
            entries, nv = table.shape[1], self.sizes["v"]
            start, unit = (np.repeat(each, entries, axis=0) for each in (given[0], q))
            by_q = self.entries.by_entries(start, unit, table[:, :, :nv].reshape(-1, nv))
            parts = by_q.reshape(self.count, entries, -1), table[:, :, nv:]
            found += [part.swapaxes(1, 2) for part in parts]
        return found


class _Impact(_WithJacobian):
    """The results of impacts.

    Attributes:
        statuses: how many derivatives were taken with which status.
    """

    def __init__(self, own: ImpactOutputs, count: int) -> None:
        self._own = own
        super().__init__("impact", own.scene, own.shapes, count)

    @property
    def statuses(self) -> Counter[DerivativeStatus]:
        return self._own.statuses

    def slopes(self, q: np.ndarray, v: np.ndarray) -> dict[str, np.ndarray]:
        return self._own.slopes(q, v)

    def eval(self, arg: Sequence[Any]) -> list[Any]:
        q, v = (_rows(each) for each in arg)
        found = self._own.values(self.entries.unit(q), v)
        return [_columns(found[name], rows) for name, (rows, _) in self.shapes.items()]

    def has_reverse(self, nadj: int) -> bool:
        return True

    def get_reverse(self, nadj: int, name: str, inames: Any, onames: Any, opts: Any) -> Any:
        own = [(size, self.count) for size in self.sizes.values()]
        after = [(rows, columns * self.count) for rows, columns in self.shapes.values()]
        seeds = [(rows, columns * nadj) for rows, columns in after]
        inputs = dict(zip(inames, [*own, *after, *seeds], strict=True))
        sizes = [(size, self.count * nadj) for size in self.sizes.values()]
        outputs = dict(zip(onames, sizes, strict=True))

        def pulled(given: Sequence[np.ndarray]) -> list[np.ndarray]:
            # All directions are rows of one batch.
            start, v = (np.tile(each, (nadj, 1)) for each in given[:2])
            q, seeds = self.entries.unit(start), given[-len(self.shapes) :]
            weights = {
                key: seed.reshape(len(q), -1) for key, seed in zip(self.shapes, seeds, strict=True)
            }
            by_q, by_v = self._own.pull(q, v, weights)
            return [self.entries.by_entries(start, q, by_q), by_v]

        return _Derived(name, inputs, outputs, pulled)


class _Motion(_WithJacobian):
    """The end of a motion.

    Attributes:
        statuses: how many impacts were differentiated with which status.
    """

    def __init__(self, scene: Scene, duration: float, changes: Mapping[str, Any]) -> None:
        self._scene, self._duration, self._changes = scene, duration, dict(changes)
        self.statuses: Counter[DerivativeStatus] = Counter()
        # CasADi asks for the end and then for its derivative at the same start.
        self._last: tuple[bytes, Any] | None = None
        robot = scene.robot
        super().__init__("motion", scene, {"q_end": (robot.nq, 1), "v_end": (robot.nv, 1)}, 1)

    def _motion(self, q: np.ndarray, v: np.ndarray) -> Any:
        key = q.tobytes() + v.tobytes()
        if self._last is None or self._last[0] != key:
            motion = simulate(self._scene, q[0], v[0], self._duration, **self._changes)
            self._last = key, motion
        return self._last[1]

    def eval(self, arg: Sequence[Any]) -> list[Any]:
        q, v = (_rows(each) for each in arg)
        motion = self._motion(self.entries.unit(q), v)
        ends = (motion.q[-1], motion.v[-1]) if motion.status.finished else (q * np.nan, v * np.nan)
        return [_columns(end, end.size) for end in ends]

    def slopes(self, q: np.ndarray, v: np.ndarray) -> dict[str, np.ndarray]:
        motion = self._motion(q, v)
        found = sensitivity_of(motion)
        self.statuses.update(item.derivatives.status for _, item in found.saltations)
        nv = self.sizes["v"]
        by_entries = pin.tangentMap(self._scene.robot.model, motion.q[-1])
        return {
            "q_end": (by_entries @ found.matrix[:nv])[None],
            "v_end": found.matrix[None, nv:],
        }


def _rows(matrix: Any) -> np.ndarray:
    """(columns, rows) of a matrix of CasADi."""
    return np.ascontiguousarray(np.array(matrix).T)


def _columns(array: np.ndarray, rows: int) -> Any:
    """A matrix of CasADi whose columns stand one after the other in an array."""
    return casadi.DM(np.reshape(array, (-1, rows)).T)
