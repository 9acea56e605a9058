"""``Scene``: a robot and what strikes, holds and touches it."""

from __future__ import annotations

import copy
import math
import threading
from collections.abc import Callable, Sequence
from dataclasses import InitVar, dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Generic, Literal, TypeVar

import numpy as np

from ..errors import InputError, a_thing
from ..errors.calls import public
from ..formatting import Displayed, one_line
from ..named import Named
from ..robot import Robot
from .law import Law
from .numbers import Vector, choice, keep, not_negative, text, vector

if TYPE_CHECKING:
    from typing import Unpack

    from .entries import Constraint, ContactEntry, SceneEntries
    from .forces import Force
    from .impulses import AppliedImpulse, JointImpulse
    from .materials import Material, MaterialPair


# The lists of a scene, and what may stand in them.
_SECTIONS = {
    "impulses": "an AppliedImpulse or a JointImpulse",
    "constraints": "a PointAnchor, FrameAnchor, DistanceAnchor, JointLock, JointCoupling, Driven "
    "or GapConstraint",
    "contacts": "a Contact, JointStop, Collision, Rope or GapContact",
    "forces": "a JointSpring, JointFriction, Spring, Actuator or AppliedForce",
}


_LAW = Law()


@public
@dataclass(frozen=True, eq=False, repr=False)
class Scene(Displayed):
    """A robot with the impulses, constraints, contacts and forces that act on it.

    A scene is frozen, can be pickled and is checked against its robot when created. Its entries
    are found by place and by name: ``scene.contacts[0]``, ``scene.contacts["floor"]``.

    Attributes:
        robot: the robot.
        impulses: known impulses, external or in joints.
        constraints: bilateral constraints: loops that are closed already, or grips, locks and
            landings that close at the instant of the impact.
        contacts: unilateral contacts, which push and never pull: points on planes, joint
            stops, colliding bodies.
        forces: springs, actuators and applied forces; like gravity they act in the motion
            after an impact.
        law: law of restitution, slip and order for all contacts.
        gravity: [m/s²] in world axes; it acts in the motion after an impact. An impact is
            instantaneous and does not depend on it.
        gap_bound: a contact or anchor that is open or overlaps by more than this at the impact
            is reported in ``Impact.doubts`` [m, for joint stops rad]; infinite for none.
        controlled: joints under stiff position or velocity control. In an impact each keeps
            its velocity, Δq̇ = 0, so that the links between them strike as one composite rigid
            body (Wang, Dehio & Kheddar 2022). The impulse of its motor is the result
            "controlled JOINT" in ``Impact.constraints``. A joint that runs into its own
            ``JointStop`` is free in that impact: the stop is the stiffer of the two. Between
            impacts, forces and actuators move the joint. Other joints are free.
        materials: what links are made of (``Material``), and the coefficients of pairs
            (``MaterialPair``), for contacts with ``restitution="material"`` or
            ``friction="material"``, which get the coefficients of their pair here;
            ``dataclasses.replace(scene, materials=...)`` gives them those of another table.
        collisions: "all" adds ``collisions(robot)`` to the contacts: every pair of links that may
            meet, without restitution and friction. For coefficients give
            ``contacts=collisions(robot, friction=...)``.

    Raises:
        UnknownNameError: a frame or joint that the robot does not have.
        ShapeError: a joint impulse or velocity has the wrong length.
        InputError: an impulse on the world, an anchor within one body, two entries with
            the same name, tangential restitution under a law without it, a contact without
            stiffness under "lzb", a controlled joint
            that is also locked.

    Example:
        >>> from impulsekit import AppliedImpulse
        >>> robot = Robot.from_example("panda")
        >>> scene = Scene(robot, impulses=[AppliedImpulse("panda_hand", linear=[0, 0, 1])])
        >>> scene.impulses[0].frame
        'panda_hand'
    """

    robot: Robot
    impulses: Sequence[AppliedImpulse | JointImpulse] = Named((), "impulse")
    constraints: Sequence[Constraint] = Named((), "constraint")
    contacts: Sequence[ContactEntry] = Named((), "contact")
    forces: Sequence[Force] = Named((), "force")
    law: Law = _LAW
    gravity: Vector = (0.0, 0.0, -9.81)
    gap_bound: float = 1e-3
    controlled: Sequence[str] = ()
    materials: Sequence[Material | MaterialPair] = ()
    collisions: InitVar[Literal["all"] | None] = field(default=None, kw_only=True)

    def __post_init__(self, collisions: Literal["all"] | None) -> None:
        if not isinstance(self.robot, Robot):
            raise InputError(f"Scene: robot is {a_thing(self.robot)}, not a Robot")
        set_field = object.__setattr__
        set_field(self, "materials", _entries(self.materials, "materials"))
        for kind in _SECTIONS:
            self._keep(kind, getattr(self, kind))
        if collisions is not None:
            from .link_pairs import collisions as all_pairs

            choice("all")(collisions, "Scene: collisions")
            self._keep("contacts", (*self.contacts, *all_pairs(self.robot)))
        set_field(self, "controlled", _names(self.controlled, "controlled"))
        set_field(self, "gravity", vector(self.gravity, "Scene: gravity"))
        if self.gap_bound != math.inf:
            keep(self, "Scene", not_negative, "gap_bound")
        if self.materials or self.contacts:
            from .coefficients import asks_for_materials

            if self.materials or any(map(asks_for_materials, self.contacts)):
                from .materials import with_materials

                own = with_materials(self.robot, self.contacts, self.materials)
                self._keep("contacts", own)
        self._check_entries()
        if not isinstance(self.law, Law):
            raise InputError(f"Scene: law is {a_thing(self.law)}, not a Law")
        if self.contacts:
            from .contacts import check_law

            check_law(self.law, self.contacts)
        self._check_names()

    @classmethod
    def of_robot(
        cls,
        robot: Robot,
        *,
        file_loops: bool = True,
        file_contacts: bool | str = "all",
        file_turning: bool = True,
        joint_damping: bool = False,
        joint_friction: bool = False,
        restitution: float = 0.0,
        **entries: Unpack[SceneEntries],
    ) -> Scene:
        """Return a scene with the loops and the contacts of the robot's file.

        Args:
            robot: the robot, such as one of ``Robot.from_mjcf``.
            file_loops: whether the equality constraints of the file become constraints.
            file_contacts: "all" (or True) for the collisions that an MJCF file allows, "world"
                for those of moving geoms with fixed ones alone, False for none. Pairs that
                overlap in the neutral or a named pose are left out, as in ``collisions``.
            file_turning: whether those contacts get the file's torsional and rolling friction too
                (condim 4 and 6 of MJCF); False takes sliding friction alone, for laws that do not
                support the others.
            joint_damping: whether the damping of the file's joints (of a URDF, <dynamics damping>)
                becomes forces, of joints with one degree of freedom.
            joint_friction: whether their dry friction does (of a URDF, <dynamics friction>; of
                MJCF, frictionloss).
            restitution: of those collisions. MJCF knows none; friction is the file's.
            **entries: what ``Scene`` takes; ``constraints``, ``contacts`` and ``forces`` come
                after the file's. Gravity is the file's unless it is given.

        Raises:
            UnknownNameError: ``file_contacts`` is something else.
            InputError: friction that differs between the two tangents of MuJoCo's contact frame,
                and what ``Scene`` raises.

        Warns:
            SetupWarning: pairs left out since they overlap.

        Example:
            >>> from impulsekit import Contact, Robot, Scene
            >>> ball = Robot.from_urdf("models/ball.urdf", root="freeflyer")
            >>> scene = Scene.of_robot(ball, contacts=[Contact("ball", restitution=0.5)])
            >>> scene.contacts[0].restitution
            0.5
        """
        from .entries import constraints_of_file, contacts_of_file, forces_of_file

        own: dict[str, Any] = {"gravity": tuple(robot.model.gravity.linear), **entries}
        for kind, found in (
            ("constraints", constraints_of_file(robot) if file_loops else []),
            ("contacts", contacts_of_file(robot, file_contacts, restitution, turning=file_turning)),
            ("forces", forces_of_file(robot, damping=joint_damping, friction=joint_friction)),
        ):
            own[kind] = (*found, *own.get(kind, ()))
        return cls(robot, **own)

    def replace(self, **entries: Unpack[SceneEntries]) -> Scene:
        """Return the scene with some of its entries, its law or its gravity replaced, and checked.

        Example:
            >>> from impulsekit import AppliedImpulse, Robot, Scene
            >>> scene = Scene(Robot.from_example("panda"))
            >>> scene.replace(gravity=[0, 0, 0]).gravity
            (0.0, 0.0, 0.0)
        """
        return replace(self, **entries)

    def with_impulse(self, *impulses: AppliedImpulse | JointImpulse) -> Scene:
        """Return the scene with more known impulses.

        Example:
            >>> from impulsekit import AppliedImpulse, Robot, Scene
            >>> scene = Scene(Robot.from_example("panda"))
            >>> blow = AppliedImpulse("panda_hand", linear=[0, 0, 1], name="blow")
            >>> scene.with_impulse(blow).entry_names("impulses")
            ('blow',)
        """
        return replace(self, impulses=(*self.impulses, *impulses))

    def with_numbers(self, impulses: tuple[AppliedImpulse | JointImpulse, ...]) -> Scene:
        """Return the scene with its impulses at other numbers, which leaves nothing to check."""
        scene = copy.copy(self)
        object.__setattr__(scene, "impulses", Named(impulses, "impulse"))
        return scene

    def _keep(self, kind: str, entries: Any) -> None:
        """Keep the entries of a ``kind`` such as "impulses", found by name as well."""
        one = kind.removesuffix("s")
        if type(entries) is not Named or entries.kind != one:
            object.__setattr__(self, kind, Named(_entries(entries, kind), one))

    def _check_entries(self) -> None:
        for kind, known in _SECTIONS.items():
            for i, entry in enumerate(getattr(self, kind)):
                if getattr(entry, "section", "") != kind:
                    raise InputError(f"{kind}[{i}] must be {known}, got {a_thing(entry)}")
                entry.check_robot(self.robot, f"{kind}[{i}]")
        held = [entry.joint_names for entry in self.constraints]
        for i, name in enumerate(self.controlled):
            self.robot.joint_id(name, f"controlled[{i}]")
            if name in self.controlled[:i]:
                raise InputError(f'controlled[{i}]: joint "{name}" is named twice')
            if (name,) in held:
                raise InputError(
                    f'controlled[{i}]: a JointLock holds joint "{name}" already; '
                    "leave one of the two out"
                )

    def _check_names(self) -> None:
        kinds = ("impulses", "held", "contacts", "forces")
        names = [name for kind in kinds for name in self.entry_names(kind)]
        if len({*names}) < len(names):
            twice = next(name for name in names if names.count(name) > 1)
            raise InputError(
                f'Scene: {names.count(twice)} entries have the name "{twice}", each needs its own'
            )

    def __repr__(self) -> str:
        counts = [
            f"{n} {kind[:-1] if n == 1 else kind}"
            for kind in ("impulses", "constraints", "contacts", "forces")
            if (n := len(getattr(self, kind)))
        ]
        if self.controlled:
            counts.append(f"{len(self.controlled)} controlled")
        law = f"{self.law.restitution}/{self.law.slip}/{self.law.order}"
        return one_line("Scene", repr(self.robot.name), *(counts or ["nothing acts"]), law=law)

    @cached_property
    def _kept(self) -> dict[Any, Any]:
        """What follows from the scene and is made once: by ``SceneCache``."""
        return {}

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in vars(self).items() if name != "_kept"}

    @cached_property
    def held(self) -> tuple[Constraint, ...]:
        """Constraints of an impact: those of the scene, then a lock for each controlled joint."""
        if not self.controlled:
            return tuple(self.constraints)
        from .constraints import velocity_keeping_lock

        return (*self.constraints, *map(velocity_keeping_lock, self.controlled))

    def entry_names(self, kind: str) -> tuple[str, ...]:
        """Return the names of the entries of a ``kind`` such as "impulses": name or place."""
        if kind == "held":
            locks = self.held[len(self.constraints) :]
            return (*self.entry_names("constraints"), *(str(lock.name) for lock in locks))
        names: tuple[str, ...] = getattr(self, kind).names
        return names


