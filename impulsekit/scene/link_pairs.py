"""``collisions``: every pair of links that may meet, as entries of a scene."""

from __future__ import annotations

import fnmatch
from collections.abc import Iterable, Iterator, Sequence
from itertools import product
from typing import TYPE_CHECKING, NamedTuple, TypedDict

import pinocchio as pin

from ..errors import InputError, UnknownNameError, check_kind, quoted, warn_of_setup
from ..errors.calls import public
from ..robot import Robot
from .contacts import Collision
from .numbers import text
from .overlaps import overlaps, sentence_on

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Literal, Unpack

    from .coefficients import Friction

# A note names so many links.
NAMED = 6


class PairCoefficients(TypedDict, total=False):
    """Coefficients of ``Collision``, for editors."""

    restitution: float | Callable[[float], float] | Literal["material"]
    friction: Friction | Literal["material"]
    tangential_restitution: float
    margin: float | None
    stiffness: float | None
    stiffness_ratio: float | None
    tangential_damping: float | None
    rolling: float
    torsion: float


class _Body(NamedTuple):
    """A link with geometry, or a piece that is fixed in the world.

    Attributes:
        name: of the link or of the piece.
        joint: that carries it.
        group: the joint; of links that are welded to the world, their topmost link.
        above: the group that its joint hangs on; None for one that hangs on the world itself.
    """

    name: str
    joint: int
    group: tuple[int, int]
    above: tuple[int, int] | None


@public
def collisions(
    robot: Robot,
    first: str | Iterable[str] = "*",
    other: str | Iterable[str] = "*",
    *,
    exclude: Iterable[tuple[str, str]] = (),
    **coefficients: Unpack[PairCoefficients],
) -> list[Collision]:
    """Return a ``Collision`` for every pair of links that may meet, all with one set of numbers.

    Pairs are left out that belong to one rigid body, that one joint connects, that the robot's
    SRDF disables, or that overlap in the neutral or a named pose (``robot.poses``), as bodies of
    neighbouring links often do; links without collision geometry are skipped. Pairs whose boxes
    are apart cost a solve next to nothing.

    Args:
        robot: the robot, as ``combine`` makes it where there are several.
        first, other: names of links, or of pieces fixed in the world such as "ground"; "*" stands
            for any text, as in "arm/*". Either may be a list. With the same names twice, as by
            default, the links collide among themselves.
        exclude: pairs of names that do not collide, "*" as above.
        **coefficients: ``restitution``, ``friction`` and the other numbers of a ``Collision``.

    Returns:
        The entries, for ``Scene(contacts=...)``; each is named "FIRST with OTHER".

    Raises:
        UnknownNameError: no link or piece of geometry has such a name.
        InputError: nothing is left of the pairs.

    Warns:
        SetupWarning: links that have a mass, and no geometry; pairs left out since they overlap.

    Example:
        >>> from impulsekit import combine
        >>> arm = Robot.from_example("ur5")
        >>> two = combine(left=arm, right=arm, placements={"right": [0.9, 0, 0]})
        >>> pairs = collisions(two, "left/*", "right/*", friction=0.3)
        >>> len(pairs), pairs[0].name
        (63, 'left/base_link with right/shoulder_link')
    """
    check_kind(robot, Robot, "collisions")
    bodies, bare = _bodies(robot)
    patterns = [_patterns(names) for names in (first, other)]
    sides = [_chosen(robot, names, bodies, bare) for names in patterns]
    pairs: dict[frozenset[str], tuple[str, str]] = {}
    for one, two in product(*sides):
        if one.joint != two.joint and one.group != two.above and two.group != one.above:
            pairs.setdefault(frozenset((one.name, two.name)), (one.name, two.name))
    for pair in (*robot.disabled_pairs, *_excluded(robot, exclude, bodies, bare)):
        pairs.pop(pair, None)
    overlapping = overlaps(robot, pairs.values())
    found = [
        Collision(one, two, name=f"{one} with {two}", **coefficients)
        for one, two in pairs.values()
        if (one, two) not in overlapping
    ]
    if not found:
        raise InputError(
            "collisions: no pair is left: links of one rigid body, links that one joint connects, "
            "pairs that the SRDF disables, and pairs that overlap in the neutral pose do not "
            "collide; robot.with_ground() gives a ground"
        )
    named = {name for names in patterns for one in names for name in fnmatch.filter(bare, one)}
    without = [name for name in bare if name in named]
    sentences = sentence_on(overlapping)
    if without:
        more = f" and {len(without) - NAMED} more" if len(without) > NAMED else ""
        names = ", ".join(f'"{name}"' for name in without[:NAMED])
        sentences.append(f"links without collision geometry do not collide: {names}{more}")
    warn_of_setup(sentences)
    return found


