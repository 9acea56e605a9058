"""Impulses, velocities and modes of contacts."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

import numpy as np

from ..formatting import Displayed, OneLine
from ..robot.arrays import lock, read_only
from ..robot.placing import Posture
from ..scene import JointStop, Scene
from ..scene.coefficients import static_friction
from ..scene.entries import ContactEntry
from .contact_law import NO_SLIP
from .residuals import cancelling_speeds

if TYPE_CHECKING:
    from .answer import Answer
    from .contact_law import ContactSolution
    from .outcome import Touch

__all__ = ["ContactPoint", "ContactResult", "TurningResult", "contact_impulses", "contact_results"]

# A tangential impulse this near µ P_n has reached the cone.
ON_CONE = 1e-9
# Angular velocities that differ by less than this share of the terms they are sums of are one: some
# hundreds of roundings.
SAME_START = 1e-13
# Velocities that differ by no more than this share of their terms are the same.
SAME_VELOCITY = 1e-13


@dataclass(frozen=True, eq=False, repr=False)
class TurningResult(OneLine):
    """The angular impulse of a point against rolling and spin, world axes.

    Attributes:
        impulse: (3,) angular impulse on the first body [N m s].
        velocity_before, velocity_after: (3,) angular, of the first body relative to the other
            [rad/s].
        rolling: "separated", "rolling" (at the limit, rolling·P_n) or "sticking".
        spin: "separated", "spinning" (at the limit, torsion·P_n) or "sticking".
        work: of the angular impulse [J].
    """

    impulse: np.ndarray
    velocity_before: np.ndarray
    velocity_after: np.ndarray
    rolling: str
    spin: str
    work: float

    def to_dict(self) -> dict[str, Any]:
        """Ready for JSON, under the names of a point."""
        return {
            "angular_impulse": self.impulse.tolist(),
            "rolling": self.rolling,
            "spin": self.spin,
            "angular_velocity_before": self.velocity_before.tolist(),
            "angular_velocity_after": self.velocity_after.tolist(),
            "turning_work": self.work,
        }


@dataclass(frozen=True, eq=False, repr=False)
class ContactPoint(OneLine):
    """One touching point after the solve, world axes.

    Attributes:
        position: (3,) [m]; None for a joint stop.
        normal: (3,) from the body that is touched to the one that receives the impulse;
            None for a joint stop.
        impulse: (3,) on the first body [N s]; for a stop (1,) along the joint's
            coordinate [N m s, N s].
        velocity_before, velocity_after: (3,) of the first body relative to the other at
            the point [m/s]; for a stop (1,) of the joint [rad/s, m/s].
        mode: "separated", "sliding" or "sticking"; without friction a contact that is
            pressed counts as sliding.
        normal_work, friction_work: [J].
        unique: False where the point shares its load with redundant ones.
        turning: of a contact that resists rolling or spin; None of others.
    """

    position: np.ndarray | None
    normal: np.ndarray | None
    impulse: np.ndarray
    velocity_before: np.ndarray
    velocity_after: np.ndarray
    mode: str
    normal_work: float
    friction_work: float
    unique: bool
    turning: TurningResult | None = None

    def to_dict(self) -> dict[str, Any]:
        """Ready for JSON."""
        return {
            "position": None if self.position is None else self.position.tolist(),
            "normal": None if self.normal is None else self.normal.tolist(),
            "impulse": self.impulse.tolist(),
            "velocity_before": self.velocity_before.tolist(),
            "velocity_after": self.velocity_after.tolist(),
            "mode": self.mode,
            "normal_work": self.normal_work,
            "friction_work": self.friction_work,
            "unique": self.unique,
            **({} if self.turning is None else self.turning.to_dict()),
        }


@dataclass(frozen=True, eq=False, repr=False)
class ContactResult(Displayed):
    """A contact of the scene after the solve: the sum over its touching points.

    Attributes:
        name: the entry's name.
        points: its touching points; none where it does not touch.
        impulse: (3,) the resultant; for a joint stop (1,).
        velocity_before, velocity_after: (3,) at the middle of its points; for a stop (1,).
            NaN where it does not touch.
        mode: "separated", "sliding" or "sticking": of the point that holds most.
        work: of normal and friction impulses, and of angular ones against rolling and spin [J].
        unique: False where only the resultant over redundant points counts.
        measure: gives the gap; called when it is first asked for.
    """

    name: str
    points: tuple[ContactPoint, ...]
    impulse: np.ndarray
    velocity_before: np.ndarray
    velocity_after: np.ndarray
    mode: str
    work: float
    unique: bool
    measure: Callable[[], float] = field(repr=False)

    def to_dict(self) -> dict[str, Any]:
        """Ready for JSON, which knows neither NaN nor infinity: None in their place."""
        before, after = self.velocity_before, self.velocity_after
        return {
            "name": self.name,
            "mode": self.mode,
            "gap": self.gap if math.isfinite(self.gap) else None,
            "impulse": self.impulse.tolist(),
            "velocity_before": before.tolist() if np.isfinite(before).all() else None,
            "velocity_after": after.tolist() if np.isfinite(after).all() else None,
            "work": self.work,
            "unique": self.unique,
            "points": [point.to_dict() for point in self.points],
        }

    @cached_property
    def gap(self) -> float:
        """The gap [m]; of a stop the distance to the nearer limit [rad, m].

        Negative where bodies overlap, a point is below its plane or a joint past its limit. A
        ``Contact`` counts as touching whatever its gap.
        """
        return self.measure()

    @property
    def angular_impulse(self) -> np.ndarray:
        """(3,) the sum of the angular impulses against rolling and spin on the first body, world
        axes [N m s]; zero without ``rolling`` and ``torsion``."""
        own = [point.turning.impulse for point in self.points if point.turning is not None]
        total = np.sum(own, axis=0) if own else np.zeros(3)
        return read_only(total)

    @property
    def touching(self) -> bool:
        """True if it touches at this configuration."""
        return bool(self.points)


def contact_results(impact: Answer) -> tuple[ContactResult, ...]:
    """The results of a scene's contacts, in their order."""
    scene = impact.scene
    points: list[list[ContactPoint]] = [[] for _ in scene.contacts]
    outcome = impact.outcome
    if outcome is not None and outcome.contacts is not None:
        turned = {touch.turns: k for k, touch in enumerate(outcome.touches) if touch.turns >= 0}
        for i, touch in enumerate(outcome.touches):
            if touch.turns < 0:
                turning = _turning_result(impact, turned[i]) if i in turned else None
                points[touch.entry].append(_point(impact, touch, i, turning))
    return tuple(
        _result(
            name,
            tuple(own),
            1 if isinstance(entry, JointStop) else 3,
            partial(_gap, scene, impact.q, i),
        )
        for i, (name, own, entry) in enumerate(
            zip(scene.entry_names("contacts"), points, scene.contacts, strict=True)
        )
    )


