"""The base of the entries of a scene: fields checked when made, names checked against a robot."""

from __future__ import annotations

import functools
import typing
from collections.abc import Sequence
from dataclasses import fields
from typing import Annotated, Any, ClassVar

from ..errors import InputError, ShapeError
from ..formatting import Displayed
from ..robot import Robot
from ..robot.base import WORLD
from .numbers import Check, optional, text


class Checked:
    """A frozen dataclass whose fields are kept as the checks in their types give them.

    A type is ``Annotated`` with a function of the value and of what it is called.

    Attributes:
        wording: begins the sentences of errors, with the class and names among the fields in
            braces.
    """

    wording: ClassVar[str] = "{kind}"

    def __post_init__(self) -> None:
        own: Any = type(self)
        names, others, wording = _checks_of(own)
        given = vars(self)
        _keep(given, own.__name__, names)
        what = wording.format_map(given)
        _keep(given, what, others)
        self._check(what)

    def _check(self, what: str) -> None:
        """Check what no field has by itself; ``what`` begins the sentences."""

    def check_robot(self, robot: Robot, where: str) -> None:
        """Check that it fits a robot; ``where`` begins the sentences.

        Raises:
            UnknownNameError: a frame or joint that the robot does not have.
            InputError: it would act within one rigid body, or in a joint of another kind.
            ShapeError: as many numbers as the joint does not have degrees of freedom.
        """


# The name of a field, its check and its default.
_Check = tuple[str, Check, Any]


def _keep(given: dict[str, Any], what: str, checks: list[_Check]) -> None:
    for name, check, default in checks:
        # A default is kept as its check gives it.
        if given[name] is not default:
            given[name] = check(given[name], f"{what}: {name}")


@functools.cache
def _checks_of(kind: Any) -> tuple[list[_Check], list[_Check], str]:
    """The checks of the fields that are names, those of the others, and the wording of the kind."""
    hints = typing.get_type_hints(kind, include_extras=True)
    found = [(item.name, _check_of(hints[item.name]), item.default) for item in fields(kind)]
    names: list[_Check] = [(n, check, value) for n, check, value in found if check is text]
    others = [(n, check, value) for n, check, value in found if check not in (text, None)]
    return names, others, kind.wording.replace("{kind}", kind.__name__)


def _check_of(hint: Any) -> Check | None:
    if typing.get_origin(hint) is Annotated:
        return next((check for check in hint.__metadata__ if callable(check)), None)
    options = typing.get_args(hint)
    if len(options) != 2 or type(None) not in options:
        return None
    check = next(filter(None, map(_check_of, options)), None)
    return None if check is None else optional(check)


class Entry(Checked, Displayed):
    """An entry of a scene.

    Attributes:
        section: the list of ``Scene`` that it belongs to.
    """

    section: ClassVar[str] = ""

    @property
    def frame_names(self) -> tuple[str, ...]:
        """The frames it acts on."""
        return ()

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The joints it acts in."""
        return ()


class BetweenFrames(Entry):
    """One that acts between two points, each in its frame."""

    wording = '{kind} of "{frame}" to "{other}"'
    # Why both ends are to be on two bodies, and in two frames.
    within: ClassVar[str] = ""
    alone: ClassVar[str] = ""
    frame: str
    other: str

    def _check(self, what: str) -> None:
        if self.frame == self.other:
            raise InputError(f"{what}: {self.alone}")

    @property
    def frame_names(self) -> tuple[str, ...]:
        """The frames it acts on."""
        return (self.frame, self.other)

    def check_robot(self, robot: Robot, where: str) -> None:
        """Check that a robot has both frames, on two bodies."""
        check_two_bodies(robot, self.frame_names, where, self.within)


class InJoint(Entry):
    """One that acts in a joint."""

    wording = '{kind} of "{joint}"'
    joint: str

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The joints it acts in."""
        return (self.joint,)

    def check_robot(self, robot: Robot, where: str) -> None:
        """Check that a robot has the joint, with one degree of freedom."""
        check_one_degree(robot, self.joint, where, f"a {type(self).__name__}")

    def check_length(self, robot: Robot, where: str, numbers: Any, what: str) -> None:
        """Check that a tuple of numbers has one for each degree of freedom of the joint."""
        count = robot.model.joints[robot.joint_id(self.joint, where)].nv
        if isinstance(numbers, tuple) and len(numbers) != count:
            raise ShapeError.of(f'{where}: {what} joint "{self.joint}"', (count,), (len(numbers),))


def check_two_bodies(robot: Robot, frames: Sequence[str], where: str, why: str) -> None:
    """Check that a robot has both frames, on two bodies; ``why`` else nothing happens.

    Raises:
        UnknownNameError: a frame that the robot does not have.
        InputError: both are on one rigid body.
    """
    first, other = frames
    joints = [robot.frame(name, where).joint_id for name in frames]
    if joints[0] == joints[1]:
        body = "the world" if joints[0] == 0 else "one rigid body"
        raise InputError(f'{where}: "{first}" and "{other}" both belong to {body}; {why}')


def check_frame_moves(robot: Robot, frame: str, where: str, what: str, advice: str = "") -> None:
    """Check that a robot has a frame, and that it can move.

    Raises:
        UnknownNameError: the robot does not have it.
        InputError: it is fixed to the world.
    """
    if robot.frame(frame, where).joint_id == 0:
        whole = "the world" if frame == WORLD else f'"{frame}", fixed to the world,'
        raise InputError(f"{where}: {what} on {whole} moves nothing{advice and '; ' + advice}")


def check_one_degree(robot: Robot, joint: str, where: str, what: str) -> None:
    """Check that a joint moves, with one degree of freedom.

    Raises:
        UnknownNameError: the robot does not have it.
        InputError: it is fixed, or has several.
    """
    count = robot.model.joints[robot.joint_id(joint, where)].nv
    if count != 1:
        raise InputError(
            f'{where}: joint "{joint}" has {count} degrees of freedom, {what} takes a joint with '
            "one"
        )
