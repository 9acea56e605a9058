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

import warnings
from collections.abc import Iterable, Sequence
from typing import Any

__all__ = [
    "AssumptionWarning",
    "ContradictionError",
    "FileError",
    "ImpulsekitError",
    "InputError",
    "MissingExtraError",
    "MjcfError",
    "NotFiniteError",
    "RangeError",
    "SceneFileError",
    "SetupWarning",
    "ShapeError",
    "SingularMassError",
    "SolveError",
    "StateError",
    "UnknownNameError",
    "UrdfError",
    "a_thing",
    "nearest_names",
    "quoted",
    "shown",
    "warn_of_assumptions",
    "warn_of_setup",
]


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
        super().__init__(_escaped(message))
        self.__dict__.update(data)

    def __getattr__(self, name: str) -> Any:
        raise AttributeError(f"{type(self).__name__} carries no {name!r}")


class InputError(ImpulsekitError, ValueError):
    """Something given cannot be used.

    Example:
        >>> issubclass(UnknownNameError, InputError) and issubclass(InputError, ValueError)
        True
    """


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
    def among(cls, kind: str, name: str, known: Iterable[str], where: str = "") -> UnknownNameError:
        """The error for a ``name`` of a ``kind`` that is not ``known``."""
        names = tuple(known)
        nearest = nearest_names(name, names)
        if nearest:
            hint = "did you mean " + _one_of(nearest) + "?"
        elif not names:
            hint = "there are none"
        elif len(names) <= 12:
            hint = "choose " + _one_of(names)
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
        """The error for an array called ``what``."""
        tail = f" ({hint})" if hint else ""
        return cls(
            f"{what}: expected shape {_shape(expected)}, got {_shape(got)}{tail}",
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
        """The error for the entry ``where`` of ``what``."""
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
        """The error for ``what`` with ``value`` that must be ``allowed``, in words."""
        return cls(
            f"{what} must be {allowed}, got {value}", what=what, value=value, allowed=allowed
        )


class CallbackError(InputError):
    """A user's function raised, or gave no real numbers. Attributes: entry.

    Example:
        >>> from impulsekit import Actuator, Robot, Scene, simulate
        >>> from impulsekit.models import pendulum_urdf
        >>> rod = Robot.from_urdf(pendulum_urdf(1))
        >>> motor = Actuator("joint_1", lambda t, q, v: 1 / 0)
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
        >>> ends = "<parent link='a'/><child link='b'/>"
        >>> links = f"<link name='a'/><link name='b'/>"
        >>> hinge = f"<joint name='hinge' type='continuous'>{ends}</joint>"
        >>> robot = Robot.from_urdf(f"<robot name='r'>{links}{hinge}</robot>")
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
        reading MJCF needs mujoco: pip install "impulsekit[mjcf]"
    """

    package: str
    extra: str

    @classmethod
    def of(cls, package: str, extra: str, purpose: str) -> MissingExtraError:
        """The error that names the line to install ``package`` with."""
        return cls(
            f'{purpose} needs {package}: pip install "impulsekit[{extra}]"',
            package=package,
            extra=extra,
        )


class AssumptionWarning(UserWarning):
    """A file leaves something open; the sentence says what was assumed.

    Attributes: source (the file), assumptions (one sentence each).

    Example:
        >>> print(AssumptionWarning("arm.urdf", ["link tool has no mass"]))
        arm.urdf: assumed: link tool has no mass
    """

    def __init__(self, source: str, assumptions: Sequence[str]) -> None:
        self.source, self.assumptions = source, tuple(assumptions)
        # What another process makes a copy of: the arguments, not the sentence made of them.
        super().__init__(source, self.assumptions)

    def __str__(self) -> str:
        return _escaped(f"{self.source}: assumed: " + "; ".join(self.assumptions))


def warn_of_assumptions(source: str, assumptions: Sequence[str], *, above: int = 2) -> None:
    """One ``AssumptionWarning`` for a file, if anything was assumed.

    ``above`` is how many frames stand between this call and the user's line.

    Example:
        >>> with warnings.catch_warnings(record=True, action="always") as told:
        ...     warn_of_assumptions("arm.urdf", ["link tool has no mass"])
        >>> told[0].category.__name__
        'AssumptionWarning'
    """
    if assumptions:
        warnings.warn(AssumptionWarning(source, assumptions), stacklevel=1 + above)


# More sentences than this are a page, not a warning.
MOST_DOUBTS = 4


class SetupWarning(UserWarning):
    """A scene or a state that is solved as given, and likely is not what was meant.

    Attributes: doubts (one sentence each).

    Example:
        >>> print(SetupWarning(["contact floor is 0.2 m open"]))
        contact floor is 0.2 m open
    """

    def __init__(self, doubts: Sequence[str]) -> None:
        self.doubts = tuple(doubts)
        super().__init__(self.doubts)

    def __str__(self) -> str:
        more = len(self.doubts) - MOST_DOUBTS
        tail = [f"and {more} more, see Impact.doubts"] if more > 0 else []
        return _escaped("; ".join([*self.doubts[:MOST_DOUBTS], *tail]))


def warn_of_setup(doubts: Sequence[str], *, above: int = 2) -> None:
    """One ``SetupWarning`` if there is any doubt; ``above`` as for ``warn_of_assumptions``.

    Example:
        >>> with warnings.catch_warnings(record=True, action="always") as told:
        ...     warn_of_setup([])
        >>> told
        []
    """
    if doubts:
        warnings.warn(SetupWarning(doubts), stacklevel=1 + above)


def shown(value: object, most: int = 60) -> str:
    """Text as it is, anything else as Python writes it: printable, on one line, not too long.

    What is in memory at some address is called by its type.

    Example:
        >>> shown("a\\x1b[31m")
        'a\\\\x1b[31m'
    """
    try:
        value = value.__name__ if isinstance(value, type) else value
        text = value if isinstance(value, str) else repr(value)
    except Exception:  # a whole number of thousands of digits, or a user's own repr
        text = f"a {type(value).__name__}"
    if not isinstance(value, str) and " at 0x" in text:
        text = "a function" if callable(value) else f"a {type(value).__name__}"
    line = _escaped(text[: most + 1]).replace("\n", "\\n")
    return line if len(line) <= most else line[: most - 3] + "..."


def quoted(value: object, most: int = 60) -> str:
    """The same with quotes around a text.

    Example:
        >>> quoted("a"), quoted(1.5), quoted(print)
        ('"a"', '1.5', '<built-in function print>')
    """
    return f'"{shown(value, most - 2)}"' if isinstance(value, str) else shown(value, most)


def _escaped(text: str) -> str:
    """Text whose control characters, line ends apart, are written out."""
    if text.isprintable():
        return text
    return "".join(
        c if c.isprintable() or c == "\n" else c.encode("unicode_escape").decode() for c in text
    )


def a_thing(value: object) -> str:
    """The type of a value with its article.

    Example:
        >>> a_thing([]), a_thing(KeyError())
        ('a list', 'a KeyError')
    """
    if value is None:
        return "None"
    name = type(value).__name__
    return f"{'an' if name[:1] in 'AEIOUaeiou' else 'a'} {name}"


def _shape(shape: Sequence[Any]) -> str:
    """A shape as numpy writes it; an axis without a number by its letter."""
    return "(" + ", ".join(map(str, shape)) + (",)" if len(shape) == 1 else ")")


def _one_of(names: Sequence[str]) -> str:
    """Names in quotes, the last after an "or"."""
    *first, last = (f'"{name}"' for name in names)
    return f"{', '.join(first)} or {last}" if first else last


def nearest_names(name: str, known: Iterable[str], most: int = 3) -> tuple[str, ...]:
    """The names in ``known`` that look most like ``name``, best first.

    Example:
        >>> nearest_names("elbwo", ["shoulder", "elbow", "wrist"])
        ('elbow',)
    """
    import difflib

    names = list(known)
    folded: dict[str, str] = {}
    for candidate in names:
        folded.setdefault(candidate.lower(), candidate)
    hits = difflib.get_close_matches(str(name).lower(), list(folded), n=most, cutoff=0.6)
    if not hits:
        hits = [key for key in folded if name and str(name).lower() in key][:most]
    return tuple(folded[hit] for hit in hits)