def contact_impulses(impact: Answer) -> dict[int, np.ndarray]:
    """``ContactResult.impulse`` of the contacts that touch, by index; nothing else is computed."""
    outcome = impact.outcome
    if outcome is None or outcome.contacts is None:
        return {}
    by_point: dict[int, list[np.ndarray]] = {}
    for touch, local in zip(outcome.touches, outcome.contacts.impulse.reshape(-1, 3), strict=True):
        if touch.turns < 0:
            by_point.setdefault(touch.entry, []).append(_in_world(touch, local))
    return {entry: _total(own) for entry, own in by_point.items()}


def _in_world(touch: Touch, local: np.ndarray) -> np.ndarray:
    """(3,) of what is in the axes of a point; of a joint stop (1,), along its joint."""
    if touch.axes is None:
        return np.array([touch.jacobian[2].sum() * local[2]])
    return np.asarray(touch.axes @ local)


def _total(impulses: Sequence[np.ndarray]) -> np.ndarray:
    """The sum over the points of a contact."""
    return np.asarray(np.sum(impulses, axis=0)) if len(impulses) > 1 else impulses[0].copy()


def _gap(scene: Scene, q: np.ndarray, index: int) -> float:
    from .gaps import contact_gaps

    return contact_gaps(scene, Posture(scene.robot, q), (index,))[0].gap


def _point(impact: Answer, touch: Touch, i: int, turning: TurningResult | None) -> ContactPoint:
    outcome = impact.outcome
    if outcome is None or outcome.contacts is None:
        raise ValueError("no contact touched")
    solution = outcome.contacts
    local = solution.impulse[3 * i : 3 * i + 3]
    velocities = touch.jacobian @ impact.v_before, touch.jacobian @ impact.v_after
    entry = impact.scene.contacts[touch.entry]
    position, normal = touch.position, None
    arrays = [_in_world(touch, vector) for vector in (local, *velocities)]
    if touch.axes is not None:
        normal = touch.axes[:, 2].copy()
    pressed = local + np.array([0.0, 0.0, getattr(entry, "adhesion", 0.0)])
    normal_work, friction_work = _works(solution, i, touch.jacobian, velocities, local)
    lock(*arrays, normal, position)
    impulse, before, after = arrays
    return ContactPoint(
        position,
        normal,
        impulse,
        before,
        after,
        mode=_mode(pressed, _friction(solution, i, entry), _is_still(impact, solution, i)),
        normal_work=normal_work,
        friction_work=friction_work,
        unique=solution.unique is None or bool(solution.unique[i]),
        turning=turning,
    )


