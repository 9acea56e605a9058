"""``calibrate``: scale, lag, floor and sensor offset of recordings, from free fall and rests."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pinocchio as pin

from ..errors import InputError, RangeError, a_thing
from ..errors.calls import public
from ..formatting import OneLine
from ..robot.robot import with_masses
from ..scene import Scene
from .flight import Flight
from .floor import check_quaternion_order, fitted_floor
from .free_fall import coarse_scale, free_bodies, free_fall, free_root, mass_centres
from .recording import Recording
from .recording_checks import turns_of
from .segments import ROUNDING, flights_with_noise

# Shorter flights determine next to nothing of their acceleration [samples].
SHORTEST = 8
# Samples next to an impact are smeared by filters.
TRIMMED = 1
# Flights are cut as if samples had this noise at least [m; rad]: a mass centre 10 mm off bends
# them by 1 mm in ten samples, an impact of 0.3 m/s by 20.
BENT = (5e-4, 5e-3)
# A flight's own acceleration may be off the common one by so much: else it is a roll or a rest.
OFF = 0.25
# What is off by less than so many of its standard deviations is as well zero.
SURE = 3.0
# Of the table: attributes, their axes, and the unit in which they are shown.
_ROWS = (
    ("length_scale", "", 1.0, ""),
    ("gravity_tilt", "xy", 1e3, "mrad"),
    ("sensor_offset", "xyz", 1e3, "mm"),
    ("mass_centre", "xyz", 1e3, "mm"),
    ("velocity_lag", "", 1e3, "ms"),
    ("floor_height", "", 1e3, "mm"),
    ("floor_tilt", "12", 1e3, "mrad"),
)


@public
@dataclass(frozen=True, eq=False, repr=False)
class Calibration(OneLine):
    """Differences of recordings from the world of a scene, each with its standard deviation.

    Attributes:
        length_scale: recorded lengths over true ones, if times are right: free fall in the
            recordings over the scene's gravity.
        gravity_tilt: (2,) slope of recorded free fall in x and y against the vertical [rad].
        sensor_offset: (3,) of the recorded position against the body's frame, in its axes, from
            bodies that rest on several sides, true lengths [m].
        mass_centre: (3,) by how much the body's mass centre is off the model's, in the same
            axes, from free fall [m]; where rests do not determine the sensor's offset, that
            counts as none.
        velocity_lag: how late recorded velocities are [s]; None without velocities.
        floor_height: of the floor in the recordings above the scene's, true lengths [m].
        floor_tilt: (2,) its slope along the scene's contact axes [rad].
        sigma: by the same names, standard deviations; infinite for what is not determined.
        flights, rests: how many these rest on. recordings: how many have flights.
        notes: what to look at.

    Example:
        >>> import impulsekit as ik
        >>> file = ik.load_scene("examples/cube_tosses.toml")
        >>> tosses = ik.measured.load_recordings("examples/cube_tosses.npz", file.scene.robot)
        >>> found = calibrate(tosses[:6], file.scene)
        >>> abs(found.length_scale - 0.98) < 0.01, abs(found.velocity_lag - 0.5 / 148) < 5e-4
        (True, True)
    """

    length_scale: float
    gravity_tilt: np.ndarray
    sensor_offset: np.ndarray
    mass_centre: np.ndarray
    velocity_lag: float | None
    floor_height: float
    floor_tilt: np.ndarray
    sigma: dict[str, Any] = field(repr=False)
    flights: int
    rests: int
    notes: tuple[str, ...] = ()
    recordings: int = 0
    _plane: tuple[np.ndarray, np.ndarray] | None = field(default=None, repr=False)

    def intervals(self, level: float = 0.95) -> dict[str, np.ndarray]:
        """Return (2,) or (2, n) ends by name; NaN for what is not determined.

        Deviations are of few recordings (jackknife), so that Student's quantiles hold where free
        fall determines a value. Floor and sensor offset have several unknowns for few rests, which
        makes a jackknife's deviation larger (Efron & Stein 1981): normal quantiles hold there.

        Raises:
            RangeError: the level is not between 0 and 1.
        """
        from scipy import stats

        if not 0.0 < level < 1.0:
            raise RangeError.of("level", level, "between 0 and 1")
        tail, found = 0.5 * (1.0 - level), {}
        for name, sigma in self.sigma.items():
            if sigma is None:
                continue
            by_rests = name in ("floor_height", "floor_tilt", "sensor_offset")
            normal = by_rests or self.recordings < 2
            factor = stats.norm.isf(tail) if normal else stats.t.isf(tail, self.recordings - 1)
            reach = factor * np.where(np.isfinite(sigma), sigma, np.nan)
            value = np.array(getattr(self, name))
            found[name] = np.array([value - reach, value + reach])
        return found

    def apply(self, recording: Recording) -> Recording:
        """Return the recording in the world of the scene: true lengths, the floor in its place.

        The sensor offset and the floor's tilt are taken off where they are three times their
        standard deviation or more; velocities are taken at times later by their lag. All free
        bodies are moved alike.

        Raises:
            InputError: the robot's root is no free-flyer.
        """
        model = recording.robot.model
        free = [model.joints[joint] for joint in free_bodies(recording.robot)]
        q = recording.q.copy()
        v = None if recording.v is None else self._timely(recording, free)
        turn, shift, offset = self._motion()
        for row in q:
            for start in (joint.idx_q for joint in free):
                place, attitude = row[start : start + 3], row[start + 3 : start + 7]
                axes = pin.Quaternion(np.array(attitude)).matrix()
                place[:] = turn @ (place / self.length_scale - axes @ offset) + shift
                turned = pin.Quaternion(turn @ axes).coeffs()
                attitude[:] = turned if turned @ attitude > 0 else -turned
        sigma = recording.sigma
        if sigma is not None:
            sigma = np.broadcast_to(sigma, (model.nv,)).copy()
            for joint in free:
                sigma[joint.idx_v : joint.idx_v + 3] /= self.length_scale
        return replace(recording, q=q, v=v, sigma=sigma)

    def _timely(self, recording: Recording, free: Sequence[Any]) -> np.ndarray:
        """Return (T, nv) velocities at the times of the samples, true lengths.

        Linear ones are shifted in the world, since the axes of bodies turn.
        """
        late = recording.t + (self.velocity_lag or 0.0)
        v = np.stack([np.interp(late, recording.t, column) for column in recording.v.T], axis=1)
        for joint in free:
            attitudes = recording.q[:, joint.idx_q + 3 : joint.idx_q + 7]
            turns = turns_of(attitudes)
            own = slice(joint.idx_v, joint.idx_v + 3)
            world = np.einsum("tij,tj->ti", turns, recording.v[:, own])
            world = np.stack([np.interp(late, recording.t, column) for column in world.T], axis=1)
            v[:, own] = np.einsum("tji,tj->ti", turns, world) / self.length_scale
        return v

    def scene(self, scene: Scene) -> Scene:
        """Return the scene with the body's mass centre where free fall puts it, if it is sure.

        The inertia about the mass centre stays as it is.

        Raises:
            InputError: the robot's root is no free-flyer.
        """
        from scipy import stats

        # As improbable as three deviations of a normal distribution are.
        chance = stats.norm.sf(SURE)
        factor = stats.t.isf(chance, self.recordings - 1) if self.recordings > 1 else SURE
        sure = _is_sure(self.mass_centre, self.sigma["mass_centre"] * factor / SURE)
        if not sure.any():
            return scene
        return _with_mass_centre(scene, np.where(sure, self.mass_centre, 0.0))

    def _motion(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return rotation and shift in true lengths, and the sensor offset, if they are sure."""
        sure = _is_sure(self.sensor_offset, self.sigma["sensor_offset"])
        offset = np.where(sure, self.sensor_offset, 0.0)
        if self._plane is None or not np.isfinite(self.sigma["floor_height"]):
            return np.eye(3), np.zeros(3), offset
        axes, origin = self._plane
        tilt = self.floor_tilt
        if not _is_sure(tilt, self.sigma["floor_tilt"]).any():
            tilt = np.zeros(2)
        # The recorded floor's normal is n - a t1 - b t2; it is turned onto n about the origin.
        turn = pin.exp3(-axes @ np.array([tilt[1], -tilt[0], 0.0]))
        shift = origin - turn @ origin - self.floor_height * axes[:, 2]
        return turn, shift, offset

    def __str__(self) -> str:
        lines = [f"from {self.flights} flights and {self.rests} rests"]
        unknown = []
        for name, axes, factor, unit in _ROWS:
            values, deviations = getattr(self, name), self.sigma[name]
            if values is None:
                continue
            if not np.isfinite(deviations).any():
                unknown.append(name.replace("_", " "))
                continue
            own = zip(axes or ("",), np.atleast_1d(values), np.atleast_1d(deviations), strict=True)
            for axis, value, deviation in own:
                title = f"{name.replace('_', ' ')} {axis}".strip()
                if np.isfinite(deviation):
                    text = f"{value * factor:10.4g} ± {deviation * factor:.2g} {unit}".rstrip()
                    lines.append(f"{title:16} {text}")
                else:
                    unknown.append(title)
        if unknown:
            lines.append(f"not determined: {', '.join(unknown)}")
        return "\n".join([*lines, *(f"note: {note}" for note in self.notes)])


