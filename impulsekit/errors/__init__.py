"""Every exception that impulsekit raises, in one tree.

::

    ImpulsekitError
    ├── InputError (ValueError)          something given cannot be used
    │   ├── UnknownNameError (KeyError)  .kind .name .nearest .known
    │   ├── ShapeError                   .what .expected .got
    │   ├── NotFiniteError               .what .where
    │   ├── RangeError                   .what .value .allowed
    │   ├── CallbackError                .entry: a function that a user gave
    │   ├── StateError                   .joint .value: a configuration off its manifold
    │   ├── UrdfError                    .source .element
    │   ├── MjcfError                    .source .element
    │   └── SceneFileError               .path .faults: all faults of a file at once
    ├── SolveError                       the input is fine, the physics has no solution
    │   ├── SingularMassError            .joints: directions without inertia
    │   └── ContradictionError           .rows: demands that cannot hold together
    ├── FileError (OSError)              .path: a file that cannot be read or written
    └── MissingExtraError (ImportError)  .package .extra: an optional library is absent

    AssumptionWarning (UserWarning)      .source .assumptions: a file that leaves things open
    SetupWarning (UserWarning)           .doubts: a scene or state that is likely not meant

The message says what, where and what would be right; the same facts are
attributes, for programs.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from .wording import (
    AssumptionWarning,
    SetupWarning,
    a_thing,
    escaped,
    nearest_names,
    one_of,
    quoted,
    shape_text,
    shown,
    warn_of_assumptions,
    warn_of_setup,
    warn_user,
)

__all__ = [
    "AssumptionWarning", "ContradictionError", "FileError", "ImpulsekitError",
    "InputError", "MissingExtraError", "MjcfError", "NotFiniteError", "RangeError",
    "SceneFileError", "SetupWarning", "ShapeError", "SingularMassError", "SolveError",
    "StateError", "UnknownNameError", "UrdfError", "a_thing", "check_kind",
    "nearest_names", "quoted", "shown", "warn_of_assumptions", "warn_of_setup",
    "warn_user",
]  # fmt: skip


class ImpulsekitError(Exception):
    """Base of all errors of impulsekit.

    Args:
        message: the sentence for a person.
        **data: facts for a program, set as attributes.

    Attributes:
        from_function: whether a function that the user gave with an entry of a scene is at
            fault: no row of a batch and no impact of a motion stands for it, it is raised.

    Example:
        >>> error = RangeError.of("friction", -1.0, "0 or more")
        >>> print(error)
        friction must be 0 or more, got -1.0
        >>> error.allowed
        '0 or more'
    """

    from_function: bool = False

    def __init__(self, message: str, **data: Any) -> None:
        # Only the message goes to Exception: pickling then restores the rest from __dict__.
        # A name out of a file may hold what a terminal would obey.
        super().__init__(escaped(message))
        self.__dict__.update(data)

    def __getattr__(self, name: str) -> Any:
        raise AttributeError(f"{type(self).__name__} carries no {name!r}")


class InputError(ImpulsekitError, ValueError):
    """Something given cannot be used.

    Example:
        >>> issubclass(UnknownNameError, InputError) and issubclass(InputError, ValueError)
        True
    """


def check_kind(value: object, kind: type, what: str) -> None:
    """Check that a function, ``what`` in words, was given what it takes.

    Raises:
        InputError: it was not.

    Example:
        >>> check_kind({}, dict, "load")
    """
    if not isinstance(value, kind):
        article = "an" if kind.__name__[0] in "AEIOU" else "a"
        raise InputError(f"{what} takes {article} {kind.__name__}, not {a_thing(value)}")


# What likely is meant by names that many expect to be there, by kind and name.
MEANT = {
    (kind, name): hint
    for kind, hint in (
        ("link or geometry", 'robot.with_ground() gives the world one, called "ground"'),
        ("frame", 'the fixed frame is "world", and a Contact is with the plane z = 0 of it'),
    )
    for name in ("ground", "floor", "plane")
}


# So many known names are listed where none is similar.
LISTED = 16


class UnknownNameError(InputError, KeyError):
    """A name that does not exist. Attributes: kind, name, nearest, known.

    A ``KeyError`` as well, so that mappings of results behave as any other.

    Example:
        >>> print(UnknownNameError.among("frame", "hnad", ["hand", "foot"]))
        unknown frame "hnad"; did you mean "hand"?
    """

    kind: str
    name: str
    nearest: tuple[str, ...]
    known: tuple[str, ...]

    def __str__(self) -> str:
        # A KeyError would put its sentence in quotes.
        return Exception.__str__(self)

    @classmethod
    def among(
        cls, kind: str, name: str, known: Iterable[str], where: str = "", hint: str = ""
    ) -> UnknownNameError:
        """Return the error for a ``name`` of a ``kind`` that is not ``known``.

        Args:
            where: what begins the sentence. hint: what ends it, in place of the nearest names.
        """
        names = tuple(known)
        nearest = nearest_names(name, names)
        meant = MEANT.get((kind, str(name).rpartition("/")[2]))
        if hint or meant:
            hint = hint or str(meant)
        elif nearest:
            hint = "did you mean " + one_of(nearest) + "?"
        elif not names:
            hint = "there are none"
        elif len(names) <= LISTED:
            hint = "choose " + one_of(names)
        else:
            hint = f"none of the {len(names)} known names is similar"
        place = f"{where}: " if where else ""
        return cls(
            f'{place}unknown {kind} "{shown(name)}"; {hint}',
            kind=kind,
            name=name,
            nearest=nearest,
            known=names,
        )


class ShapeError(InputError):
    """An array of the wrong shape. Attributes: what, expected, got.

    Example:
        >>> print(ShapeError.of("q", (6,), (3,)))
        q: expected shape (6,), got (3,)
    """

    what: str
    expected: tuple[int | str, ...]
    got: tuple[int, ...]

    @classmethod
    def of(
        cls, what: str, expected: Sequence[int | str], got: Sequence[int], hint: str = ""
    ) -> ShapeError:
        """Return the error for an array called ``what``."""
        tail = f" ({hint})" if hint else ""
        return cls(
            f"{what}: expected shape {shape_text(expected)}, got {shape_text(got)}{tail}",
            what=what,
            expected=tuple(expected),
            got=tuple(got),
        )


class NotFiniteError(InputError):
    """A NaN or an infinity. Attributes: what, where (index or name).

    Example:
        >>> print(NotFiniteError.of("v", "v[2]", float("nan")))
        v: v[2] must be finite, got nan
    """

    what: str
    where: Any

    @classmethod
    def of(cls, what: str, where: Any, value: Any) -> NotFiniteError:
        """Return the error for the entry ``where`` of ``what``."""
        return cls(f"{what}: {where} must be finite, got {value}", what=what, where=where)


class RangeError(InputError):
    """A number outside its range. Attributes: what, value, allowed.

    Example:
        >>> print(RangeError.of("restitution", 1.5, "0 to 1"))
        restitution must be 0 to 1, got 1.5
    """

    what: str
    value: Any
    allowed: str

    @classmethod
    def of(cls, what: str, value: Any, allowed: str) -> RangeError:
        """Return the error for ``what`` with ``value`` that must be ``allowed``, in words."""
        return cls(
            f"{what} must be {allowed}, got {value}", what=what, value=value, allowed=allowed
        )


class CallbackError(InputError):
    """A user's function raised, or gave no real numbers. Attributes: entry.

    Along a single motion (``simulate``, ``Simulation``) what the function raises comes out itself.

    Example:
        >>> from impulsekit import Actuator, Robot, Scene, simulate
        >>> from impulsekit.models import pendulum_urdf
        >>> rod = Robot.from_urdf(pendulum_urdf(1))
        >>> motor = Actuator("joint_1", lambda t, q, v: "strong")
        >>> try:
        ...     _ = simulate(Scene(rod, forces=[motor]), rod.neutral(), rod.velocity(), 0.1)
        ... except CallbackError as error:
        ...     print(error.entry)
        forces[0]: torque at t = 0
    """

    entry: str


class StateError(InputError):
    """A configuration off its manifold, such as a quaternion off unit. Attributes: joint, value.

    Example:
        >>> from impulsekit import AppliedImpulse, Robot, Scene, solve
        >>> talos = Robot.from_example("talos", root="freeflyer")
        >>> q = talos.neutral()
        >>> q[3:7] = [0.0, 0.0, 0.0, 2.0]
        >>> try:
        ...     _ = solve(Scene(talos, [AppliedImpulse("base_link")]), q, talos.velocity())
        ... except StateError as error:
        ...     print(error.joint)
        root_joint
    """

    joint: str
    value: Any


class UrdfError(InputError):
    """A URDF that cannot be read or used. Attributes: source, element.

    Example:
        >>> from impulsekit import Robot
        >>> try:
        ...     _ = Robot.from_urdf("<robot name='r'><link/></robot>")
        ... except UrdfError as error:
        ...     print(error.element)
        <link> number 1
    """

    source: str
    element: str


class MjcfError(InputError):
    """An MJCF or SDF file that cannot be read or used. Attributes: source, element.

    Example:
        >>> issubclass(MjcfError, InputError)
        True
    """

    source: str
    element: str


class SceneFileError(InputError):
    """A scene file with faults. Attributes: path, faults (one sentence each).

    Example:
        >>> from impulsekit import load_scene
        >>> try:
        ...     _ = load_scene("models/ball.urdf")
        ... except SceneFileError as error:
        ...     print(len(error.faults))
        1
    """

    path: str
    faults: tuple[str, ...]


class SolveError(ImpulsekitError):
    """The input is fine, but the physics asked for has no solution.

    Example:
        >>> issubclass(SingularMassError, SolveError) and issubclass(ContradictionError, SolveError)
        True
    """


class SingularMassError(SolveError):
    """The mass matrix is singular. Attributes: joints (those without inertia).

    Example:
        >>> from impulsekit import AppliedImpulse, Robot, Scene, solve
        >>> hinge = "<joint name='hinge' type='continuous'><parent link='a'/><child link='b'/>"
        >>> text = f"<robot name='r'><link name='a'/><link name='b'/>{hinge}</joint></robot>"
        >>> robot = Robot.from_urdf(text)
        >>> scene = Scene(robot, [AppliedImpulse("b", angular=[0, 0, 1])])
        >>> try:
        ...     _ = solve(scene, robot.neutral(), [0.0])
        ... except SingularMassError as error:
        ...     print(error.joints)
        ('hinge',)
    """

    joints: tuple[str, ...]


class ContradictionError(SolveError):
    """Demands that cannot hold together. Attributes: rows (their names).

    Example:
        >>> from impulsekit import JointLock, Robot, Scene, solve
        >>> from impulsekit.models import pendulum_urdf
        >>> rod = Robot.from_urdf(pendulum_urdf(1))
        >>> locks = [JointLock("joint_1"), JointLock("joint_1", velocity=1.0, name="driven")]
        >>> try:
        ...     _ = solve(Scene(rod, constraints=locks), rod.neutral(), rod.velocity())
        ... except ContradictionError as error:
        ...     print(len(error.rows))
        2
    """

    rows: tuple[str, ...]


class FileError(ImpulsekitError, OSError):
    """A file that cannot be read or written. Attributes: path.

    Example:
        >>> from impulsekit import Robot, Scene, save_scene
        >>> try:
        ...     save_scene("no_such_folder/scene.toml", Scene(Robot.from_example("panda")))
        ... except FileError as error:
        ...     print(error.path)
        no_such_folder/scene.toml
    """

    path: str


class MissingExtraError(ImpulsekitError, ImportError):
    """An optional library is not installed. Attributes: package, extra.

    Example:
        >>> print(MissingExtraError.of("mujoco", "mjcf", "reading MJCF"))
        reading MJCF needs mujoco: pip install ".[mjcf]" in impulsekit's folder
    """

    package: str
    extra: str

    @classmethod
    def of(cls, package: str, extra: str, purpose: str) -> MissingExtraError:
        """Return the error that names the line to install ``package`` with."""
        return cls(
            f'{purpose} needs {package}: pip install ".[{extra}]" in impulsekit\'s folder',
            package=package,
            extra=extra,
        )

    @classmethod
    @contextmanager
    def unless(cls, package: str, extra: str, purpose: str) -> Iterator[None]:
        """Raise this error if a package imported within is missing; as ``of``."""
        try:
            yield
        except ImportError:
            raise cls.of(package, extra, purpose) from None
