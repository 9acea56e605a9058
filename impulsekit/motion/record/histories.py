"""Histories of one entry of a scene over a motion: its impacts and its forces."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any, Generic, TypeVar

import numpy as np

from ...impact.constraint_results import ConstraintResult
from ...impact.contact_results import ContactResult
from ...robot.arrays import lock, read_only
from ...scene import JointStop

if TYPE_CHECKING:
    from .loads import Loads, LoadsOfMotion
    from .sampled import SampledMotion

__all__ = ["ConstraintHistory", "ContactHistory", "ForceHistory", "JointHistory"]

T = TypeVar("T", ContactResult, ConstraintResult)


class _Told:
    """One entry of a motion, with what it gives at a time or over a span of time."""

    _motion: SampledMotion
    name: str

    def _over_time(self, t: Any, value: Callable[[Loads], Any]) -> np.ndarray:
        """(k,) at a time, or (T, k) at times (T,); read-only."""
        times = self._motion.checked_times(t)
        loads = self._motion.loads
        found = [value(loads.at(time)) for time in times.ravel().tolist()]
        result = np.array(found) if np.ndim(t) else np.array(found[0])
        return read_only(result)

    def _integral(
        self, start: float | None, end: float | None, size: int, value: Callable[[Loads], Any]
    ) -> np.ndarray:
        a, b = self._motion.checked_span(start, end)
        return np.asarray(self._motion.loads.integral(a, b, value, size))


class _Impacts(tuple, _Told, Generic[T], ABC):
    """(time [s], result) of the impacts that an entry took part in, in order of time."""

    _index: int

    def __new__(
        cls, impacts: Iterable[tuple[float, T]], motion: SampledMotion, name: str, index: int
    ) -> Any:
        """Make the history of the entry ``name`` at this position in the scene."""
        self = super().__new__(cls, impacts)
        self._motion, self.name, self._index = motion, name, index
        return self

    def __reduce__(self) -> Any:
        return type(self), (tuple(self), self._motion, self.name, self._index)

    def impulse(self, start: float | None = None, end: float | None = None) -> np.ndarray:
        """Return the impulse on the first body between two times, as ``force`` [N s, N m s].

        The integral of the force and the impulses of the impacts. From ``start`` (after an
        impact at that time; None for the beginning, with the impacts there) to ``end`` (after an
        impact then; None for the end of the motion). Forces of rows whose axes turn are summed
        row by row.

        Raises:
            RangeError: times outside the motion.
        """
        total = self._integral(start, end, self._size, self._force)
        for result in self._struck(start, end):
            total = total + result.impulse
        return read_only(total)

    def power(self, t: Any) -> np.ndarray:
        """Return its power on the bodies, negative if it takes [W]; at times (T,): (T,)."""
        return self._over_time(t, self._power)

    def work(self, start: float | None = None, end: float | None = None) -> float:
        """Return its work between two times, impacts included [J]; see ``impulse``."""
        steady = self._integral(start, end, 1, self._power)[0]
        return float(steady + sum(result.work for result in self._struck(start, end)))

    @property
    @abstractmethod
    def _size(self) -> int:
        """Return the number of entries of a force."""

    @abstractmethod
    def _force(self, loads: Loads) -> np.ndarray:
        """Return the force at a time."""

    @abstractmethod
    def _power(self, loads: Loads) -> float:
        """Its power [W]."""

    def _struck(self, start: float | None, end: float | None) -> list[T]:
        """The results within a span; those at its end belong to it, not those at its start."""
        a, b = self._motion.checked_span(start, end)
        return [one for time, one in self if (start is None or time > a) and time <= b]


class ContactHistory(_Impacts[ContactResult]):
    """A contact in the course of a motion: (time [s], ``ContactResult``) of each impact in which
    it touched, and its forces while it rested.

    Attributes:
        name: the entry's name.

    Example:
        >>> from impulsekit import Contact, Robot, Scene, simulate
        >>> ball = Robot.from_urdf("models/ball.urdf", root="freeflyer")
        >>> floor = Contact("ball", normal=[0, 0, 1], name="floor")
        >>> motion = simulate(Scene(ball, contacts=[floor]), ball.neutral(), ball.velocity())
        >>> round(float(motion.contacts["floor"].force(0.5)[2] / ball.mass), 9)
        9.81
    """

    def force(self, t: Any) -> np.ndarray:
        """(3,) the resultant on the first body, world axes [N]; of a stop (1,) in its joint.

        Zero while it does not rest. At times (T,): (T, 3), or (T, 1).

        Raises:
            RangeError: a time outside the motion.
        """
        return self._over_time(t, self._force)

    def moment(self, t: Any) -> np.ndarray:
        """(3,) the sum of the moments against rolling and spin on the first body, world axes
        [N m], each at its point; zero where nothing resists them. At times (T,): (T, 3).

        Raises:
            RangeError: a time outside the motion.
        """
        return self._over_time(t, self._moment)

    def points(self, t: float) -> tuple[np.ndarray, np.ndarray]:
        """(k, 3) where it pushes at a time [m], and (k, 3) the force there [N], world axes.

        k is 0 while it does not rest, and for a joint stop. Where points are redundant (four
        corners of a box) they share the load as stiff springs would.

        Raises:
            RangeError: a time outside the motion.
        """
        own = self._points(self._motion.loads.at(self._motion.checked_time(t)))
        places = np.array([p.position for p in own if p.position is not None]).reshape(-1, 3)
        forces = np.array([p.force for p in own if p.position is not None]).reshape(-1, 3)
        lock(places, forces)
        return places, forces

    @property
    def _size(self) -> int:
        return 1 if isinstance(self._motion.scene.contacts[self._index], JointStop) else 3

    def _points(self, loads: Loads) -> list:
        return [point for point in loads.points if point.entry == self._index]

    def _force(self, loads: Loads) -> np.ndarray:
        return sum((point.force for point in self._points(loads)), np.zeros(self._size))

    def _moment(self, loads: Loads) -> np.ndarray:
        own = [p.moment for p in self._points(loads) if p.moment is not None]
        return sum(own, np.zeros(3))

    def _power(self, loads: Loads) -> float:
        return sum(point.power for point in self._points(loads))


class ConstraintHistory(_Impacts[ConstraintResult]):
    """A constraint in the course of a motion: (time [s], ``ConstraintResult``) of each impact,
    and its forces between them.

    Attributes:
        name: the entry's name.
    """

    def force(self, t: Any) -> np.ndarray:
        """(rows,) by row, on the first frame or in the joint [N, N m]; at times (T,): (T, rows).

        Raises:
            RangeError: a time outside the motion.
        """
        return self._over_time(t, self._force)

    def unique(self, t: float) -> bool:
        """Return True if its forces are determined at a time; those of redundant rows are not.

        Raises:
            RangeError: a time outside the motion.
        """
        loads = self._motion.loads.at(self._motion.checked_time(t))
        return loads.unique is None or bool(loads.unique[self._rows].all())

    @property
    def _rows(self) -> slice:
        return self._motion.loads.rows[self._index]

    @property
    def _size(self) -> int:
        return self._rows.stop - self._rows.start

    def _force(self, loads: Loads) -> np.ndarray:
        return loads.multipliers[self._rows]

    def _power(self, loads: Loads) -> float:
        where = self._rows
        return float(loads.multipliers[where] @ loads.row_velocities[where])


class ForceHistory(_Told):
    """A spring, an actuator or an applied force in the course of a motion.

    Attributes:
        name: the entry's name.
    """

    def __init__(self, motion: SampledMotion, name: str, index: int) -> None:
        self._motion, self.name, self._index = motion, name, index

    def force(self, t: Any) -> np.ndarray:
        """Return its force at a time; at times (T,) with a leading axis.

        An actuator or a spring in a joint: (k,) by degree of freedom [N m, N]. On bodies: (6,)
        the force [N] before the couple [N m] on ``frame`` about its point ``at``, world axes.

        Raises:
            RangeError: a time outside the motion.
        """
        return self._over_time(t, lambda loads: loads.forces[self._index].value)

    def power(self, t: Any) -> np.ndarray:
        """Return its power on the bodies at a time [W]; at times (T,): (T,)."""
        return self._over_time(t, self._power)

    def work(self, start: float | None = None, end: float | None = None) -> float:
        """Return its work on the bodies between two times [J].

        Raises:
            RangeError: times outside the motion.
        """
        return float(self._integral(start, end, 1, self._power)[0])

    def _power(self, loads: Loads) -> float:
        return loads.forces[self._index].power

    def __repr__(self) -> str:
        return f"ForceHistory({self.name!r})"


class JointHistory(_Told):
    """The load of a joint over a motion.

    Attributes:
        name: the joint's name.
    """

    def __init__(self, motion: SampledMotion, name: str) -> None:
        self._motion, self.name = motion, name

    def reaction(self, t: Any) -> np.ndarray:
        """(6,) the wrench that the parent gives the child; at times (T,): (T, 6).

        At the joint's origin, world axes, force [N] before moment [N m], with what acts in the
        joint itself (a motor, a lock, a stop). ``Impact.reactions`` has it for impacts.

        Raises:
            RangeError: a time outside the motion.
        """
        return self._over_time(t, lambda loads: loads.reactions[self.name])

    def __repr__(self) -> str:
        return f"JointHistory({self.name!r})"


def of_contacts(motion: SampledMotion) -> dict[str, ContactHistory]:
    """By the name of a contact."""
    names = motion.scene.entry_names("contacts")
    hits: list[list[tuple[float, Any]]] = [[] for _ in names]
    for time, impact in motion.impacts:
        for own, result in zip(hits, impact.contacts, strict=True):
            if result.touching:
                own.append((time, result))
    return {
        name: ContactHistory(own, motion, name, i)
        for i, (name, own) in enumerate(zip(names, hits, strict=True))
    }


def of_constraints(motion: SampledMotion) -> dict[str, ConstraintHistory]:
    """By the name of a constraint."""
    found = {}
    for i, name in enumerate(motion.scene.entry_names("constraints")):
        own = [
            (time, impact.constraints[i]) for time, impact in motion.impacts if impact.constraints
        ]
        found[name] = ConstraintHistory(own, motion, name, i)
    return found


def of_forces(motion: SampledMotion) -> dict[str, ForceHistory]:
    """By the name of a spring, an actuator or an applied force."""
    names = motion.scene.entry_names("forces")
    return {name: ForceHistory(motion, name, i) for i, name in enumerate(names)}


def of_joints(motion: SampledMotion) -> dict[str, JointHistory]:
    """By the name of a joint, fixed ones and the roots of fixed bases included."""
    loads: LoadsOfMotion = motion.loads
    return {name: JointHistory(motion, name) for name in loads.at(0.0).reactions}
