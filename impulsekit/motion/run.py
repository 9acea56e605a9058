"""One motion from start to end: steps, events, rests."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import cached_property

import numpy as np
import pinocchio as pin

from ..errors import ContradictionError, ImpulsekitError, InputError, SingularMassError
from ..impact import Impact, ImpactSolver, Status
from ..scene import Scene
from ..scene.motion import MotionSettings
from .chart import Chart
from .dynamics import Dynamics
from .events import first_crossing, first_stop
from .path import Path
from .rest_law import RestNotSolved
from .resting import RestingContact
from .status import MotionStatus
from .steppers import StepFailed, stepper_of
from .trajectory import Rest, Trajectory

__all__ = ["Run"]

# What may overlap at the start [m]: rounding of a state written by hand.
PENETRATION = 1e-6
# Gaps at the start up to this [m] touch.
TOUCHING = 1e-9
# How far the distance of colliding bodies may be off where they have just parted [m].
WAVER = 1e-8
# Drift below this [m, rad] or [m/s] is left alone.
NO_DRIFT = 1e-14
# So many events without any time between them never end.
MOST_STILL = 1000
# Slip [m/s] that stops sooner than time can tell has stopped.
STOPPED = 1e-8
# A joint that turns goes no further than this in one step [rad].
LONGEST_TURN = 1.0
# Laws whose answer counts although it is not beyond doubt.
_USABLE = {
    Status.SOLVED,
    Status.NOT_UNIQUE,
    Status.PAINLEVE_JAM,
    Status.ENERGY_GAIN,
    Status.MANY_SOLUTIONS,
}


class _Stopped(Exception):
    """The motion ends here with a status."""

    def __init__(self, status: MotionStatus, detail: str = "") -> None:
        super().__init__(status, detail)
        self.status, self.detail = status, detail


class Run:
    """The state of a motion while it is worked out."""

    def __init__(
        self,
        scene: Scene,
        q: np.ndarray,
        v: np.ndarray,
        settings: MotionSettings,
        progress: Callable[[float], None] | None,
    ) -> None:
        self._scene, self._settings, self._progress = scene, settings, progress
        self._dynamics = Dynamics(scene)
        self._model = self._dynamics.model
        self._gaps = self._dynamics.gaps
        self._resting = self._dynamics.resting
        self._chart = Chart(self._model)
        self._t, self._q, self._v = 0.0, q, v
        self._path = Path(self._model)
        self._impacts: list[tuple[float, Impact]] = []
        self._rests: list[Rest] = []
        self._steps = 0
        count = 0 if self._gaps is None else len(self._gaps.items)
        self._base = np.zeros(count)
        self._stepper = stepper_of(
            settings.method,
            self._rates,
            settings.duration,
            settings.rtol,
            settings.atol,
            settings.step,
        )

    def trajectory(self, times: np.ndarray | None) -> Trajectory:
        """The motion, sampled at ``times`` or evenly."""
        settings = self._settings
        status, detail = MotionStatus.FINISHED, ""
        self._start()
        try:
            self._follow()
        except _Stopped as stop:
            status, detail = stop.status, stop.detail
        if not len(self._path):
            self._add_still(self._t)
        if times is None:
            count = settings.samples if settings.duration > 0.0 else 1
            times = np.linspace(0.0, settings.duration, count)
        if self._t < settings.duration:
            times = np.append(times[times < self._t], self._t)
        rests = [*self._rests, *(self._rest(c, math.inf) for c in self._resting.contacts)]
        return Trajectory(
            self._scene,
            times,
            self._path,
            tuple(self._impacts),
            tuple(sorted(rests, key=lambda rest: rest.start)),
            status,
            detail=detail,
            steps=self._steps,
            evaluations=self._dynamics.evaluations,
        )

    # The start

    def _start(self) -> None:
        """Impulses strike, what touches is met, what holds is taken hold of."""
        touching: list[int] = []
        meets = bool(self._scene.impulses)
        if self._gaps is not None:
            gap, _ = self._gaps.everything(self._q, self._v)
            self._refuse_penetration(gap)
            self._base = np.minimum(gap, 0.0)
            touching = np.flatnonzero(gap <= TOUCHING).tolist()
            meets |= any(self._closing(i, self._q, self._v) < 0.0 for i in touching)
        held = self._dynamics.held
        if held is not None and not meets:
            rows = held.matrix(held.data, self._q)
            speed = rows.dot(self._v)
            scale = np.abs(rows).dot(np.abs(self._v)).max(initial=0.0)
            moves = np.abs(np.where(self._kept, 0.0, held.velocity - speed)).max(initial=0.0)
            meets = moves > 1e-9 * max(scale, float(np.abs(held.velocity).max(initial=0.0)))
        if meets:
            impact = self._first_impact(touching)
            self._note(impact)
            self._v = impact.v_after.copy()
        if held is not None:
            held.start(self._q, self._v)
        # Whatever is wrong with the dynamics at the start is the caller's to know.
        first = self._try_acceleration()
        if not np.isfinite(first).all():
            joints = self._scene.robot.joint_names
            raise SingularMassError(
                "the acceleration at the start is not finite: a joint moves no inertia, or a "
                "force of the scene is not a number",
                joints=joints,
            )
        self._rest_on(touching)

    def _try_acceleration(self) -> np.ndarray:
        return self._dynamics.acceleration(self._t, self._q, self._v)

    @cached_property
    def _kept(self) -> np.ndarray:
        held = self._dynamics.held
        if held is None or held.kept is None:
            return np.zeros(0 if held is None else len(held.names), dtype=bool)
        return held.kept

    def _refuse_penetration(self, gap: np.ndarray) -> None:
        if self._gaps is None:
            return
        worst = int(np.argmin(gap)) if len(gap) else -1
        if worst >= 0 and gap[worst] < -PENETRATION:
            name = self._scene.entry_names("contacts")[self._gaps.entries[worst]]
            raise InputError(
                f"{name} is penetrated at the start by {-gap[worst]:.3g} (m, or rad of a stop); "
                "move the robot out of it, or the contact's plane or limit",
                contact=name,
                gap=float(gap[worst]),
            )

    def _first_impact(self, touching: list[int]) -> Impact:
        entries = self._entries_of(touching)
        return ImpactSolver(self._scene).solve_touching(self._q, self._v, entries)

    # Stepping

    def _rates(self, t: float, y: np.ndarray) -> np.ndarray:
        """ẏ of y = (x, v)."""
        nv = self._model.nv
        x, v = y[:nv], y[nv:]
        q = self._chart.configuration(x)
        rates = np.empty(2 * nv)
        rates[:nv] = self._chart.rate(x, q, v)
        rates[nv:] = self._dynamics.acceleration(t, q, v)
        return rates

    def _restart(self, first: float | None = None) -> None:
        x = self._chart.centred(self._q)
        with self._told():
            self._stepper.reset(self._t, np.concatenate([x, self._v]), first)

    def _follow(self) -> None:
        """From the start to the end of the duration."""
        settings = self._settings
        if self._t >= settings.duration:
            return
        self._restart()
        still = 0
        while self._t < settings.duration:
            if self._steps >= settings.max_steps:
                raise _Stopped(MotionStatus.TOO_MANY_STEPS)
            before = self._t
            self._step()
            still = still + 1 if self._t == before else 0
            if still == MOST_STILL:
                raise _Stopped(MotionStatus.STEP_TOO_SMALL, "events follow each other at one time")
            if self._progress is not None:
                self._progress(self._t)

    def _step(self) -> None:
        start, stepper, chart = self._t, self._stepper, self._chart
        speed = chart.turning_speed(self._v)
        longest = LONGEST_TURN / speed if speed > 0.0 else math.inf
        with self._told():
            dense = stepper.step(longest)
        self._steps += 1
        nv, reference = self._model.nv, chart.reference
        end = stepper.t
        if not np.isfinite(stepper.y).all():
            raise _Stopped(MotionStatus.NOT_FINITE)

        def states(t: float) -> tuple[np.ndarray, np.ndarray]:
            y = dense(t)
            return chart.configuration(y[:nv]), y[nv:]

        if self._gaps is not None and self._happens(start, end, states, dense, reference):
            return
        self._path.append(start, end, reference, dense)
        self._t = end
        self._q = np.array(chart.configuration(stepper.y[:nv]))
        self._v = stepper.y[nv:].copy()
        if self._dynamics.held is not None or self._resting.contacts:
            self._settle_step()
        elif not chart.is_flat:
            rates = stepper.f.copy()
            x = chart.centred(self._q)
            rates[:nv] = chart.rate(x, self._q, self._v)
            stepper.moved(np.concatenate([x, self._v]), rates)

    def _happens(
        self,
        start: float,
        end: float,
        states: Callable[[float], tuple[np.ndarray, np.ndarray]],
        dense: Callable[[float], np.ndarray],
        reference: np.ndarray,
    ) -> bool:
        """Cut the step at its first event, if it has one, and deal with that."""
        gaps = self._gaps
        if gaps is None:
            return False
        resting = [c.gap for c in self._resting.contacts]
        crossing = first_crossing(
            gaps, states, start, end, self._base, resting, self._settings.together
        )
        stop = None
        if resting:
            until = end if crossing is None else crossing.t
            if until > start:
                stop = first_stop(gaps, self._resting, states, start, until)
        if crossing is None and stop is None:
            return False
        time = stop[0] if stop is not None else crossing.t if crossing is not None else end
        if time > start:
            self._path.append(start, time, reference, dense)
        self._t = time
        q, v = states(time)
        self._q, self._v = np.array(q), np.array(v)
        if stop is not None and stop[1]:
            gaps.hold([], self._q)
            self._after_crossing(tuple(resting))
        elif stop is not None:
            self._after_stop()
        elif crossing is not None:
            self._after_crossing(crossing.gaps)
        return True

    # Events

    def _after_crossing(self, closing: tuple[int, ...]) -> None:
        """An impact of what closes, with all that rests taking part."""
        if len(self._impacts) >= self._settings.max_impacts:
            raise _Stopped(MotionStatus.EVENT_STORM)
        taking_part = sorted({*closing, *(c.gap for c in self._resting.contacts)})
        approach = max(-self._closing(i, self._q, self._v) for i in closing)
        if approach <= 0.0 and not any(self._gaps_rated(closing)):
            # coal's distance wavers where bodies have just parted: nothing meets here.
            for i in closing:
                self._base[i] -= WAVER
            self._restart(self._first_step(closing))
            return
        soft = approach < max(self._settings.capture_speed, *self._capture_speeds(closing))
        solver = self._soft_solver if soft else self._solver
        try:
            impact = solver.solve_touching(self._q, self._v, self._entries_of(taking_part))
        except ImpulsekitError as error:
            raise _Stopped(MotionStatus.IMPACT_NOT_VALID, str(error)) from None
        self._note(impact)
        self._v = impact.v_after.copy()
        self._rest_on(taking_part)
        self._restart(self._first_step(closing))

    def _capture_speeds(self, gaps: Iterable[int]) -> list[float]:
        items = [] if self._gaps is None else self._gaps.items
        return [getattr(items[i], "capture_speed", 0.0) for i in gaps]

    def _gaps_rated(self, gaps: Iterable[int]) -> list[bool]:
        return [] if self._gaps is None else [bool(self._gaps.rated[i]) for i in gaps]

    def _first_step(self, left: Iterable[int]) -> float | None:
        """No longer than the shortest hop of what has just been struck [s]."""
        gaps = self._gaps
        if gaps is None:
            return None
        resting = {c.gap for c in self._resting.contacts}
        contacts = [
            RestingContact(i, int(gaps.entries[i]), 0.0, self._t) for i in left if i not in resting
        ]
        if not contacts:
            return None
        acceleration = self._acceleration()
        moving = self._model.createData()
        zero = np.zeros(self._model.nv)
        pin.forwardKinematics(self._model, moving, self._q, self._v, zero)
        rows, bias = gaps.rows_and_bias(contacts, self._q, self._v, moving)
        speed = rows.dot(self._v)[2::3]
        rate = (rows.dot(acceleration) + bias)[2::3]
        hops = [2.0 * u / -a for u, a in zip(speed, rate, strict=True) if a < 0.0 < u]
        return min(hops) if hops else None

    def _after_stop(self) -> None:
        """A slip has stopped, or a contact has lifted."""
        gaps = self._gaps
        if gaps is None:
            return
        u = gaps.velocities(self._resting.contacts, self._q, self._v)
        i = 0
        for contact in self._resting.contacts:
            slides = contact.slides
            for k in range(min(contact.count, len(slides))):
                s = slides[k]
                slip = u[3 * i : 3 * i + 2]
                # In three dimensions it may only have turned.
                if s is not None and np.hypot(*slip) <= 1e-6 * max(1.0, np.abs(self._v).max()):
                    slides[k] = None if slip.dot(s) <= STOPPED else s
                elif s is not None:
                    slides[k] = slip / np.hypot(*slip)
                i += 1
        self._settle(restart=True)

    # Rest

    def _rest_on(self, candidates: list[int]) -> None:
        """After an impact: what of the candidates stays, and how."""
        gaps = self._gaps
        if gaps is None:
            return
        slow = max(1e-3 * self._settings.capture_speed, 1e-12 * float(np.abs(self._v).max()))
        before = {c.gap: c for c in self._resting.contacts}
        stays: list[RestingContact] = []
        for i in candidates:
            if self._closing(i, self._q, self._v) <= slow:
                item = gaps.items[i]
                stays.append(
                    before.get(i) or RestingContact(i, int(gaps.entries[i]), item.friction, self._t)
                )
        kept = {c.gap for c in stays}
        self._rests += [self._rest(c, self._t) for c in before.values() if c.gap not in kept]
        self._resting.contacts = stays
        gap, _ = gaps.everything(self._q, self._v)
        self._base = np.minimum(gap, 0.0)
        gaps.hold(stays, self._q)
        if stays:
            for contact in stays:
                contact.slides = []
            self._settle(restart=False, fresh=True)

    def _settle_step(self) -> None:
        """After a step with something held or resting: drift is taken out, loads looked at."""
        if self._resting.contacts:
            self._settle(restart=None)
            return
        self._project([])
        self._moved()

    def _settle(self, *, restart: bool | None, fresh: bool = False) -> None:
        """Look at the resting contacts: which are loaded, lift or slide from here on.

        Args:
            restart: whether the integrator starts anew; None for only if need be.
            fresh: after an impact.
        """
        resting = self._resting
        self._acceleration()
        changed = self._release()
        if changed:
            self._acceleration()
        changed |= resting.update_slides(fresh=fresh)
        self._project(self._bound())
        if resting.contacts:
            self._acceleration()
            # Once more: what was found to slide may change the loads of the others.
            changed |= resting.update_slides(fresh=False)
        if restart or (restart is None and changed):
            self._restart()
        elif restart is None:
            self._moved()

    def _release(self) -> bool:
        """Let go of contacts that have lifted; whether there was one."""
        resting, gaps = self._resting, self._gaps
        if gaps is None or not resting.contacts:
            return False
        loaded, speeds = resting.loaded(), resting.slip[2::3]
        stays: list[RestingContact] = []
        i = 0
        for contact in resting.contacts:
            own = slice(i, i + contact.count)
            i += contact.count
            lifted = contact.count == 0 or (
                not loaded[own].any() and bool((speeds[own] > 0.5e-8).all())
            )
            if lifted:
                self._rests.append(self._rest(contact, self._t))
            else:
                stays.append(contact)
        if len(stays) == len(resting.contacts):
            return False
        resting.contacts = stays
        gaps.hold(stays, self._q)
        gap, _ = gaps.everything(self._q, self._v)
        self._base = np.minimum(gap, 0.0)
        return True

    def _bound(self) -> list[tuple[int, int]]:
        """Rows of resting points that keep still: (point, row), the normal first."""
        resting = self._resting
        friction, loaded = resting.friction(), resting.loaded()
        found = []
        for i, slide in enumerate(resting.slides()):
            if not loaded[i]:
                continue
            found.append((i, 2))
            if slide is None and friction[i]:
                found += [(i, 0), (i, 1)]
        return found

    def _project(self, bound: list[tuple[int, int]]) -> None:
        """Take the drift of held and resting rows out of positions, then of velocities."""
        held, gaps, dynamics = self._dynamics.held, self._gaps, self._dynamics
        chosen = [3 * i + row for i, row in bound]
        owners = [c.gap for c in self._resting.contacts for _ in range(c.count)]
        for _ in range(3):
            drift, of_rows = (
                (np.empty(0), np.empty(0, dtype=int))
                if held is None
                else held.drift(self._q, self._t)
            )
            gap = np.empty(0)
            normals = [3 * i + 2 for i, row in bound if row == 2]
            if gaps is not None and normals:
                values, _ = gaps.measure(self._q, self._v, sorted(set(owners)))
                gap = np.array([values[owners[i]] for i, row in bound if row == 2])
            off = np.concatenate([drift, gap])
            if not np.abs(off).max(initial=0.0) > NO_DRIFT:
                break
            rows = []
            if held is not None:
                rows.append(held.matrix(held.data, self._q)[of_rows])
            if gap.size and gaps is not None:
                rows.append(gaps.rows(self._resting.contacts, self._q)[normals])
            change = dynamics.moved(self._q, np.vstack(rows), -off)
            self._q = pin.integrate(self._model, self._q, change)
        rows, wanted = [], []
        if held is not None:
            rows.append(held.matrix(held.data, self._q))
            wanted.append(held.velocity)
        if gaps is not None and chosen:
            rows.append(gaps.rows(self._resting.contacts, self._q)[chosen])
            wanted.append(np.zeros(len(chosen)))
        if not rows:
            return
        matrix = np.vstack(rows)
        off = np.concatenate(wanted) - matrix.dot(self._v)
        if np.abs(off).max(initial=0.0) > NO_DRIFT:
            self._v = self._v + dynamics.moved(self._q, matrix, off)

    # Small things

    def _moved(self) -> None:
        """Tell the integrator where drift was taken out to."""
        x = self._chart.centred(self._q)
        y = np.concatenate([x, self._v])
        with self._told():
            self._stepper.moved(y, self._rates(self._t, y))

    def _acceleration(self) -> np.ndarray:
        with self._told():
            return self._dynamics.acceleration(self._t, self._q, self._v)

    def _told(self) -> _Told:
        return _Told(self)

    def failure(self) -> _Stopped:
        """Why no step is short enough."""
        try:
            finite = np.isfinite(self._dynamics.acceleration(self._t, self._q, self._v)).all()
        except (ContradictionError, RestNotSolved):
            finite = True
        large = not np.abs(self._v).max(initial=0.0) < 1e100
        status = MotionStatus.STEP_TOO_SMALL if finite and not large else MotionStatus.NOT_FINITE
        return _Stopped(status)

    @cached_property
    def _later(self) -> Scene:
        """The scene of impacts on the way: its impulses struck at the start."""
        return replace(self._scene, impulses=())

    @cached_property
    def _solver(self) -> ImpactSolver:
        return ImpactSolver(self._later)

    @cached_property
    def _soft_solver(self) -> ImpactSolver:
        """For approaches below the capture speed: without restitution."""
        contacts = [replace(entry, restitution=0.0) for entry in self._scene.contacts]
        return ImpactSolver(replace(self._later, contacts=contacts))

    def _note(self, impact: Impact) -> None:
        self._impacts.append((self._t, impact))
        outcome = impact.outcome
        solution = None if outcome is None else outcome.contacts
        usable = solution is None or solution.status in _USABLE
        if not usable or not np.isfinite(impact.dv).all():
            detail = "" if solution is None else solution.status.value
            raise _Stopped(MotionStatus.IMPACT_NOT_VALID, detail)

    def _entries_of(self, gaps: Iterable[int]) -> set[int]:
        return set() if self._gaps is None else {int(self._gaps.entries[i]) for i in gaps}

    def _closing(self, i: int, q: np.ndarray, v: np.ndarray) -> float:
        """The rate of a gap that is closed, negative where it closes [m/s]."""
        gaps = self._gaps
        if gaps is None:
            return 0.0
        if gaps.rated[i]:
            return float(gaps.measure(q, v, (i,))[1][i])
        contact = RestingContact(i, int(gaps.entries[i]), 0.0, self._t)
        speeds = gaps.velocities([contact], q, v)[2::3]
        return float(speeds.min()) if speeds.size else 0.0

    def _rest(self, contact: RestingContact, end: float) -> Rest:
        return Rest(self._scene.entry_names("contacts")[contact.entry], contact.since, end)

    def _add_still(self, t: float) -> None:
        """A path of no length, for motions that end where they begin."""
        x = self._chart.centred(self._q)
        y = np.concatenate([x, self._v])
        self._path.append(t, t, self._chart.reference, lambda _: y)


class _Told:
    """Turns what the dynamics raise on the way into the end of the motion."""

    def __init__(self, run: Run) -> None:
        self._run = run

    def __enter__(self) -> None:
        return None

    def __exit__(self, kind: type | None, error: BaseException | None, _: object) -> None:
        if isinstance(error, StepFailed):
            raise self._run.failure() from None
        if isinstance(error, RestNotSolved):
            raise _Stopped(MotionStatus.REST_NOT_SOLVED, str(error)) from None
        if isinstance(error, ContradictionError):
            raise _Stopped(MotionStatus.CONTRADICTION, str(error)) from None
