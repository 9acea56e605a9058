"""One contact against the world and nothing else to hold: the shortest way to Δv.

The general way costs more in bookkeeping than in physics when a robot meets the
ground at one point. Here only P is found at once; books and residuals are worked out
from the same numbers when somebody asks.
"""

from __future__ import annotations

import weakref
from collections.abc import Callable
from functools import cached_property

import numpy as np

from ..errors import InputError
from ..laws.coulomb import coulomb_impulse
from ..laws.tolerances import ROUNDING
from ..rows.constraints import needs_places
from ..rows.contacts import PairContact
from ..rows.faint import faintest_mobility
from ..rows.reach import ReachedModel, reached_model, touched_joints
from ..scene import Contact, Scene
from ..scene.friction import static_friction
from ..scene.restitution import restitution_at
from .algorithms import cholesky_solve, crba, decompose
from .constrained import ConstrainedJump
from .contact_space import ContactProblem, find_impulses
from .contact_space.problem import THROWN, is_thrown
from .known import KnownImpulses
from .outcome import Outcome
from .singular import check_pivots

__all__ = ["SingleContactJump"]


class SingleContactJump:
    """Δv with one contact under Newton's law, slip at its end."""

    def __init__(
        self, scene: Scene, known: KnownImpulses, reached: ReachedModel, *, always_regular: bool
    ) -> None:
        (entry,) = scene.contacts
        if not isinstance(entry, Contact):
            raise TypeError(type(entry).__name__)
        # Whoever keeps this for a scene may not keep the scene by it.
        self._scene = weakref.ref(scene)
        self._known = known if scene.impulses else None
        # The rows add a frame to the model, and data has to be made after that.
        self._rows = PairContact(scene.robot, reached, entry, 0)
        self._faintest = faintest_mobility(sum(body.mass for body in reached.model.inertias))
        self._model, self._data = known.model, known.model.createData()
        self._always_regular = always_regular
        self._law = scene.law
        self._restitution = entry.restitution
        self._varying = callable(entry.restitution)
        self._e = 0.0 if callable(entry.restitution) else entry.restitution
        self._mu, self._e_t = static_friction(entry.friction), entry.tangential_restitution
        self._name = scene.entry_names("contacts")[0]

    @cached_property
    def _refining(self) -> ConstrainedJump:
        """The general way, on a model of its own."""
        scene = self._scene()
        if scene is None:
            raise InputError("the scene of this solver is gone")
        robot = scene.robot
        reached = reached_model(
            robot.model, touched_joints(scene), keep_places=needs_places(robot, scene)
        )
        known = KnownImpulses(scene, reached)
        return ConstrainedJump(scene, known, reached, always_regular=self._always_regular)

    def solve(
        self, q: np.ndarray, v: np.ndarray
    ) -> tuple[np.ndarray, Callable[[], Outcome] | Outcome]:
        """(nv,) Δv of the reached model, and the rest of the outcome or a call that gives it.

        Where a blow alone would throw the point many times as fast as it moves in the end, W P
        has lost digits: that is for the general way, which refines.

        Raises:
            SingularMassError: it names the joints that move no inertia at q.
            RangeError: a restitution function gave something else than 0 to 1.
        """
        model, data = self._model, self._data
        jacobian = self._rows.jacobian_at(data, q)
        impulse = None
        if self._known is not None:
            impulse = self._known.generalized_impulse(data, q)
        crba(model, data, q)
        decompose(model, data)
        if not self._always_regular:
            check_pivots(model, data)
        x1 = cholesky_solve(model, data, jacobian[0])
        x2 = cholesky_solve(model, data, jacobian[1])
        xn = cholesky_solve(model, data, jacobian[2])
        moved = np.array((x1, x2, xn))
        delassus = moved.dot(jacobian.T)
        (t11, t12, n1), (_, t22, n2), (_, _, nn) = delassus.tolist()
        if 0.0 < nn <= self._faintest or (self._mu and 0.0 < t11 + t22 <= self._faintest):
            # These may be rounding of rows that are zero.
            return self._refining.solve(q, v)
        before = jacobian.dot(v)
        u1, u2, un = before.tolist()
        dv_known = None
        f1, f2, fn = u1, u2, un
        free = before
        if impulse is not None:
            dv_known = cholesky_solve(model, data, impulse)
            free = before + jacobian.dot(dv_known)
            f1, f2, fn = free.tolist()
        e = self._e
        if self._varying:
            e = restitution_at(self._restitution, max(-un, 0.0), f"{self._name}: restitution")
        target = e * un if un < 0.0 else 0.0
        mu, e_t = self._mu, self._e_t
        scale = max(abs(un), abs(fn))
        if mu:
            scale = max(scale, abs(u1), abs(u2), abs(f1), abs(f2))
        p = coulomb_impulse(
            (t11, t12, t22, n1, n2, nn),
            f1 + e_t * u1 if mu else 0.0,
            f2 + e_t * u2 if mu else 0.0,
            fn + target,
            mu,
            scale,
        )
        dv = np.array(p).dot(moved)
        if dv_known is not None:
            dv += dv_known
            if p[2] > 0.0:
                after = before + jacobian.dot(dv)
                off = (after - free - delassus.dot(p)).tolist()
                most = max(map(abs, (u1, u2, un, *after.tolist())))
                thrown = max(abs(f1), abs(f2), abs(fn)) > THROWN * most
                if max(map(abs, off)) > ROUNDING * most or (
                    thrown and is_thrown(free, before, jacobian, dv)
                ):
                    return self._refining.solve(q, v)

        def outcome() -> Outcome:
            problem = ContactProblem(
                delassus, before, free, np.array([e]), np.array([mu]), np.array([e_t])
            )
            touch = self._rows.touch_of(data, jacobian)
            return Outcome(np.empty(0), None, (touch,), find_impulses(problem, self._law))

        return dv, outcome
