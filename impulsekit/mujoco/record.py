"""``StepImpact``: an impact inside a step of MuJoCo."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import mujoco
import numpy as np

from .._core import ContactListing, ListedImpact
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
        listing: contacts and limits nearby. which: the entries in the impact, contacts first.
        restitution: (n + k) of each. listed: what the core found for them. It and the listing are
            None after pickling.
    """

    model: Any
    state: np.ndarray
    mass: np.ndarray
    equalities: int
    listing: ContactListing
    which: list[int]
    restitution: list[float]
    listed: ListedImpact

    @property
    def J(self) -> np.ndarray:
        """(n + k + j, 3, nv) of contacts, limits, and contacts that resist rolling and spin."""
        return np.asarray(self.listed.J.reshape(-1, 3, len(self.mass)))


@dataclass(frozen=True, eq=False, repr=False)
class StepImpact(Displayed):
    """An impact found and solved inside one step of MuJoCo.

    Of the n contacts and k limits, most results are computed on first access.

    Attributes:
        time: of the impact [s].
        qpos, qvel: (nq,), (nv,) MuJoCo's state just before the impact.
        dv: (nv,) change of the generalized velocities.
        status: of the law, see ``impulsekit.Status``; where it is not valid nothing was applied.
        parts: what the other results are computed from.
    """

    time: float
    qpos: np.ndarray
    qvel: np.ndarray
    dv: np.ndarray
    status: Status
    parts: Parts

    def __getstate__(self) -> dict[str, Any]:
        """Results for another process, where the core's own records cannot go."""
        for name in ("_places", "_components", "limits", "moments", "residual", "separation"):
            getattr(self, name)
        gone: dict[str, Any] = {"listing": None, "listed": None}
        return {**self.__dict__, "parts": self.parts._replace(**gone)}

    @cached_property
    def _contacts(self) -> list[tuple[int, int, float]]:
        """Two geoms of each contact, and how fast its gap grew."""
        return [own for own in self.parts.listing.pairs(self.parts.which) if own[0] >= 0]

    @cached_property
    def _places(self) -> np.ndarray:
        """(n, 12) positions of contacts, and their normals, t₁ and t₂."""
        which = self.parts.which[: len(self._contacts)]
        return np.asarray(self.parts.listing.places(which).reshape(-1, 12))

    @cached_property
    def _components(self) -> np.ndarray:
        """(n + k + j, 3) impulses along the rows of J."""
        found = self.parts.listed.solution.contact.impulse.reshape(-1, 3)
        return np.asarray(found if self.status.valid else np.zeros_like(found))

    @cached_property
    def approach(self) -> np.ndarray:
        """(n,) approach speed along the normal [m/s], negative where it parts."""
        return read_only(np.array([-rate for _, _, rate in self._contacts]))

    @cached_property
    def restitution(self) -> np.ndarray:
        """(n,) the e of each contact."""
        return read_only(np.array(self.parts.restitution[: len(self._contacts)]))

    @cached_property
    def residual(self) -> float:
        """Residual of the law's equations."""
        return float(self.parts.listed.solution.contact.residual)

    @cached_property
    def pairs(self) -> tuple[tuple[str, str], ...]:
        """(n) names of the geoms of each contact, the first touched, the second touching."""
        model = self.parts.model
        return tuple((geom_name(model, a), geom_name(model, b)) for a, b, _ in self._contacts)

    @property
    def positions(self) -> np.ndarray:
        """(n, 3) of the contacts [m], world axes."""
        return read_only(self._places[:, :3])

    @property
    def normals(self) -> np.ndarray:
        """(n, 3) unit normals from the first geom to the second, world axes."""
        return read_only(self._places[:, 3:6])

    @cached_property
    def impulses(self) -> np.ndarray:
        """(n, 3) what the second geom receives [N s], world axes."""
        return read_only(self._in_world(list(range(len(self._contacts))), self._components))

    @cached_property
    def moments(self) -> np.ndarray:
        """(n, 3) the moment by resistance to rolling and spin [N m s], world axes."""
        moments = np.zeros((len(self._contacts), 3))
        turning = self.parts.listed.turning
        own = self._components[len(self._components) - len(turning) :]
        moments[turning] = self._in_world(turning, own)
        return read_only(moments)

    def _in_world(self, which: list[int], components: np.ndarray) -> np.ndarray:
        """Vectors of contacts whose components are along t₁, t₂ and the normal."""
        axes = self._places[which, 3:].reshape(-1, 3, 3)
        own = components[: len(which), [2, 0, 1]]
        return np.asarray((own[:, None] @ axes)[:, 0])

    @cached_property
    def separation(self) -> np.ndarray:
        """(n,) speed along the normal after the impact [m/s]."""
        normals = self.parts.J[: len(self._contacts), 2]
        return read_only(normals @ (self.qvel + self.dv))

    @cached_property
    def limits(self) -> tuple[str, ...]:
        """(k) names of the joints and tendons at a limit."""
        own = self.parts.listing.pairs(self.parts.which[len(self._contacts) :])
        return tuple(_limit_name(self.parts.model, -1 - kind, number) for kind, number, _ in own)

    @cached_property
    def limit_impulses(self) -> np.ndarray:
        """(k,) along the coordinate of each limit, opening positive [N s or N m s]."""
        limits = slice(len(self._contacts), len(self.parts.which))
        return read_only(self._components[limits, 2].copy())

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
        geoms = np.array([own[:2] for own in self._contacts], dtype=int).reshape(-1, 2)
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
