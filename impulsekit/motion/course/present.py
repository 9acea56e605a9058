"""Where a motion has come to: the time, the state, what rests, and what has happened so far."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...errors import ContradictionError, RangeError
from ...impact import Impact
from ...scene import Scene
from ...scene.motion import MotionSettings
from ..dynamics.accelerations import Dynamics
from ..events.kinks import Kinks
from ..gaps.resting import RestingContact
from ..record.sampled import Rest
from ..record.status import MotionStatus
from ..rest.contacts import NO_SLIP
from ..rest.law import RestNotSolved
from ..steps.steppers import StepFailed
from ..travel.mover import Mover

__all__ = ["Present", "Stopped"]

# Speeds [m/s] whose squares may overflow.
HUGE = 1e100
# Slip has grown when it is this many times as fast as slip that has no direction of its own.
GROWN = 100.0
# Accelerations that make no more than this [m/s], in a second or the whole of a motion, make none.
NO_SPEED = 1e-10

# A share of the largest speed that counts as zero.
FAINT = 1e-12


# So many meetings below the capture speed, none later than this [s] after the one before, are
# chatter: two ends of an edge that rests lift each other in turn, by ever the same speed.
CHATTER, QUICK = 8, 1e-3
# Gaps that change by less than this share of the capture speed neither open nor close.
SLOW_SHARE = 1e-3


class Stopped(Exception):
    """The motion ends here with a status. Internal: a trajectory tells it."""

    def __init__(self, status: MotionStatus, detail: str = "") -> None:
        super().__init__(status, detail)
        self.status, self.detail = status, detail


@dataclass(frozen=True, eq=False)
class Mark:
    """A time of a motion: its state, what rested, and how much had happened."""

    t: float
    q: np.ndarray
    v: np.ndarray
    resting: list[RestingContact]
    impacts: int
    rests: int


class Present:
    """A motion at one time.

    Attributes:
        scene, settings: what moves, and how closely it is followed.
        dynamics: its accelerations; ``model``, ``gaps``, ``held`` and ``resting`` are its own.
        t: [s]. q: (nq,). v: (nv,).
        base: (m,) what counts as zero of each gap [m].
        passing: the gaps whose points pass through what does not count as a contact now.
        impacts: (time, impact) up to now.
        rests: those that are over.
        mover: what compiled code knows of what moves, if it knows all.
        kinks: its one-sided springs and dry joints.
        soft: by gap, how often it was met below its capture speed in quick succession, and when
            last [s].
    """

    def __init__(
        self, scene: Scene, q: np.ndarray, v: np.ndarray, settings: MotionSettings
    ) -> None:
        largest = float(np.abs(v).max(initial=0.0))
        if not largest < HUGE:
            raise RangeError.of("velocity v: its largest entry", largest, f"below {HUGE:g}")
        self.scene, self.settings = scene, settings
        self.dynamics = Dynamics(scene)
        self.model = self.dynamics.model
        self.gaps, self.held = self.dynamics.gaps, self.dynamics.held
        self.resting = self.dynamics.resting
        self.resting.slow = max(NO_SLIP, settings.capture_speed)
        self.resting.grown = GROWN * self.resting.slow
        # In the whole of the motion they would make less than what counts as no speed at all.
        self.resting.negligible = NO_SPEED / max(settings.duration, 1.0)
        self.t, self.q, self.v = 0.0, q, v
        self.base = np.zeros(0 if self.gaps is None else len(self.gaps.items))
        # Gaps whose points pass through, for their contacts do not count: until they come out.
        self.passing: set[int] = set()
        self.impacts: list[tuple[float, Impact]] = []
        self.rests: list[Rest] = []
        self._names = scene.entry_names("contacts")
        self.soft: dict[int, tuple[int, float]] = {}
        # What compiled code knows of what moves; a flight finds that out.
        self.mover: Mover | None = None
        self.kinks = Kinks(self.dynamics, self.acceleration_at)
        self.kinks.begin(q, v)

    def strike(self, v: np.ndarray) -> None:
        """Set the velocity (nv,) after a jump."""
        self.v = v
        self.kinks.heed_jump(self.q, v)

    def settle(self, *, fresh: bool, lay: bool) -> bool | None:
        """``settling.settle`` by compiled code, of points that are laid down before if asked for.

        None where it can't: q, v and what rests may be changed, by what would be done anyway.

        Raises:
            Stopped: no forces hold what rests.
        """
        if self.mover is None or not self.resting.contacts:
            return None
        with self.told():
            found = self.mover.settle(self.t, self.q, self.v, fresh=fresh, lay=lay)
        if found is None:
            return None
        self.q, self.v, changed = found
        return changed

    def acceleration(self) -> np.ndarray:
        """(nv,) v̇ now; see ``acceleration_at``."""
        return self.acceleration_at(self.t, self.q, self.v)

    def acceleration_at(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """(nv,) v̇ at a time [s] and state.

        Raises:
            Stopped: there is none.
        """
        with self.told():
            return self.dynamics.acceleration(t, q, v)

    def pushing(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """(n,) which points of resting contacts are loaded at another time [s] and state.

        Raises:
            Stopped: no solution.
        """
        self.acceleration_at(t, q, v)
        return self.resting.loaded()

    def left_to_tear(self, t: float, q: np.ndarray, v: np.ndarray, **more: bool) -> np.ndarray:
        """(n,) as ``Resting.left_to_tear``, at another time [s] and state.

        Raises:
            Stopped: no solution.
        """
        with self.resting.held():
            self.acceleration_at(t, q, v)
        return self.resting.left_to_tear(**more)

    def closing(self, i: int) -> float:
        """The rate of a gap that is closed, negative where it closes [m/s]."""
        gaps = self.gaps
        if gaps is None:
            return 0.0
        if gaps.rated[i]:
            return float(gaps.measure(self.q, self.v, (i,))[1][i])
        contact = RestingContact(i, int(gaps.entries[i]), 0.0, self.t)
        speeds = gaps.velocities([contact], self.q, self.v)[2::3]
        return float(speeds.min()) if speeds.size else 0.0

    def approach(self, closing: Collection[int]) -> float:
        """The fastest of gaps that close, positive where it does [m/s]."""
        gaps = self.gaps
        if gaps is not None and gaps.all_rated:
            return float(-gaps.measure(self.q, self.v)[1][list(closing)].min())
        return max(-self.closing(i) for i in closing)

    @property
    def slow(self) -> float:
        """What opens or closes more slowly does neither [m/s]."""
        return max(SLOW_SHARE * self.settings.capture_speed, FAINT * float(np.abs(self.v).max()))

    def note_meeting(self, gap: int, *, soft: bool) -> None:
        """Count a meeting, as ``chatters`` wants it."""
        count, last = self.soft.get(gap, (0, -math.inf))
        if soft and self.t - last <= QUICK:
            self.soft[gap] = count + 1, self.t
        else:
            self.soft[gap] = int(soft), self.t

    def chatters(self, gap: int) -> bool:
        """Whether a gap was met softly again and again: its points lift each other in turn."""
        return self.soft.get(gap, (0, 0.0))[0] >= CHATTER

    def rebase(self) -> None:
        """Let gaps that are closed, or overlap by rounding, count as zero."""
        if self.gaps is not None:
            gap, _ = self.gaps.everything(self.q, self.v)
            self.base = np.minimum(gap, 0.0)
            self.base[sorted(self.passing)] = 0.0

    def let_pass(self, closing: Iterable[int]) -> tuple[int, ...]:
        """Of gaps that close, or open again, now: those that are met; others pass through."""
        gaps, met = self.gaps, []
        for i in closing:
            if gaps is None:
                break
            if i in self.passing:
                self.passing.discard(i)
                self.base[i] = 0.0
            elif gaps.counts(i, self.q, self.v):
                met.append(i)
            else:
                self.passing.add(i)
                self.base[i] = 0.0
        return tuple(met)

    def entry_of(self, gap: int) -> Any:
        """The scene's contact to which a gap belongs."""
        return None if self.gaps is None else self.scene.contacts[self.gaps.entries[gap]]

    def entries_of(self, gaps: Iterable[int]) -> set[int]:
        """The scene's contacts to which gaps belong."""
        return set() if self.gaps is None else {int(self.gaps.entries[i]) for i in gaps}

    def mark(self) -> Mark:
        """What ``go_back`` needs to come back to now."""
        counts = len(self.impacts), len(self.rests)
        return Mark(self.t, self.q.copy(), self.v.copy(), self.resting.contacts, *counts)

    def go_back(self, mark: Mark) -> None:
        """Let what happened since be undone; the motion can be told from there, not go on."""
        self.t, self.q, self.v = mark.t, mark.q, mark.v
        self.resting.contacts = mark.resting
        del self.impacts[mark.impacts :], self.rests[mark.rests :]

    def rest(self, contact: RestingContact, end: float) -> Rest:
        """What is told of a contact that rested until ``end`` [s]."""
        return Rest(self._names[contact.entry], contact.since, end)

    @contextmanager
    def told(self) -> Iterator[None]:
        """Turns what the dynamics and the integrator raise into the end of the motion."""
        try:
            yield
        except StepFailed:
            raise self._failure() from None
        except RestNotSolved as error:
            raise Stopped(MotionStatus.REST_NOT_SOLVED, str(error)) from None
        except ContradictionError as error:
            raise Stopped(MotionStatus.CONTRADICTION, str(error)) from None

    def _failure(self) -> Stopped:
        """Why no step is short enough."""
        try:
            finite = np.isfinite(self.dynamics.acceleration(self.t, self.q, self.v)).all()
        except (ContradictionError, RestNotSolved):
            finite = True
        large = not np.abs(self.v).max(initial=0.0) < HUGE
        status = MotionStatus.STEP_TOO_SMALL if finite and not large else MotionStatus.NOT_FINITE
        return Stopped(status)
