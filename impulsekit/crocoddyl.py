"""``impulsekit.crocoddyl.ImpactAction``: an impact as an action of Crocoddyl's problems.

The numbers are those of ``impulsekit.control.ImpactBlocks``, which needs no Crocoddyl. The class
is made when it is first asked for. Beside Pinocchio 4.1, Crocoddyl 3.2.1 runs states and this
action; its own multibody actions crash there and need Pinocchio 4.0.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from .control import ImpactBlocks, ImpactCost
from .errors import InputError, MissingExtraError

if TYPE_CHECKING:
    from .scene import Scene

# Made on first use, see below.
__all__ = ["ImpactAction"]  # noqa: F822


def __getattr__(name: str) -> Any:
    if name == "ImpactAction":
        return _action()
    raise AttributeError(f'module "impulsekit.crocoddyl" has no "{name}"; it has ImpactAction')


def _library() -> Any:
    """Crocoddyl.

    Raises:
        MissingExtraError: it is not installed.
    """
    try:
        import crocoddyl
    except ImportError:
        raise MissingExtraError(
            "impulsekit.crocoddyl needs crocoddyl; python -m benchmarks.crocoddyl_action "
            "--set-up FOLDER makes an environment with it and Pinocchio 4.0, which its own "
            "multibody actions need. impulsekit.control.ImpactBlocks gives the same blocks "
            "without it",
            package="crocoddyl",
            extra="",
        ) from None
    return crocoddyl


def _refuse_other_states(state: Any, scene: Scene) -> None:
    """Refuse a state that is not laid out as that of the scene's robot.

    Raises:
        InputError: it says how they differ.
    """
    own, given = scene.robot.model, getattr(state, "pinocchio", None)
    if given is None:
        raise InputError(f"state must be a StateMultibody, got {type(state).__name__}")
    if list(given.names) != list(own.names) or (state.nq, state.nv) != (own.nq, own.nv):
        raise InputError(
            f"state has nq = {state.nq}, nv = {state.nv} and joints {', '.join(given.names)}; "
            f"the scene's robot has nq = {own.nq}, nv = {own.nv} and {', '.join(own.names)}; "
            "build it from scene.robot.model"
        )


@functools.cache
def _action() -> Any:
    crocoddyl = _library()

    class ImpactData(crocoddyl.ActionDataAbstract):  # type: ignore[name-defined]
        """The data of an action, with its last ``ImpactStep``."""

        def __init__(self, model: Any) -> None:
            crocoddyl.ActionDataAbstract.__init__(self, model)
            self.step: Any = None

    class ImpactAction(crocoddyl.ActionModelAbstract):  # type: ignore[name-defined]
        """An impact of a scene as an action without controls: x⁺ = (q, v⁺).

        Contacts are one-sided, with the restitution, friction and law of the scene.

        Args:
            state: a ``crocoddyl.StateMultibody`` of ``scene.robot.model``.
            scene: the robot, its contacts and constraints, and the law of contact.
            costs: ``ImpactCost`` entries on results of the impact.

        Attributes:
            blocks: the ``ImpactBlocks`` behind it, whose ``statuses`` count mode edges.

        Raises:
            InputError: another state, or as for ``ImpactBlocks``.
        """

        def __init__(self, state: Any, scene: Scene, costs: Sequence[ImpactCost] = ()) -> None:
            self.blocks = ImpactBlocks(scene, costs)
            _refuse_other_states(state, scene)
            crocoddyl.ActionModelAbstract.__init__(self, state, 0, 0)

        def calc(self, data: Any, x: Any, u: Any = None) -> None:
            """Solve the impact."""
            data.step = self.blocks.calc(x)
            data.xnext = data.step.x_after
            data.cost = data.step.cost

        def calcDiff(self, data: Any, x: Any, u: Any = None) -> None:
            """Differentiate the impact that ``calc`` solved."""
            found = self.blocks.calc_diff(data.step)
            data.Fx, data.Lx, data.Lxx = found.fx, found.lx, found.lxx

        def createData(self) -> Any:
            """Return data for this action."""
            return ImpactData(self)

    return ImpactAction
