"""``StepImpact``: an impact inside a step of MuJoCo."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import mujoco
import numpy as np

from ..formatting import Displayed
from ..impact.status import Status
from ..robot.arrays import read_only
from .coefficients import geom_name
from .listing import LIMIT_JOINT
from .loads import body_loads

__all__ = ["Parts", "StepImpact"]


class Parts(NamedTuple):
    """The numbers from which the results of an impact are computed.

    Attributes:
        model: a ``mujoco.MjModel``. state: of MuJoCo, before the impact.
        mass: (nv, nv) M, with armature. equalities: number of rows of equalities.
        J: (n + k + j, 3, nv) of contacts, limits, and the turning of contacts.
        impulses: (n + k + j, 3) along these rows.
        pairs: (n + k, 2) geoms of contacts; of limits −1 − kind and joint or tendon.
        positions: (n, 3). frames: (n, 9), rows normal, t₁, t₂.
        turning: (j,) which contacts resist rolling and spin.
    """

    model: Any
    state: np.ndarray
    mass: np.ndarray
    equalities: int
    J: np.ndarray
    impulses: np.ndarray
    pairs: np.ndarray
    positions: np.ndarray
    frames: np.ndarray
    turning: np.ndarray


@dataclass(frozen=True, eq=False, repr=False)
class StepImpact(Displayed):
    """An impact found and solved inside one step of MuJoCo.

    Of the n contacts and k limits, most results are computed on first access.

    Attributes:
        time: of the impact [s].
        approach: (n,) approach speed along the normal [m/s], negative where it parts.
        restitution: (n,) the e of each contact.
        qpos, qvel: (nq,), (nv,) MuJoCo's state just before the impact.
        dv: (nv,) change of the generalized velocities.
        status: of the law, see ``impulsekit.Status``; where it is not valid nothing was applied.
        residual: of the law's equations.
        parts: what the other results are computed from.
    """

    time: float
    approach: np.ndarray
    restitution: np.ndarray
    qpos: np.ndarray
    qvel: np.ndarray
    dv: np.ndarray
    status: Status
    residual: float
    parts: Parts

    @cached_property
    def pairs(self) -> tuple[tuple[str, str], ...]:
        """(n) names of the geoms of each contact, the first touched, the second touching."""
        model, own = self.parts.model, self.parts.pairs[: len(self.approach)]
        return tuple((geom_name(model, a), geom_name(model, b)) for a, b in own.tolist())

    @property
    def positions(self) -> np.ndarray:
        """(n, 3) of the contacts [m], world axes."""
        return read_only(self.parts.positions)

    @property
    def normals(self) -> np.ndarray:
        """(n, 3) unit normals from the first geom to the second, world axes."""
        return read_only(self.parts.frames[:, :3])

    @cached_property
    def impulses(self) -> np.ndarray:
        """(n, 3) what the second geom receives [N s], world axes."""
        return read_only(self._in_world(np.arange(len(self.approach)), self.parts.impulses))

    @cached_property
    def moments(self) -> np.ndarray:
        """(n, 3) the moment by resistance to rolling and spin [N m s], world axes."""
        moments = np.zeros((len(self.approach), 3))
        turning = self.parts.turning
        first = len(self.parts.impulses) - len(turning)
        moments[turning] = self._in_world(turning, self.parts.impulses[first:])
        return read_only(moments)

    def _in_world(self, which: np.ndarray, components: np.ndarray) -> np.ndarray:
        """Vectors of contacts whose components are along t₁, t₂ and the normal."""
        axes = self.parts.frames[which].reshape(-1, 3, 3)
        own = components[: len(which), [2, 0, 1]]
        return np.asarray((own[:, None] @ axes)[:, 0])

    @cached_property
    def separation(self) -> np.ndarray:
        """(n,) speed along the normal after the impact [m/s]."""
        normals = self.parts.J[: len(self.approach), 2]
        return read_only(normals @ (self.qvel + self.dv))

    @cached_property
    def limits(self) -> tuple[str, ...]:
        """(k) names of the joints and tendons at a limit."""
        own = self.parts.pairs[len(self.approach) :].tolist()
        return tuple(_limit_name(self.parts.model, -1 - kind, number) for kind, number in own)

    @cached_property
    def limit_impulses(self) -> np.ndarray:
        """(k,) along the coordinate of each limit, opening positive [N s or N m s]."""
        n = len(self.approach)
        return read_only(self.parts.impulses[n : len(self.parts.pairs), 2].copy())

    @cached_property
    def energy_change(self) -> float:
        """The change of the kinetic energy [J].

        It holds the work of equalities that moved before the impact, as MuJoCo's soft ones may.
        """
        return float((self.parts.mass @ self.dv) @ (self.qvel + 0.5 * self.dv))

    @cached_property
    def joint_impulses(self) -> dict[str, np.ndarray]:
        """By body, (6,) the wrench that its parent gives it in the impact, at the body's origin.

        Linear [N s] before angular [N m s], world axes.

        Raises:
            InputError: equality constraints were active: part of the load goes through them.
        """
        parts = self.parts
        wrenches = np.hstack([self.impulses, self.moments])
        geoms = parts.pairs[: len(self.approach)]
        return body_loads(
            parts.model, parts.state, parts.equalities, self.dv, geoms, self.positions, wrenches
        )

    def __repr__(self) -> str:
        largest = np.linalg.norm(self.impulses, axis=1).max(initial=0.0)
        among = ", ".join(f"{a}-{b}" for a, b in dict.fromkeys(self.pairs)) or ", ".join(
            self.limits
        )
        return (
            f"StepImpact(t={self.time:.6g} s, {among}, largest impulse {largest:.4g} N s, "
            f"energy {self.energy_change:+.4g} J, {self.status.name})"
        )

    def to_dict(self) -> dict[str, object]:
        """Return the record as plain lists and numbers."""
        return {
            "time": self.time,
            "pairs": [list(pair) for pair in self.pairs],
            "impulses": self.impulses.tolist(),
            "approach": self.approach.tolist(),
            "separation": self.separation.tolist(),
            "energy_change": self.energy_change,
            "limits": list(self.limits),
            "limit_impulses": self.limit_impulses.tolist(),
        }


def _limit_name(model: Any, kind: int, number: int) -> str:
    is_joint = kind == LIMIT_JOINT
    of = mujoco.mjtObj.mjOBJ_JOINT if is_joint else mujoco.mjtObj.mjOBJ_TENDON
    return mujoco.mj_id2name(model, of, number) or f"{'joint' if is_joint else 'tendon'} {number}"