def _works(
    solution: ContactSolution,
    i: int,
    jacobian: np.ndarray,
    velocities: tuple[np.ndarray, np.ndarray],
    impulse: np.ndarray,
) -> tuple[float, float]:
    """The work of normal and friction, so that the energy balance of the whole impact closes.

    A law that follows the impact knows the true work, if nothing else acts in the same
    instant. Beside blows and imposed constraints each entry gets impulse · (u⁻ + u⁺)/2.
    """
    before, after = velocities
    start = solution.velocity_start[3 * i : 3 * i + 3]
    size = np.abs(jacobian).sum() * SAME_VELOCITY * max(np.abs(before).max(), np.abs(after).max())
    if np.abs(start - before).max() <= size:
        return float(solution.normal_work[i]), float(solution.friction_work[i])
    shares = 0.5 * impulse * (before + after)
    return float(shares[2]), float(shares[0] + shares[1])


def _is_still(impact: Answer, solution: ContactSolution, i: int) -> bool:
    """Return True if a contact does not slip, wherever in its cone its impulse is."""
    after = solution.velocity_after
    slip = float(np.abs(after[3 * i : 3 * i + 2]).max())
    speed = max(float(np.abs(after).max()), float(np.abs(solution.velocity_start).max()))
    if slip <= NO_SLIP * speed or impact.outcome is None or not impact.scene.impulses:
        return slip <= NO_SLIP * speed
    # What rests and is struck has no velocities but those that impulses alone would make.
    rows = np.abs(impact.outcome.touches[i].jacobian)
    return slip <= NO_SLIP * float((rows @ cancelling_speeds(impact)).max())


def _friction(solution: ContactSolution, i: int, entry: ContactEntry) -> float:
    """µ of a contact, that of its slip where it depends on it."""
    if solution.friction is not None:
        return float(solution.friction[i])
    return static_friction(getattr(entry, "friction", 0.0))


def _mode(impulse: np.ndarray, friction: float, still: bool) -> str:
    if impulse[2] <= 0.0:
        return "separated"
    if still and friction > 0.0:
        return "sticking"
    tangential = float(np.hypot(impulse[0], impulse[1]))
    return "sticking" if tangential < friction * impulse[2] * (1.0 - ON_CONE) else "sliding"


def _result(
    name: str, points: tuple[ContactPoint, ...], size: int, measure: Callable[[], float]
) -> ContactResult:
    if points:
        impulse = _total([point.impulse for point in points])
        before = np.mean([point.velocity_before for point in points], axis=0)
        after = np.mean([point.velocity_after for point in points], axis=0)
    else:
        impulse, before, after = np.zeros(size), np.full(size, np.nan), np.full(size, np.nan)
    lock(impulse, before, after)
    modes = {point.mode for point in points}
    return ContactResult(
        name,
        points,
        impulse,
        before,
        after,
        mode=next((m for m in ("sticking", "sliding") if m in modes), "separated"),
        work=sum(
            point.normal_work
            + point.friction_work
            + (0.0 if point.turning is None else point.turning.work)
            for point in points
        ),
        unique=all(point.unique for point in points),
        measure=measure,
    )


def _turning_result(impact: Answer, k: int) -> TurningResult:
    """Return the result of the k-th touch of an impact, whose rows are of turning."""
    outcome = impact.outcome
    if outcome is None or outcome.contacts is None:
        raise ValueError("no contact touched")
    touch, solution = outcome.touches[k], outcome.contacts
    if touch.axes is None:
        raise ValueError("a joint stop does not turn")
    own = slice(3 * k, 3 * k + 3)
    local, normal = solution.impulse[own], float(solution.impulse[3 * touch.turns + 2])
    before, after = touch.jacobian @ impact.v_before, touch.jacobian @ impact.v_after
    start = solution.velocity_start[own]
    fastest = max(np.abs(before).max(), np.abs(after).max())
    size = np.abs(touch.jacobian).sum() * fastest * SAME_START
    # As for forces: a law that follows the impact knows the work, if nothing else acts.
    work = float(solution.friction_work[k])
    if np.abs(start - before).max() > size:
        work = float(0.5 * local @ (before + after))
    entry = impact.scene.contacts[touch.entry]
    rolling, spin = (getattr(entry, name) * normal for name in ("rolling", "torsion"))
    impulse, before, after = (touch.axes @ vector for vector in (local, before, after))
    lock(impulse, before, after)
    across, about = float(np.hypot(local[0], local[1])), abs(float(local[2]))
    return TurningResult(
        impulse,
        before,
        after,
        rolling=_turning_mode(normal, across, rolling, "rolling"),
        spin=_turning_mode(normal, about, spin, "spinning"),
        work=work,
    )


def _turning_mode(normal: float, moment: float, limit: float, moves: str) -> str:
    if normal <= 0.0:
        return "separated"
    return "sticking" if moment < limit * (1.0 - ON_CONE) else moves
