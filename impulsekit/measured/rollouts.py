"""Motions from the first state of each recording, and how far they end up from it."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from typing import Any

import numpy as np
import pinocchio as pin

from ..batch.inputs import batch_inputs
from ..batch.motions.row import RowResult, follow_rows
from ..errors import InputError
from ..motion.record.comparing import frame_distances, moving_links
from ..motion.record.status import MotionStatus
from ..scene import Scene
from ..scene.motion import MotionSettings
from .flight import Flight
from .recording import Recording
from .segments import find_segments, flights_with_noise

# For fits: errors of some 1e-4 of the way, a hundredth of what a recording and the best law
# differ by, at a fifth of the time.
QUICK = MotionSettings(rtol=1e-4, atol=1e-6, capture_speed=1e-3, together=1e-5)
# Of a first flight so many samples determine the state at its start; the last one may be smeared.
MOST_SAMPLES = 25


# A configuration (nq,) and a velocity (nv,).
State = tuple[np.ndarray, np.ndarray]


def starts_of(recordings: Sequence[Recording], scene: Scene) -> list[State]:
    """Return the state of each recording at its first sample, by a fit to its first flight.

    Samples after the first impact take no part. Recordings that begin in contact begin with the
    slope of their first samples.
    """
    flight = Flight(scene)
    sigmas = [each.sigma for each in recordings if each.sigma is not None]
    nv = flight.model.nv
    if len(sigmas) < len(recordings):
        found = flights_with_noise(flight, recordings)
        sigma, cuts = found or (np.ones(nv), [])
    else:
        sigma = np.mean([np.broadcast_to(each, (nv,)) for each in sigmas], axis=0)
        cuts = [find_segments(flight, each.t, each.q, sigma) for each in recordings]
    starts = []
    for number, recording in enumerate(recordings):
        t, q = recording.t, recording.q
        if len(t) < 3:
            raise InputError(f"recording {recording.name or 'given'} has fewer than 3 samples")
        flights = cuts[number].flights if cuts else []
        own = flights[0] if flights and flights[0][0] == 0 else np.arange(3)
        own = own[:MOST_SAMPLES]
        if len(own) > 4:
            own = own[:-1]
        v = pin.difference(flight.model, q[0], q[own[2]]) / (t[own[2]] - t[0])
        fit = flight.fit(t[own], q[own], float(t[0]), q[0], v, sigma)
        starts.append((fit.q, fit.v))
    return starts


class Rollouts:
    """Recordings, the states they begin with, and motions from there.

    Args:
        recordings: what is followed.
        scene: for the first flights; coefficients do not matter there.
        settings: of the motions.
        threads: how many; None for all cores.
    """

    def __init__(
        self,
        recordings: Sequence[Recording],
        scene: Scene,
        settings: MotionSettings = QUICK,
        threads: int | None = None,
    ) -> None:
        self.recordings = tuple(recordings)
        self.starts = starts_of(recordings, scene)
        self.links = moving_links(scene.robot)
        self._settings, self._threads = settings, threads

    def with_settings(self, **changed: Any) -> Rollouts:
        """Return the same with other settings of the motions."""
        found = copy(self)
        found._settings = self._settings.changed(**changed)
        return found

    def rows(
        self,
        scene: Scene,
        which: Sequence[int],
        *,
        starts: Sequence[State] | None = None,
    ) -> list[Any]:
        """Return the motions of some recordings, as ``follow_rows`` gives them.

        Args:
            starts: in place of the first states of these recordings.
        """
        rows: list[Any] = []
        for i, k in enumerate(which):
            start, recording = (starts or self.starts)[i if starts else k], self.recordings[k]
            times = recording.t - recording.t[0]
            settings = self._settings.changed(duration=float(times[-1]), samples=len(times))
            inputs = batch_inputs(scene, *start)
            rows.append((inputs, 0, settings, times))
        # Long ones first, so that no thread waits for the last.
        order = sorted(range(len(rows)), key=lambda k: -len(rows[k][3]))
        found: list[Any] = [None] * len(rows)

        def take(index: int, row: RowResult) -> None:
            found[order[index]] = row

        if not follow_rows(scene, [rows[k] for k in order], self._threads, take):
            raise KeyboardInterrupt
        return found

    def errors(self, scene: Scene, which: Sequence[int] | None = None) -> np.ndarray:
        """Return (K, 2) mean distance [m] and angle [rad] over each recording and all links.

        NaN where a motion does not come to its end.
        """
        chosen = range(len(self.recordings)) if which is None else which
        found = np.full((len(chosen), 2), np.nan)
        for i, (k, row) in enumerate(zip(chosen, self.rows(scene, chosen), strict=True)):
            if row is None or row.status is not MotionStatus.FINISHED:
                continue
            far = [
                frame_distances(scene.robot, link, row.q, self.recordings[k].q)
                for link in self.links
            ]
            found[i] = np.mean(far, axis=(0, 2))
        return found
