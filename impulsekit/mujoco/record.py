"""``StepImpact``: an impact inside a step of MuJoCo."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import mujoco
import numpy as np

from ..formatting import Displayed
from ..impact.status import BY_CODE, Status
from ..robot.arrays import read_only
from .listing import LIMIT_JOINT
from .loads import loads_of
from .system import System

__all__ = ["StepImpact", "impact_of"]


@dataclass(frozen=True, eq=False, repr=False)
class StepImpact(Displayed):
    """An impact found and solved inside one step of MuJoCo.

    Attributes:
        time: of the impact [s].
        pairs: (n) names of the geoms of each contact, the first touched, the second touching.
        positions: (n, 3) of the contacts [m], world axes.
        impulses: (n, 3) what the second geom receives [N s], world axes.
        moments: (n, 3) the moment by resistance to rolling and spin [N m s], world axes.
        approach: (n,) approach speed along the normal [m/s], negative where it parts.
        separation: (n,) speed along the normal after the impact [m/s].
        restitution: (n,) the e of each contact.
        limits: (k) names of the joints and tendons at a limit; ``limit_impulses`` (k,) along
            their coordinate, opening positive [N s or N m s].
        qpos, qvel: (nq,), (nv,) MuJoCo's state just before the impact.
        dv: (nv,) change of the generalized velocities.
        energy_change: of the kinetic energy [J].
        status: of the law, see ``impulsekit.Status``; where it is not valid nothing was applied.
        residual: of the law's equations.
        loads: what computes ``joint_impulses``.
    """

    time: float
    pairs: tuple[tuple[str, str], ...]
    positions: np.ndarray
    impulses: np.ndarray
    moments: np.ndarray
    approach: np.ndarray
    separation: np.ndarray
    restitution: np.ndarray
    limits: tuple[str, ...]
    limit_impulses: np.ndarray
    qpos: np.ndarray
    qvel: np.ndarray
    dv: np.ndarray
    energy_change: float
    status: Status
    residual: float
    loads: Callable[[], dict[str, np.ndarray]]

    @cached_property
    def joint_impulses(self) -> dict[str, np.ndarray]:
        """By body, (6,) the wrench that its parent gives it in the impact, at the body's origin.

        Linear [N s] before angular [N m s], world axes. Computed on first access.

        Raises:
            InputError: equality constraints were active: part of the load goes through them.
        """
        return self.loads()

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


def impact_of(
    model: Any, data: Any, system: System, found: Any, e: np.ndarray, name_of: Callable[[int], str]
) -> StepImpact:
    """Return the record of an impact that was solved at the state of ``data``."""
    status = Status.NO_SOLUTION if found.failure else BY_CODE[found.status]
    n, k, turns = len(system.pairs), len(system.limits), system.turning_of
    v, normals = system.velocity, system.contacts[:, 2]
    if status.valid:
        dv, own = found.dv, found.impulse.reshape(-1, 3)
    else:
        dv, own = np.zeros(model.nv), np.zeros((n + k + len(turns), 3))
    axes = system.axes
    impulses = np.einsum("nij,ni->nj", axes, own[:n])
    moments = np.zeros((n, 3))
    if len(turns):
        moments[turns] = np.einsum("nij,ni->nj", axes[turns], own[n + k :])
    return StepImpact(
        time=float(data.time),
        pairs=tuple((name_of(a), name_of(b)) for a, b in system.pairs.tolist()),
        positions=read_only(system.positions),
        impulses=read_only(impulses),
        moments=read_only(moments),
        approach=read_only(-(normals @ v)),
        separation=read_only(normals @ (v + dv)),
        restitution=read_only(e),
        limits=tuple(_limit_name(model, *one) for one in system.limit_ids.tolist()),
        limit_impulses=read_only(own[n : n + k, 2].copy()),
        qpos=read_only(data.qpos.copy()),
        qvel=read_only(v),
        dv=read_only(dv),
        energy_change=float((system.mass @ dv) @ (v + 0.5 * dv)),
        status=status,
        residual=float(found.residual),
        loads=loads_of(model, data, dv, system, np.hstack([impulses, moments])),
    )


def _limit_name(model: Any, kind: int, number: int) -> str:
    is_joint = kind == LIMIT_JOINT
    of = mujoco.mjtObj.mjOBJ_JOINT if is_joint else mujoco.mjtObj.mjOBJ_TENDON
    return mujoco.mj_id2name(model, of, number) or f"{'joint' if is_joint else 'tendon'} {number}"