def _patterns(names: str | Iterable[str]) -> tuple[str, ...]:
    return tuple(
        text(name, "collisions: the name of a link")
        for name in ((names,) if isinstance(names, str) else names)
    )


def _excluded(
    robot: Robot, exclude: Iterable[tuple[str, str]], bodies: list[_Body], bare: list[str]
) -> Iterator[frozenset[str]]:
    """The pairs that the user excludes."""
    for pair in (exclude,) if isinstance(exclude, str) else exclude:
        if isinstance(pair, str) or not isinstance(pair, Sequence) or len(pair) != 2:
            raise InputError(
                f'collisions: exclude takes pairs of names, as in [("base", "thigh")], got '
                f"{quoted(pair)}"
            )
        for one, two in product(*(_chosen(robot, _patterns(name), bodies, bare) for name in pair)):
            yield frozenset((one.name, two.name))


def _bodies(robot: Robot) -> tuple[list[_Body], list[str]]:
    """The bodies with geometry, in the order of the links; and links with mass that have none."""
    model, objects = robot.model, robot.collision_model.geometryObjects
    with_geometry = {item.parentFrame for item in objects}
    found: list[_Body] = []
    bare = []
    for link in robot.links:
        if link.frame_id in with_geometry:
            joint = link.joint_id
            group = _group(model, link.frame_id)
            above = _group(model, model.frames[_frame_of(model, joint)].parentFrame)
            found.append(_Body(link.name, joint, group, above if joint and above[1] else None))
        elif link.mass > 0.0:
            bare.append(link.name)
    # Behind the links, so that these receive the impulses.
    fixed = [_Body(item.name, 0, (0, 0), None) for item in objects if item.parentFrame == 0]
    return found + fixed, bare


def _frame_of(model: pin.Model, joint_id: int) -> int:
    """The frame of a joint itself."""
    return int(model.getFrameId(model.names[joint_id], pin.FrameType.JOINT)) if joint_id else 0


def _group(model: pin.Model, frame_id: int) -> tuple[int, int]:
    """The joint that carries a frame, or of the world's the frame that stands on the world."""
    joint = model.frames[frame_id].parentJoint
    if joint:
        return joint, joint
    while model.frames[frame_id].parentFrame:
        frame_id = model.frames[frame_id].parentFrame
    return 0, frame_id


def _chosen(
    robot: Robot, names: Iterable[str], bodies: list[_Body], bare: list[str]
) -> list[_Body]:
    """The bodies that fit one of the names."""
    found: dict[str, _Body] = {}
    for name in names:
        own = [body for body in bodies if fnmatch.fnmatchcase(body.name, name)]
        if not own and fnmatch.filter(bare, name):
            raise InputError(f'collisions: "{name}" names links without collision geometry')
        if not own:
            known = dict.fromkeys((*robot.link_names, *(body.name for body in bodies)))
            raise UnknownNameError.among("link or geometry", name, known, "collisions")
        found.update({body.name: body for body in own})
    return list(found.values())
