"""The balance of momentum of a motion: forces and impulses together."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...formatting import OneLine
from ...impact.forces import body_impulses
from ...named import ByName
from ...robot.arrays import lock
from .energies import momentum_at

if TYPE_CHECKING:
    from ...impact import Impact
    from .sampled import SampledMotion

__all__ = ["MomentumBalance", "momentum_balance"]


@dataclass(frozen=True, eq=False, repr=False)
class MomentumBalance(OneLine):
    """The sources of the momentum of all moving bodies between two times.

    World axes, (6,) each: linear [N s] before angular about the world's origin [N m s].

    Attributes:
        start, end: [s]; impacts at the end belong to it, those at the start do not.
        change: of the momentum.
        shares: by entry of the scene, "weight", and "base": what joints to the world gave. An
            entry between bodies that move changes nothing.
    """

    start: float
    end: float
    change: np.ndarray
    shares: Mapping[str, np.ndarray]

    @property
    def residual(self) -> np.ndarray:
        """(6,) what the shares leave unexplained: the error of motion and forces together."""
        return self.change - sum(self.shares.values(), np.zeros(6))


def momentum_balance(
    motion: SampledMotion, start: float | None, end: float | None
) -> MomentumBalance:
    """The balance between two times; see ``Trajectory.balance``."""
    a, b = motion.checked_span(start, end)
    loads = motion.loads
    names = [
        *(name for kind in _KINDS for name in motion.scene.entry_names(kind)),
        "weight",
        "base",
    ]
    nothing = np.zeros(6)

    def all_at_once(one) -> np.ndarray:
        return np.concatenate([one.wrenches.get(name, nothing) for name in names])

    total = loads.integral(a, b, all_at_once, 6 * len(names)).reshape(-1, 6)
    shares = dict(zip(names, total, strict=True))
    hits = [impact for time, impact in motion.impacts if (start is None or time > a) and time <= b]
    first = motion.at(a)
    if start is None and hits and motion.impacts[0][0] == a:
        first = hits[0].q, hits[0].v_before
    for impact in hits:
        _add(shares, impact)
    lock(*shares.values())
    model, data = loads.model, loads.data_of_robot
    change = momentum_at(model, data, *motion.at(b)) - momentum_at(model, data, *first)
    change.setflags(write=False)
    return MomentumBalance(a, b, change, ByName(shares, "entry"))


_KINDS = ("impulses", "constraints", "contacts", "forces")


def _add(shares: dict[str, np.ndarray], impact: Impact) -> None:
    """Add an impact's momentum to the shares of its entries."""
    mechanics, model = impact.mechanics, impact.scene.robot.model
    for item in body_impulses(impact):
        if item.joint_id > 0:
            placement = mechanics.joint_placement(item.joint_id)
            shares[item.entry] = shares[item.entry] + placement.act(item.wrench_in_joint).vector
    for joint_id in range(1, model.njoints):
        if model.parents[joint_id] == 0:
            through = impact.reactions[model.names[joint_id]]
            arm = np.cross(mechanics.joint_placement(joint_id).translation, through[:3])
            shares["base"] = shares["base"] + through + np.concatenate([np.zeros(3), arm])
