"""Impacts found in a recording: when, at which contacts, the states on both sides."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from math import ceil, log2
from typing import Any

import numpy as np
import pinocchio as pin

from ..design.fit import Measurement
from ..errors.calls import public
from ..formatting import OneLine, one_line
from ..impact.flat.scene import flat_scene
from ..rows.bodies import bodies_of
from ..scene import Collision, GapContact, JointStop, Rope, Scene

# Steps of Newton: gaps of noise are small against what curves them, and two or three do.
MOST_STEPS = 20
# Gaps up to this [m] are none.
CLOSED = 1e-9


def at_touch(
    scene: Scene, names: Sequence[str], q: np.ndarray, covariance: np.ndarray
) -> np.ndarray:
    """Return the (nq,) configuration where contacts touch that closed and noise left apart.

    Joints go to the limits that they hit. For a ``Rope`` and a ``GapContact`` it is the likeliest
    configuration without a gap g: δ = −C nᵀ (n C nᵀ)⁻¹ g, n the gradient of g, until g is 0. A
    ``Contact`` touches whatever its gap, and a ``Collision`` up to its margin: these move nothing.

    Args:
        names: of the contacts that closed.
        q: (nq,) as measured. covariance: (nv, nv) of it on its tangent.
    """
    q, model = q.copy(), scene.robot.model
    closed = []
    for k, (name, entry) in enumerate(
        zip(scene.entry_names("contacts"), scene.contacts, strict=True)
    ):
        if name not in names:
            continue
        if isinstance(entry, JointStop):
            at = model.joints[scene.robot.joint_id(entry.joint)].idx_q
            lower, upper = entry.limits(scene.robot)
            near_upper = upper - q[at] < q[at] - lower
            q[at] = max(q[at], upper) if near_upper else min(q[at], lower)
        elif isinstance(entry, Rope | GapContact):
            closed.append(k)
    if not closed:
        return q
    flat, at_rest = flat_scene(scene), np.zeros(model.nv)
    only = [k in closed for k in range(len(scene.contacts))]
    apart: np.ndarray | None = None
    for _ in range(MOST_STEPS):
        rows = flat.rows(q, at_rest, only=only)
        gaps = rows.gaps
        apart = gaps > CLOSED if apart is None else apart
        if np.abs(gaps[apart]).max(initial=0.0) <= CLOSED:
            break
        normals = rows.J.reshape(-1, 3, model.nv)[: len(gaps), 2][apart]
        spread = covariance @ normals.T
        q = pin.integrate(model, q, -spread @ np.linalg.lstsq(normals @ spread, gaps[apart])[0])
    return q


# What meets, by how many contacts close at once: group of a measurement.
WHAT_MEETS = {1: "point", 2: "edge"}


@public
@dataclass(frozen=True, eq=False, repr=False)
class FoundImpact(OneLine):
    """An impact in a recording, with flights fitted on both sides. Arrays are read-only.

    Attributes:
        recording: the name of the recording.
        time: [s]. time_sigma: its standard deviation [s].
        q: (nq,) the configuration at that time, common to both flights.
        v_before, v_after: (nv,) where the flights end and begin.
        covariance: (3 nv, 3 nv) of (q on its tangent, v_before, v_after).
        contacts: names of the contacts that close, by momentum the fewest that explain the
            jump; empty if none is near.
        gaps: of these at ``q`` [m].
        impulses: (k, 3) at these, world axes [N s], by least squares on the jump.
        balance: probability that noise leaves as much of the jump's momentum as no impulse
            at these contacts explains; a small one means a wrong contact, mass or inertia.
        samples: how many samples there are on each side.

    Example:
        >>> import impulsekit as ik
        >>> ball = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
        >>> floor = ik.Contact("ball", at=[0, 0, -0.05], restitution=0.6, name="floor")
        >>> scene = ik.Scene(ball, contacts=[floor], gravity=[0, 0, -9.81])
        >>> drop = ball.configuration(root_joint=[0, 0, 0.5, 0, 0, 0, 1])
        >>> motion = ik.simulate(scene, drop, [0] * 6, duration=0.6, samples=61)
        >>> recording = ik.measured.Recording(ball, motion.t, motion.q)
        >>> found = ik.measured.find_impacts(recording, scene, sigma=1e-6)
        >>> hit = found.impacts[0]
        >>> hit.contacts, round(float(hit.v_after[2] / -hit.v_before[2]), 3)
        (('floor',), 0.6)
    """

    recording: str
    time: float
    time_sigma: float
    q: np.ndarray
    v_before: np.ndarray
    v_after: np.ndarray
    covariance: np.ndarray = field(repr=False)
    contacts: tuple[str, ...]
    gaps: np.ndarray = field(repr=False)
    impulses: np.ndarray = field(repr=False)
    balance: float
    samples: tuple[int, int]

    def margins(self) -> tuple[float, ...]:
        """Return the gap of each contact that noise leaves to what touches, rounded up [m]."""
        return tuple(_margin(float(gap)) for gap in self.gaps)

    def measurement(self, scene: Scene) -> Measurement:
        """Return the impact as ``fit_impacts`` takes it: the scene with these contacts alone.

        Its group is "point", "edge" or "face", where one, two or more contacts close.

        Raises:
            UnknownNameError: the scene has no such contact.
        """
        nv = len(self.v_before)
        return Measurement(
            only_contacts(scene, self.contacts, self.margins()),
            at_touch(scene, self.contacts, self.q, self.covariance[:nv, :nv]),
            self.v_before,
            self.v_after,
            covariance=self.covariance,
            group=WHAT_MEETS.get(len(self.contacts), "face"),
            recording=self.recording,
        )


def _margin(gap: float) -> float:
    """Return the next power of two [m], so that impacts share scenes; 0 for what touches."""
    return 0.0 if gap <= 0.0 else 2.0 ** ceil(log2(gap))


def only_contacts(
    scene: Scene, names: tuple[str, ...], margins: tuple[float, ...] | None = None
) -> Scene:
    """Return the scene with some of its contacts alone, each with its name; no impulses.

    ``margins``: of these, up to which gap bodies that collide are to count as touching [m].

    Raises:
        UnknownNameError: the scene has no such contact.
    """
    from ..errors import UnknownNameError

    known = scene.entry_names("contacts")
    for name in names:
        if name not in known:
            raise UnknownNameError.among("contact", name, known)
    wider = dict(zip(names, margins or (0.0,) * len(names), strict=True))
    kept = []
    for name, entry in zip(known, scene.contacts, strict=True):
        if name not in names:
            continue
        own = replace(entry, name=name)
        if isinstance(own, Collision):
            own = replace(own, margin=max(bodies_of(scene.robot, own).margin, wider[name]))
        kept.append(own)
    return replace(scene, impulses=(), contacts=kept)


@public
@dataclass(frozen=True, eq=False, repr=False)
class FoundImpacts(OneLine):
    """Impacts found in one or more recordings.

    Attributes:
        impacts: those with a flight on both sides, by recording and time.
        phases: (recording, start, end) [s] without flight between two: rests, rolling,
            several impacts too close to distinguish.
        outliers: (recording, time) of samples that stand apart from those before and after.
        sigma: (nv,) noise of the samples on their tangents, as given or as estimated.
        notes: what to look at.

    Example:
        >>> import impulsekit as ik
        >>> ball = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
        >>> floor = ik.Contact("ball", at=[0, 0, -0.05], restitution=0.6, name="floor")
        >>> scene = ik.Scene(ball, contacts=[floor], gravity=[0, 0, -9.81])
        >>> drop = ball.configuration(root_joint=[0, 0, 0.5, 0, 0, 0, 1])
        >>> motion = ik.simulate(scene, drop, [0] * 6, duration=0.6, samples=61)
        >>> recording = ik.measured.Recording(ball, motion.t, motion.q)
        >>> found = ik.measured.find_impacts(recording, scene, sigma=1e-6)
        >>> len(found), len(found.balanced()), len(found.measurements(scene))
        (1, 1, 1)
    """

    impacts: tuple[FoundImpact, ...]
    phases: tuple[tuple[str, float, float], ...] = field(repr=False)
    outliers: tuple[tuple[str, float], ...] = field(repr=False)
    sigma: np.ndarray
    notes: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.impacts)

    def __repr__(self) -> str:
        counts = f"{len(self.impacts)} impacts, {len(self.phases)} gaps between flights"
        return one_line("FoundImpacts", counts, sigma=self.sigma, notes=len(self.notes))

    def only(self, keep: Callable[[FoundImpact], bool]) -> FoundImpacts:
        """Return the impacts for which ``keep`` is true."""
        return replace(self, impacts=tuple(each for each in self.impacts if keep(each)))

    def balanced(self, least: float = 1e-3) -> FoundImpacts:
        """Return those at known contacts that conserve momentum: ``balance`` at least this."""
        return self.only(lambda each: bool(each.contacts) and each.balance >= least)

    def measurements(self, scene: Scene) -> list[Measurement]:
        """Return all impacts at known contacts as ``fit_impacts`` takes them."""
        kept: dict[tuple[Any, ...], Scene] = {}
        found = []
        for each in self.impacts:
            if each.contacts:
                # Impacts at the same contacts share one scene, and are solved together.
                own = each.measurement(scene)
                key = each.contacts, each.margins()
                found.append(replace(own, scene=kept.setdefault(key, own.scene)))
        return found
