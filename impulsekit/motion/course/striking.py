"""The impacts of a motion: those of the start, and of gaps that close on the way."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable
from dataclasses import replace
from functools import cached_property, partial

import numpy as np

from ...errors import ImpulsekitError
from ...impact import Impact, ImpactSolver
from ...impact.solver import solve_touching
from ...scene import Scene
from ...scene.at_time import is_driven, scene_at
from ...scene.scene import KeptByScene
from ..record.status import MotionStatus
from .present import Present, Stopped

__all__ = ["Striking"]

# Where friction jams a sliding contact it is pressed in by this part of the slip, or of what its
# velocity is the sum of, whichever is more: beyond rounding, and without weight in the answer.
PRESSED, PRESSED_OF_SUM = 1e-12, 1e-14
# A larger part, where several points slide and the law takes the first for rounding error.
PRESSED_MORE = 1e-8
# Where no forces hold what rests, slip below the first is stopped; below the second it counts as
# zero [m/s].
SLOW_SLIP, STRUCK_NO_SLIP = 1e-5, 1e-14
# Nor has slip time to change that friction ends within this time [s].
SOON = 1e-9
# Changes of velocity so many times the pressing are an impact's, and not the pressing's own.
AN_IMPACT = 1e3

# Points that touch and move more slowly against each other lie still [m/s].
STILL = 1e-8


class Striking:
    """Solves the impacts of a motion and changes its velocity by them."""

    def __init__(self, present: Present) -> None:
        self._present = present

    def at_start(self, touching: Iterable[int]) -> None:
        """The scene's impulses strike, and gaps that are closed are met.

        Raises:
            ImpulsekitError: what is wrong with them is the caller's to know.
            Stopped: no valid answer.
        """
        now = self._present
        solver = ImpactSolver(now.scene)
        self._accept(solver.solve_touching(now.q, now.v, now.entries_of(touching)))

    def on_the_way(self, closing: Collection[int], taking_part: Iterable[int]) -> None:
        """Gaps close; others that rest take part.

        Raises:
            Stopped: no valid answer.
        """
        now = self._present
        approach = now.approach(closing)
        items = [] if now.gaps is None else now.gaps.items
        slow = (items[i].capture_speed for i in closing)
        soft = approach < max(now.settings.capture_speed, *slow)
        for i in closing:
            now.note_meeting(i, soft=soft)
        entries = now.entries_of(taking_part)
        solve = self._solver_of(soft)
        try:
            impact = solve(now.q, now.v, entries)
            if not _can_be_followed(impact) and self._lie_still(impact):
                impact = solve(now.q, now.v, entries)
        except ImpulsekitError as error:
            if error.from_function:
                raise
            raise Stopped(MotionStatus.IMPACT_NOT_VALID, str(error)) from None
        self._accept(impact)

    @cached_property
    def _soft(self) -> Scene:
        """For approaches below the capture speed: without restitution."""
        return _soft_scenes.of(self._later)

    def without_collision(self) -> bool:
        """Friction jams what slides at rest, so that no finite force holds it: it is struck.

        Where W_nn ≤ µ W_nt·s no force keeps a sliding contact from being pressed in
        (Painlevé 1895). It stops by an impact without collision (Lecornu 1905; Génot &
        Brogliato 1999): the limit of impacts whose approach goes to zero, without restitution.
        Points that slide below ``SLOW_SLIP`` stop before, and those that friction stops within
        ``SOON``: their directions turn faster than time can tell, and contradict each other where
        bodies rock on each other.

        Returns:
            Whether there was such an impact or slip; if not, nothing has changed.

        Raises:
            Stopped: no valid answer.
        """
        now, gaps = self._present, self._present.gaps
        contacts = now.resting.contacts
        if gaps is None or not contacts:
            return False
        jacobian = gaps.rows(contacts, now.q)
        slip = np.delete(jacobian.dot(now.v), np.s_[2::3])
        normals = jacobian[2::3]
        sums = np.abs(normals).dot(np.abs(now.v))
        fastest = float(np.abs(slip).max(initial=0.0))
        least = PRESSED_OF_SUM * float(sums.max(initial=0.0))
        taking_part = now.entries_of(c.gap for c in contacts)
        if self._stop_slow_slip(jacobian):
            return True
        for share in (PRESSED, PRESSED_MORE):
            pressed = max(share * fastest, least)
            if not pressed > 0.0:
                return False
            approach = normals.dot(now.v) + pressed
            v = now.v + now.dynamics.moved(now.q, normals, -approach)
            try:
                impact = self._solver_of(True)(now.q, v, taking_part)
            except ImpulsekitError as error:
                if error.from_function:
                    raise
                return False
            if np.abs(jacobian.dot(impact.dv)).max() > AN_IMPACT * pressed:
                self._accept(impact)
                return True
        return False

    def _stop_slow_slip(self, jacobian: np.ndarray) -> bool:
        """Stop points that hardly slide; whether there were any."""
        now = self._present
        slip = jacobian.dot(now.v).reshape(-1, 3)
        speeds = np.hypot(slip[:, 0], slip[:, 1])
        rates = now.resting.accelerations.reshape(-1, 3)
        most = np.full(len(speeds), SLOW_SLIP)
        if len(rates) == len(speeds):
            most = np.maximum(most, SOON * np.hypot(rates[:, 0], rates[:, 1]))
        slow = (speeds > 0.0) & (speeds < most)
        if not speeds[slow].max(initial=0.0) > STRUCK_NO_SLIP:
            return False
        # Normals as well: what stops neither parts from the others nor presses into them.
        rows = np.flatnonzero(np.repeat(slow, 3) | (np.arange(slip.size) % 3 == 2))
        now.strike(now.v + now.dynamics.moved(now.q, jacobian[rows], -slip.ravel()[rows]))
        return True

    def _lie_still(self, impact: Impact) -> bool:
        """Let points that lie still but for rounding lie still; whether there were any.

        Restitution looks at what approaches, be it by rounding. Of points that depend on each
        other it would ask what cannot be.
        """
        now, outcome = self._present, impact.outcome
        if outcome is None or not outcome.touches:
            return False
        normals = np.array([touch.jacobian[2] for touch in outcome.touches if touch.turns < 0])
        speeds = normals.dot(now.v)
        still = np.abs(speeds) < STILL
        if not np.abs(speeds[still]).max(initial=0.0) > 0.0:
            return False
        now.strike(now.v + now.dynamics.moved(now.q, normals[still], -speeds[still]))
        return True

    def _solver_of(self, soft: bool) -> Callable[..., Impact]:
        """Of now: where something is driven in time another one for every impact."""
        later = self._later
        if any(map(is_driven, later.constraints)):
            now = scene_at(_without_restitution(later) if soft else later, self._present.t)
            return ImpactSolver(now).solve_touching
        return partial(solve_touching, self._soft if soft else later)

    def _accept(self, impact: Impact) -> None:
        now = self._present
        now.impacts.append((now.t, impact))
        if not _can_be_followed(impact):
            raise Stopped(
                MotionStatus.IMPACT_NOT_VALID,
                f"the impact at {now.t:.9g} s is {impact.describe_status()}",
            )
        now.strike(impact.v_after.copy())

    @cached_property
    def _later(self) -> Scene:
        """The scene of impacts on the way: its impulses struck at the start."""
        scene = self._present.scene
        return _later_scenes.of(scene) if scene.impulses else scene


def _without_restitution(scene: Scene) -> Scene:
    contacts = [replace(entry, restitution=0.0) for entry in scene.contacts]
    return replace(scene, contacts=contacts)


# Made once, so that their solvers serve every motion of a scene.
_later_scenes = KeptByScene(lambda scene: replace(scene, impulses=()))
_soft_scenes = KeptByScene(_without_restitution)


def _can_be_followed(impact: Impact) -> bool:
    """Whether a motion goes on from v⁺; where the law leaves several open, from the one shown."""
    return impact.status.valid