@public
def calibrate(recordings: Recording | Sequence[Recording], scene: Scene) -> Calibration:
    """Find how recordings of a free body or robot differ from the world of a scene.

    Free fall gives the scale of lengths, the vertical, the lag of recorded velocities and where the
    recorded point is on the body: c(t) = c₀ + v₀ t + a t²/2 + R(t) d by least squares over
    all flights. Bodies at rest determine the floor.

    Args:
        recordings: of a robot whose root is a free-flyer, in flight for eight samples or more.
        scene: its gravity, and the contacts with one plane of the world.

    Raises:
        InputError: no free fall, units or an order of quaternions that are mistaken, a root that
            is no free-flyer.

    Example:
        >>> import impulsekit as ik
        >>> ball = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
        >>> scene = ik.Scene(ball, gravity=[0, 0, -9.81])
        >>> t = np.arange(40) / 100
        >>> q = np.zeros((40, 7)) + [0, 0, 0, 0, 0, 0, 1]
        >>> shrunk = []
        >>> for speed in (1.0, 1.5):
        ...     q[:, 2] = 0.9 * (1 + speed * t - 0.5 * 9.81 * t**2)
        ...     shrunk.append(Recording(ball, t, q))
        >>> round(calibrate(shrunk, scene).length_scale, 6)
        0.9
    """
    several = [recordings] if isinstance(recordings, Recording) else list(recordings)
    if not isinstance(scene, Scene) or not all(isinstance(r, Recording) for r in several):
        given = f"{a_thing(recordings)} and {a_thing(scene)}"
        raise InputError(f"calibrate takes Recordings and a Scene, got {given}")
    gravity = np.array(scene.gravity)
    size = float(np.linalg.norm(gravity))
    if not several or not size > 0.0:
        raise InputError("calibrate needs one recording or more, and a scene with gravity")
    scale = coarse_scale(several, gravity)
    check_quaternion_order(several, scene, "calibrate")
    # A mass centre that is off bends flights: first only impacts are to end them, then noise.
    flights = _flights(several, scene, scale * gravity, BENT)
    if flights:
        fall = free_fall([flight[:4] for flight in flights])
        bent = _with_mass_centre(scene, -fall.offset) if fall.offset.any() else scene
        flights = _flights(several, bent, fall.acceleration, (ROUNDING, ROUNDING)) or flights
    if not flights:
        raise InputError(
            f"calibrate: no flight of {SHORTEST} samples or more in the recordings; record at a "
            "higher rate or from a greater height"
        )
    fall = free_fall([flight[:4] for flight in flights])
    along = -gravity / size
    scale = float(np.linalg.norm(fall.acceleration)) / size
    axes = _axes(along)
    spread = fall.covariance[:3, :3]
    tilt = axes[:, :2].T @ fall.acceleration / (scale * size)
    lag = _lag(several, flights, fall.acceleration)
    floor = fitted_floor(several, scene, scale)
    # What rests do not determine for sure is taken for the mass centre's, not for the sensor's.
    sure = _is_sure(floor.values[3:], floor.sigma[3:])
    own = np.where(sure, floor.values[3:], 0.0)
    notes = list(floor.notes)
    if len(several) < 2:
        notes.append("one recording alone determines no uncertainty; give several")
    sigma = {
        "length_scale": _deviation(along, spread) / size,
        "gravity_tilt": np.array([_deviation(axis, spread) for axis in axes[:, :2].T])
        / (scale * size),
        "sensor_offset": floor.sigma[3:],
        "mass_centre": np.hypot(
            np.where(sure, floor.sigma[3:], 0.0),
            np.sqrt(np.diagonal(fall.covariance)[3:]) / scale,
        ),
        "velocity_lag": None if lag is None else lag[1],
        "floor_height": floor.sigma[0],
        "floor_tilt": floor.sigma[1:3],
    }
    return Calibration(
        scale, tilt, floor.values[3:], own - fall.offset / scale, None if lag is None else lag[0],
        float(floor.values[0]), floor.values[1:3], sigma, len(flights), floor.rests,
        tuple(notes), len({flight[0] for flight in flights}), floor.plane,
    )  # fmt: skip


