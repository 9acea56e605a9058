"""Periodic motions across impacts: a return map from impact to impact, and Newton on it.

x ↦ start(x) = (q, v) just after an impact; the motion goes on until the contact is hit again, and
back(q⁺, v⁺) = P(x). With Φ the derivative of the state before that impact by the start, n the row
of the gap, f = (v, a) and Ξ the saltation matrix, the impact is late by δT = −n Φ δ/(n·v⁻), so

    DP = D back · (Ξ Φ + f⁺ δT) · D start                    (Guckenheimer & Holmes 1983, ch. 1.5).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin

from ..._core import ForcesOfMotion
from ...errors import ImpulsekitError, InputError, RangeError, SolveError, check_kind, quoted
from ...errors.calls import public
from ...formatting import OneLine
from ...robot import state
from ...robot.arrays import lock
from ...scene import Scene
from ...scene.functions import call, numbers_from
from ...scene.motion import MotionSettings
from ...tolerances import NONZERO
from ..flat import flat_motion
from ..simulate import simulate
from .flow import ATOL, RTOL, slopes
from .sensitivity import Chain

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ..record.trajectory import Trajectory

__all__ = ["Orbit", "find_orbit"]

# Steps of the differences of ``start`` and ``back``, and of whole motions where these are needed.
ORBIT_STEP, COARSE = 1e-4, 1e-5
# How often Newton goes on, and halves a step that leads further away.
MOST_STEPS, HALVES = 30, 12
# A motion is followed for this many times the period before it; where it comes to no impact so
# many times longer, up to the longest.
MARGIN_OF_PERIOD, LONGER_SEARCH = 1.2, 3.0
# A motion ends so long after the impact it was followed to, as a part of its time [s].
AFTER = 1e-3
# An impact so soon [s] after the start is the one that the motion starts from.
AT_START = 1e-9
# A fall that is slower than this part of all speeds grazes.
GRAZES = 1e-9

State = tuple[np.ndarray, np.ndarray]


@dataclass(frozen=True, eq=False, repr=False)
class Orbit(OneLine):
    """A periodic motion.

    Attributes:
        x: (n,) the coordinates of its start.
        q, v: (nq,), (nv,) the state there, just after the impact.
        period: from impact to impact [s].
        motion: one period, and a little after the impact.
        derivative: (n, n) of the return map x ↦ P(x).
        residual: the largest entry of P(x) − x.
        by_differences: whether the derivative is one by differences of whole motions, because
            ``sensitivity`` has none.
    """

    x: np.ndarray
    q: np.ndarray = field(repr=False)
    v: np.ndarray = field(repr=False)
    period: float
    motion: Trajectory = field(repr=False)
    derivative: np.ndarray = field(repr=False)
    residual: float
    by_differences: bool

    @property
    def multipliers(self) -> np.ndarray:
        """(n,) eigenvalues of ``derivative``, the largest first."""
        values = np.linalg.eigvals(self.derivative)
        return values[np.argsort(-np.abs(values))]

    @property
    def is_stable(self) -> bool:
        """True if every multiplier is less than 1 in size."""
        return bool(np.abs(self.multipliers).max(initial=0.0) < 1.0)


@public
def find_orbit(
    scene: Scene,
    x: ArrayLike,
    *,
    start: Callable[[np.ndarray], Any],
    back: Callable[[np.ndarray, np.ndarray], ArrayLike],
    contact: str | Sequence[str],
    duration: float = 10.0,
    tol: float = 1e-10,
    settings: MotionSettings | None = None,
) -> Orbit:
    """Find a periodic motion by Newton's method on its return map, with its multipliers.

    Args:
        scene: what moves; its impulses do not act.
        x: (n,) a guess of the start's coordinates: those that have to return.
        start: function of x that gives (q, v) just after an impact.
        back: function of (q, v) just after the next one that gives x; the two may speak of the
            other leg, or of a place further on.
        contact: name of the contact whose impact ends the period, or several names.
        duration: the longest period [s].
        tol: largest entry of P(x) − x.
        settings: of the motion; by default rtol 1e-12 and atol 1e-13.

    Returns:
        The orbit; it need not be stable.

    Raises:
        InputError, RangeError, UnknownNameError, ShapeError, CallbackError: what is wrong with the
            arguments; a motion from the guess that comes to no impact of the contact.
        SolveError: Newton's method did not converge.

    Example:
        A ball on a plate that gives it back what it loses returns after every bounce.

        >>> from impulsekit import Contact, Robot, Scene
        >>> ball = Robot.from_urdf("models/ball.urdf", root="freeflyer")
        >>> scene = Scene(ball, contacts=[Contact("ball", restitution=0.5, name="floor")])
        >>> def start(x):
        ...     return ball.neutral(), ball.velocity(root_joint=[0, 0, x[0], 0, 0, 0])
        >>> orbit = find_orbit(
        ...     scene, [1.0], start=start, back=lambda q, v: [v[2] + 1.0], contact="floor"
        ... )
        >>> round(float(orbit.x[0]), 9), round(float(orbit.multipliers[0].real), 6)
        (2.0, 0.5)
    """
    check_kind(scene, Scene, "find_orbit")
    return _Search(scene, start, back, contact, duration, settings).found(x, tol)


class _Search:
    """Newton on the return map of a scene."""

    def __init__(
        self,
        scene: Scene,
        start: Callable,
        back: Callable,
        contact: str | Sequence[str],
        duration: float,
        settings: MotionSettings | None,
    ) -> None:
        from ...errors import UnknownNameError

        for function, name in ((start, "start"), (back, "back")):
            if not callable(function):
                raise InputError(f"find_orbit: {name} must be a function, got {quoted(function)}")
        self._scene = replace(scene, impulses=())
        self._start, self._back = start, back
        names = scene.entry_names("contacts")
        if not (isinstance(contact, Sequence) and len(contact)):
            raise InputError(
                f"find_orbit: contact must be a name or a list of names, got {quoted(contact)}"
            )
        if not (settings is None or isinstance(settings, MotionSettings)):
            raise InputError(f"find_orbit: settings must be MotionSettings, got {quoted(settings)}")
        self._contacts = [contact] if isinstance(contact, str) else list(contact)
        for name in self._contacts:
            if name not in names:
                raise UnknownNameError.among("contact", str(name), names)
        base = MotionSettings(rtol=RTOL, atol=ATOL, samples=2) if settings is None else settings
        self._settings = base.changed(duration=duration)
        self._model = scene.robot.model
        self._size, self._span = 0, duration / LONGER_SEARCH**2

    def found(self, x: ArrayLike, tol: float) -> Orbit:
        """The orbit near x."""
        try:
            guess = np.array(x, ndmin=1)
        except ValueError:  # lists of different lengths
            guess = np.empty(0)
        numbers = guess.dtype.kind in "iuf" and guess.ndim == 1 and guess.size > 0
        if not (numbers and np.isfinite(guess).all()):
            raise InputError(f"find_orbit: x must be a list of finite numbers, got {quoted(x)}")
        x = guess.astype(float)
        if not tol > 0.0:
            raise RangeError.of("find_orbit: tol", tol, "above 0")
        self._size = len(x)
        motion, after = self._turn(x)
        off = after - x
        for _ in range(MOST_STEPS):
            if np.abs(off).max() <= tol:
                return self._orbit(x, motion, off)
            derivative, _ = self._derivative(x, motion)
            step = np.linalg.lstsq(np.eye(len(x)) - derivative, off, rcond=None)[0]
            # Where the map nearly keeps x, Newton's step is without bounds.
            step *= min(1.0, max(1.0, float(np.abs(x).max())) / max(np.abs(step).max(), NONZERO))
            x, motion, off = self._nearer(x, step, off)
        raise SolveError(
            f"find_orbit: {MOST_STEPS} steps of Newton's method left {np.abs(off).max():.3g}, "
            f"tol is {tol:g}; begin nearer, or allow more",
            residual=float(np.abs(off).max()),
        )

    def _nearer(
        self, x: np.ndarray, step: np.ndarray, off: np.ndarray
    ) -> tuple[np.ndarray, Trajectory, np.ndarray]:
        """A step, halved until it leads nearer."""
        before, why = float(np.linalg.norm(off)), ""
        for halved in range(HALVES):
            there = x + 0.5**halved * step
            try:
                motion, after = self._turn(there)
            except ImpulsekitError as error:
                if error.from_function:
                    raise
                why = f" {error}"
                continue
            if np.linalg.norm(after - there) < before:
                return there, motion, after - there
        raise SolveError(
            f"find_orbit: no step of Newton's method leads nearer than {before:.3g}; begin nearer, "
            f"with a tol that rounding allows.{why}",
            residual=before,
        )

    def _turn(self, x: np.ndarray) -> tuple[Trajectory, np.ndarray]:
        """The motion from x to the next impact and a little on, and P(x)."""
        q, v = self._state(x)
        duration = self._settings.duration
        span = min(self._span, duration)
        while True:
            motion = simulate(self._scene, q, v, settings=self._settings.changed(duration=span))
            found = self._hit(motion)
            if found is not None or span >= duration or not motion.status.finished:
                break
            span = min(LONGER_SEARCH * span, duration)
        if found is None:
            raise InputError(
                f"find_orbit: from x = {x.tolist()} no impact of {' or '.join(self._contacts)} "
                f"within {duration:g} s ({motion.status.name}; {len(motion.impacts)} impacts)"
            )
        time, impact = motion.impacts[found]
        # The next one will be about as long.
        self._span = MARGIN_OF_PERIOD * time
        return motion, self._returned(impact.q, impact.v_after)

    def _hit(self, motion: Trajectory) -> int | None:
        """Return the impact that ends the period."""
        names = motion.scene.entry_names("contacts")
        for i, (time, impact) in enumerate(motion.impacts):
            if time <= AT_START or impact.outcome is None:
                continue
            # Of what touches, resting contacts were there before.
            touched = {names[touch.entry] for touch in impact.outcome.touches}
            rests = {r.contact for r in motion.rests if r.start < time - AT_START <= r.end}
            if touched.intersection(self._contacts) - rests:
                return i
        return None

    def _state(self, x: np.ndarray) -> State:
        given = call(self._start, "find_orbit: start", x)
        try:
            q, v = given
        except (TypeError, ValueError):
            raise InputError("find_orbit: start must give two vectors, (q, v)") from None
        return state.checked_configuration(self._model, q), state.checked_velocity(self._model, v)

    def _returned(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        return numbers_from(self._back, "find_orbit: back", self._size, q, v)

    def _derivative(self, x: np.ndarray, motion: Trajectory) -> tuple[np.ndarray, bool]:
        """(n, n) DP, and whether it is one by differences of whole motions."""
        try:
            return self._by_chain(x, motion), False
        except (InputError, RangeError) as error:
            if error.from_function:
                raise
            return self._by_differences(x), True

    def _by_differences(self, x: np.ndarray) -> np.ndarray:
        columns = []
        for i in range(len(x)):
            h = np.zeros(len(x))
            h[i] = COARSE * max(1.0, abs(x[i]))
            columns.append((self._turn(x + h)[1] - self._turn(x - h)[1]) / (2.0 * h[i]))
        return np.array(columns).T

    def _by_chain(self, x: np.ndarray, motion: Trajectory) -> np.ndarray:
        index = self._hit(motion)
        if index is None:
            raise InputError("no impact")
        time, impact = motion.impacts[index]
        chain = Chain(motion)
        before, whole, rates = chain.to_impact(index)
        row = self._gap_row(impact, motion, time)
        nv = self._model.nv
        speed = float(row @ impact.v_before)
        if not abs(speed) > GRAZES * float(np.abs(impact.v_before).max()):
            raise InputError("find_orbit: the contact is only grazed")
        late = -(row @ before[:nv]) / speed
        total = whole + np.outer(np.concatenate([impact.v_after, rates]), late)
        return self._back_slope(impact.q, impact.v_after) @ total @ self._start_slope(x)

    def _gap_row(self, impact: Any, motion: Trajectory, time: float) -> np.ndarray:
        """(nv,) the row of the gap that closes."""
        core = ForcesOfMotion(flat_motion(self._scene).core, 0.0)
        names = motion.scene.entry_names("contacts")
        rests = {r.contact for r in motion.rests if r.start < time - AT_START <= r.end}
        touched = [names[t.entry] for t in impact.outcome.touches]
        closing = [n for n in touched if n in self._contacts and n not in rests]
        gaps = core.gaps(impact.q, impact.v_before)
        own = [(abs(at.value), at.gap) for at in gaps if names[at.entry] in closing]
        return core.gap_row(min(own)[1], impact.q, impact.v_before)

    def _start_slope(self, x: np.ndarray) -> np.ndarray:
        """(2 nv, n) how the start changes with x."""

        def away(by: np.ndarray) -> np.ndarray:
            ends = [self._state(x + sign * by) for sign in (1.0, -1.0)]
            ways = pin.difference(self._model, ends[1][0], ends[0][0])
            return np.concatenate([ways, ends[0][1] - ends[1][1]])

        return slopes(away, ORBIT_STEP * np.maximum(1.0, np.abs(x)))

    def _back_slope(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """(n, 2 nv) how what returns changes with the state."""
        nv = self._model.nv

        def away(by: np.ndarray) -> np.ndarray:
            there = [
                self._returned(pin.integrate(self._model, q, sign * by[:nv]), v + sign * by[nv:])
                for sign in (1.0, -1.0)
            ]
            return there[0] - there[1]

        return slopes(away, np.full(2 * nv, ORBIT_STEP))

    def _orbit(self, x: np.ndarray, motion: Trajectory, off: np.ndarray) -> Orbit:
        index = self._hit(motion)
        if index is None:
            raise InputError("no impact")
        time = motion.impacts[index][0]
        q, v = self._state(x)
        derivative, by_differences = self._derivative(x, motion)
        end = min(time * (1.0 + AFTER), self._settings.duration)
        period = simulate(self._scene, q, v, settings=self._settings.changed(duration=end))
        lock(x, q, v, derivative)
        residual = float(np.abs(off).max())
        return Orbit(x, q, v, time, period, derivative, residual, by_differences)
