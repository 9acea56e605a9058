"""``find_impacts``: times, contacts and states of the impacts in recordings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from ..design.parameters import checked_sigma
from ..errors import InputError, RangeError, check_kind
from ..errors.calls import public
from ..robot.arrays import lock
from ..scene import Scene
from .active_contacts import ClosingContacts
from .flight import Flight, is_smooth
from .floor import check_quaternion_order
from .found_impacts import FoundImpact, FoundImpacts
from .free_fall import has_one_free_body, length_unit
from .recording import Recording, as_recordings
from .recording_checks import check_steps, checked_velocities
from .segments import (
    MEDIAN_TO_SIGMA,
    Kink,
    Segments,
    find_segments,
    flights_with_noise,
    meeting_of,
)

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

# Flights are fitted to so many samples on either side at most.
MOST_SAMPLES = 12
# Probability that noise alone makes a jump as large; and that flights that do meet are as far
# apart (between them lies more than one impact).
FALSE_JUMP, FALSE_MEETING = 1e-4, 1e-5
# Probability that noise alone leaves a flight's residuals as large: else it is no flight.
FALSE_FLIGHT = 1e-4
# Probability that noise alone puts the contact of an impact as far from the median gap of all
# impacts: flights that meet too deep or too high have more than one impact between them.
FALSE_GAP = 1e-4
# Fewer impacts do not determine the median gap.
FEWEST_GAPS = 8
# Flights of no more samples may be pieces of a slide.
SHORT = 4
# Flights with more samples missing between them do not meet: something else lies there.
MOST_MISSED = 3
# Recordings whose free fall is looked at for the unit of lengths; one scene's are alike.
MOST_LOOKED_AT = 8
# Rounds in which samples change flights, by the times of the impacts.
RECUTS = 2


@public
def find_impacts(
    recordings: Recording | Sequence[Recording],
    scene: Scene,
    *,
    sigma: ArrayLike | None = None,
    near: float = 0.015,
) -> FoundImpacts:
    """Find the impacts in recordings, with the states before and after and their covariance.

    Each recording is cut into flights, which obey the scene's forces and gravity without
    contacts; where two meet, both are fitted to the samples on their side and followed to their
    common time. Recorded velocities are not used: they smear over an impact. Which contacts
    closed is read from gaps and from the jump: M (v⁺ − v⁻) = Jᵀ P at the fewest contacts.

    Args:
        recordings: one or more, in the world of the scene; see ``calibrate``.
        scene: its robot, contacts, forces and gravity.
        sigma: (nv,) or one number, noise of the samples on their tangents [m, rad]; by default
            the recordings' own, or estimated from what fits to flights leave.
        near: contacts with a larger gap at the impact took no part [m].

    Returns:
        The impacts with at least two samples of flight on both sides; gaps between flights,
        jumps among them whose contact is off where eight or more impacts have it (bounces between
        samples); samples that stand apart.

    Raises:
        InputError: no recording, another robot, samples too few to estimate their noise; lengths
            in mm or cm, by free fall; quaternions in the other order, by contacts under the floor.
        RangeError, ShapeError: what is wrong with ``sigma``, ``near`` or the times of samples.

    Example:
        >>> import impulsekit as ik
        >>> ball = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
        >>> floor = ik.Contact("ball", at=[0, 0, -0.05], restitution=0.6, name="floor")
        >>> scene = ik.Scene(ball, contacts=[floor], gravity=[0, 0, -9.81])
        >>> drop = ball.configuration(root_joint=[0, 0, 0.5, 0, 0, 0, 1])
        >>> motion = ik.simulate(scene, drop, [0] * 6, duration=0.6, samples=61)
        >>> found = find_impacts(Recording(ball, motion.t, motion.q), scene, sigma=1e-6)
        >>> round(found.impacts[0].time, 5), found.impacts[0].contacts
        (0.30289, ('floor',))
    """
    several = as_recordings(recordings, "find_impacts")
    _check(several, scene, near)
    nv = scene.robot.nv
    _check_readings(several, scene)
    noise = _given_sigma(sigma, several, nv)
    flight, notes = Flight(scene), list[str]()
    if noise is None:
        estimated = flights_with_noise(flight, several)
        if estimated is None:
            raise InputError(
                "find_impacts: the recordings are too short to estimate their noise; give sigma"
            )
        noise = estimated[0]
    detector = _Detector(flight, ClosingContacts(scene), noise, near)
    impacts, phases, outliers = detector.of_all(several)
    impacts, merged = _off_their_contacts(detector.closing, impacts)
    if merged:
        notes.append(
            f"{len(merged)} jumps lie off the floor of the other impacts: more than one impact "
            "each, too close together for the samples; they count as gaps between flights"
        )
        phases = sorted(phases + merged)
    if not impacts:
        notes.append("no impact with flight on both sides was found")
    far = sum(not each.contacts for each in impacts)
    if far:
        notes.append(
            f"{far} of {len(impacts)} jumps happen with no contact within {near:g} m: the floor, "
            "the scale or the contacts of the scene may be off; calibrate first"
        )
    noise.setflags(write=False)
    return FoundImpacts(tuple(impacts), tuple(phases), tuple(outliers), noise, tuple(notes))


@dataclass(frozen=True, eq=False)
class _Detector:
    """Impacts of recordings, by flights that meet.

    Attributes:
        flight, closing: of the scene. sigma: (nv,) noise. near: as for ``find_impacts``.
    """

    flight: Flight
    closing: ClosingContacts
    sigma: np.ndarray
    near: float

    def of_all(
        self, several: Sequence[Recording]
    ) -> tuple[list[FoundImpact], list[tuple[str, float, float]], list[tuple[str, float]]]:
        """Return impacts, phases and outliers of all recordings."""
        impacts: list[FoundImpact] = []
        phases: list[tuple[str, float, float]] = []
        outliers: list[tuple[str, float]] = []
        for recording in several:
            cut = find_segments(self.flight, recording.t, recording.q, self.sigma)
            outliers += [(recording.name, float(recording.t[k])) for k in cut.outliers]
            own_impacts, own_phases = self._of_one(recording, cut)
            impacts += own_impacts
            phases += own_phases
        return impacts, phases, outliers

    def _of_one(
        self, recording: Recording, cut: Segments
    ) -> tuple[list[FoundImpact], list[tuple[str, float, float]]]:
        from scipy import stats

        nv = self.flight.model.nv
        least_jump = float(stats.chi2.isf(FALSE_JUMP, nv))
        most_opening = float(stats.chi2.isf(FALSE_MEETING, max(nv - 1, 1)))
        t, q = recording.t, recording.q
        impacts, phases = [], []
        flights = cut.flights
        known: dict[tuple[bytes, bytes], Any] = {}
        for _ in range(RECUTS):
            flights = _cut_at(flights, self._meetings(t, q, flights, known))
        meetings = self._meetings(t, q, flights, known)
        for left, right, found in zip(flights[:-1], flights[1:], meetings, strict=True):
            if found is None or found[0].opening > most_opening or not _fly(found[0]):
                phases.append((recording.name, float(t[left[-1]]), float(t[right[0]])))
                continue
            kink, (before, after) = found
            if kink.jump < least_jump or self._is_smooth(t, q, found):
                continue
            impacts.append(self._impact(recording.name, kink, (len(before), len(after))))
        return impacts, phases

    def _meetings(
        self,
        t: np.ndarray,
        q: np.ndarray,
        flights: list[np.ndarray],
        known: dict[tuple[bytes, bytes], Any],
    ) -> list[Any]:
        """Return the meeting of each flight with the next; None if far apart, or short and smooth.

        ``known``: what was found for two flights, by their samples.
        """
        found: list[Any] = []
        for left, right in pairwise(flights):
            key = left.tobytes(), right.tobytes()
            if key not in known:
                sides = left[-MOST_SAMPLES:], right[:MOST_SAMPLES]
                meeting = None
                if right[0] - left[-1] <= MOST_MISSED:
                    meeting = meeting_of(self.flight, t, q, sides, self.sigma)
                # Pieces of what slides or rolls; longer flights may have ended late and be cut
                # again.
                short = max(len(left), len(right)) <= SHORT
                if meeting is not None and short and self._is_smooth(t, q, meeting):
                    meeting = None
                known[key] = meeting
            found.append(known[key])
        return found

    def _is_smooth(self, t: np.ndarray, q: np.ndarray, meeting: Any) -> bool:
        kink, sides = meeting
        return is_smooth(self.flight, t, q, np.concatenate(sides), self.sigma, kink.cost)

    def _impact(self, recording: str, kink: Kink, samples: tuple[int, int]) -> FoundImpact:
        nv = len(kink.before)
        none, one = np.zeros((nv, nv)), np.eye(nv)
        to_jump = np.block([[one, none, none], [none, -one, one]])
        spread = to_jump @ kink.covariance @ to_jump.T
        jump = kink.after - kink.before
        names, gaps, impulses, balance = self.closing.of_jump(
            kink.q, jump, spread, kink.before, self.near
        )
        lock(kink.q, kink.before, kink.after, kink.covariance, gaps, impulses)
        return FoundImpact(
            recording, kink.time, kink.time_sigma, kink.q, kink.before, kink.after,
            kink.covariance, names, gaps, impulses, balance, samples,
        )  # fmt: skip


def _off_their_contacts(
    closing: ClosingContacts, impacts: list[FoundImpact]
) -> tuple[list[FoundImpact], list[tuple[str, float, float]]]:
    """Return the impacts, and phases in place of those whose gap is far from the median of all.

    A bounce between samples bends both flights: they meet below the floor. Median and spread of
    the gaps are robust estimates from all impacts.
    """
    from scipy import stats

    near = [each for each in impacts if each.contacts]
    nv = len(impacts[0].v_before) if impacts else 0
    found = [closing.nearest(i.q, i.v_before, i.covariance[:nv, :nv]) for i in near]
    measured = [(each, *gap) for each, gap in zip(near, found, strict=True) if gap is not None]
    if len(measured) < FEWEST_GAPS:
        return impacts, []
    gaps, sigmas = np.array([each[1:] for each in measured]).T
    middle = float(np.median(gaps))
    spread = float(np.median(np.abs(gaps - middle))) / MEDIAN_TO_SIGMA
    own = max(spread**2 - float(np.median(sigmas)) ** 2, 0.0)
    far = np.abs(gaps - middle) > stats.norm.isf(0.5 * FALSE_GAP) * np.sqrt(own + sigmas**2)
    lost = [each for (each, *_), off in zip(measured, far.tolist(), strict=True) if off]
    phases = [
        (each.recording, each.time - each.time_sigma, each.time + each.time_sigma) for each in lost
    ]
    return [each for each in impacts if not any(each is other for other in lost)], phases


def _cut_at(flights: list[np.ndarray], meetings: list[Any]) -> list[np.ndarray]:
    """Return the flights with each sample on the side of an impact on which the time found puts it.

    A flight is known to have ended one or two samples late; these belong to the next one, and
    spoil its meeting with the one after it until they are there.
    """
    found = [np.array(each) for each in flights]
    for k, meeting in enumerate(meetings):
        if meeting is None:
            continue
        _, (_, right) = meeting
        ours = np.concatenate([found[k], found[k + 1]])
        cut = right[0]
        if (ours < cut).sum() >= 2 and (ours >= cut).sum() >= 2:
            found[k], found[k + 1] = ours[ours < cut], ours[ours >= cut]
    return found


def _fly(kink: Kink) -> bool:
    """Return whether both sides are flights: bodies that roll or slide fall otherwise."""
    from scipy import stats

    return all(
        freedom <= 0 or stats.chi2.sf(squares, freedom) >= FALSE_FLIGHT
        for squares, freedom in kink.misfit
    )


def _check(several: list[Any], scene: Any, near: float) -> None:
    check_kind(scene, Scene, "find_impacts")
    if not several:
        raise InputError("find_impacts: no recordings; give one or more")
    for each in several:
        if each.robot.nq != scene.robot.nq or each.robot.nv != scene.robot.nv:
            raise InputError(
                f"find_impacts: recording {each.name or 'given'} is of another robot than the scene"
            )
        check_steps(each.t, each.name or "given")
    if not (np.isfinite(near) and near > 0.0):
        raise RangeError.of("find_impacts: near", near, "above 0 m")


def _check_readings(several: list[Recording], scene: Scene) -> None:
    """Check units of lengths and orders of quaternions, by what free bodies do."""
    looked_at = several[:: max(1, len(several) // MOST_LOOKED_AT)]
    for each in looked_at:
        where = f"find_impacts: recording {each.name or 'given'}"
        checked_velocities(each.robot, each.t, each.q, each.v, where, [])
    if not has_one_free_body(scene.robot):
        return
    gravity = np.array(scene.gravity)
    words = length_unit(looked_at, gravity) if gravity.any() else None
    if words is not None:
        raise InputError(f"find_impacts: {words}")
    check_quaternion_order(several, scene, "find_impacts")


def _given_sigma(sigma: Any, several: list[Recording], nv: int) -> np.ndarray | None:
    if sigma is None:
        given = [each.sigma for each in several]
        if any(each is None for each in given):
            return None
        return np.sqrt(np.mean([np.broadcast_to(each, (nv,)) ** 2 for each in given], axis=0))
    return np.array(np.broadcast_to(checked_sigma(sigma, nv, "find_impacts: sigma"), (nv,)))