def _entries(value: Any, what: str) -> tuple[Any, ...]:
    if isinstance(value, np.ndarray) and value.dtype.kind in "fiu":
        raise InputError(
            f"Scene: {what} must be a list of entries, got numbers; a state goes to "
            "solve(scene, q, v) or simulate(scene, q, v, duration)"
        )
    try:
        return tuple(value)
    except TypeError:
        raise InputError(f"Scene: {what} must be a list, got {a_thing(value)}") from None


def _names(value: Any, what: str) -> tuple[str, ...]:
    names = (value,) if isinstance(value, str) else _entries(value, what)
    return tuple(text(name, f"Scene: {what}[{i}]") for i, name in enumerate(names))


def scene_at(scene: Scene, t: float) -> Scene:
    """Return the scene with what is driven in time as at a time [s]; itself where nothing is."""
    if not scene.constraints:
        return scene
    from .driven import constraint_at, is_driven

    if not any(map(is_driven, scene.constraints)):
        return scene
    names = scene.entry_names("constraints")
    return replace(
        scene,
        constraints=[
            constraint_at(entry, name, t)
            for entry, name in zip(scene.constraints, names, strict=True)
        ],
    )


T = TypeVar("T")


class SceneCache(Generic[T]):
    """What ``make(scene)`` gives, made when first asked for and kept with the scene."""

    def __init__(self, make: Callable[[Scene], T]) -> None:
        self._make = make

    def has(self, scene: Scene) -> bool:
        """Return whether it was made."""
        return self in scene._kept

    def of(self, scene: Scene) -> T:
        """Return the value of a scene."""
        kept = scene._kept
        if self not in kept:
            kept[self] = self._make(scene)
        found: T = kept[self]
        return found


class ThreadCache(Generic[T]):
    """The same for each thread by itself: workspaces, which a use overwrites."""

    def __init__(self, make: Callable[[Scene], T]) -> None:
        self._make = make
        self._of_threads = SceneCache(lambda scene: threading.local())

    def of(self, scene: Scene) -> T:
        """Return the value of a scene in this thread."""
        own = self._of_threads.of(scene)
        try:
            found: T = own.value
        except AttributeError:
            found = own.value = self._make(scene)
        return found