def _with_mass_centre(scene: Scene, shift: np.ndarray) -> Scene:
    """Return the scene with the mass centre of all shifted in the axes of its free root body."""
    model = pin.Model(scene.robot.model)
    root = free_root(scene.robot)
    own = model.inertias[root]
    lever = own.lever + shift * (pin.computeTotalMass(model) / own.mass)
    model.inertias[root] = pin.Inertia(own.mass, lever, own.inertia)
    return replace(scene, robot=with_masses(scene.robot, model))


def _deviation(way: np.ndarray, covariance: np.ndarray) -> float:
    """Return the standard deviation along a direction; infinite if one of its variances is."""
    counts = np.outer(way, way) != 0.0
    if not np.isfinite(covariance[counts]).all():
        return np.inf
    return float(np.sqrt(np.sum(np.outer(way, way)[counts] * covariance[counts])))


def _is_sure(value: np.ndarray, deviation: np.ndarray) -> np.ndarray:
    return np.isfinite(deviation) & (np.abs(value) >= SURE * np.asarray(deviation))


def _axes(up: np.ndarray) -> np.ndarray:
    """Return (3, 3) two horizontal axes, x and y where up is z, and up."""
    turn = pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), up).matrix()
    return np.array(turn)


def _flights(
    several: list[Recording], scene: Scene, gravity: np.ndarray, least_noise: tuple[float, float]
) -> list[tuple]:
    """Return flights long enough: number of the recording, times, mass centres, axes, samples.

    Args:
        gravity: (3,) as the recordings show it.
        least_noise: of positions and of angles, which flights are cut with at least.
    """
    flight = Flight(replace(scene, gravity=tuple(gravity.tolist())))
    least = np.full(flight.model.nv, least_noise[1])
    least[:3] = least_noise[0]
    # The mass centre may be off, the floor near: flights are cut with patience.
    cut_with_noise = flights_with_noise(flight, several, least)
    if cut_with_noise is None:
        return []
    found = []
    for number, (recording, cut) in enumerate(zip(several, cut_with_noise[1], strict=True)):
        centres, axes = mass_centres(recording)
        for samples in cut.flights:
            own = samples[TRIMMED : len(samples) - TRIMMED]
            if len(own) < SHORTEST:
                continue
            tau = recording.t[own] - recording.t[own].mean()
            powers = np.stack([np.ones(len(own)), tau, 0.5 * tau**2], axis=1)
            fit = np.linalg.lstsq(powers, centres[own], rcond=None)[0]
            if np.linalg.norm(fit[2] - gravity) <= OFF * np.linalg.norm(gravity):
                found.append((number, recording.t[own], centres[own], axes[own], own))
    return found


def _lag(
    several: list[Recording], flights: list[tuple], acceleration: np.ndarray
) -> tuple[float, float] | None:
    """Return the lag of recorded velocities of the mass centre, and its deviation [s]."""
    by_recording: dict[int, list[float]] = {}
    for number, t, centres, _, own in flights:
        recording = several[number]
        if recording.v is None:
            continue
        model = recording.robot.model
        data = model.createData()
        tau = t - t.mean()
        start = (centres - 0.5 * np.outer(tau**2, acceleration)).T @ np.stack(
            [np.ones(len(t)), tau], axis=1
        )
        slope = start @ np.linalg.inv(np.array([[len(t), 0.0], [0.0, tau @ tau]]))[:, 1]
        for time, k in zip(tau, own, strict=True):
            pin.centerOfMass(model, data, np.array(recording.q[k]), np.array(recording.v[k]))
            late = slope + acceleration * time - data.vcom[0]
            by_recording.setdefault(number, []).append(
                float(late @ acceleration / (acceleration @ acceleration))
            )
    if not by_recording:
        return None
    means = np.array([np.median(each) for each in by_recording.values()])
    deviation = means.std(ddof=1) / np.sqrt(len(means)) if len(means) > 1 else np.inf
    return float(means.mean()), float(deviation)
