"""``impulsekit robots`` and ``inspect`` show robots, ``init`` writes a first scene file for one."""

from __future__ import annotations

import pathlib
import warnings
from collections.abc import Iterator
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from ..robot import Robot


@click.command()
@click.argument("pattern", default="")
@click.option("--long", "-l", is_flag=True, help="With nq, nv (on a fixed root) and the file.")
def robots(pattern: str, long: bool) -> None:
    """List the robots that need no file; with PATTERN those whose name matches.

    PATTERN is a part of the name, or a shell pattern such as "ur*".
    """
    import fnmatch

    from ..errors import InputError, shown
    from ..robot.examples import data_folder, example_names, example_path

    wild = any(character in pattern for character in "*?[")
    sought = pattern.lower() if wild else f"*{pattern.lower()}*"
    names = [name for name in example_names() if fnmatch.fnmatchcase(name.lower(), sought)]
    if not names:
        raise InputError(f'no example robot matches "{shown(pattern, 80)}"')
    if not long:
        click.echo("\n".join(names))
        return
    from ..errors import ImpulsekitError
    from ..formatting import table
    from ..robot import Robot

    folder = data_folder() / "robots"
    rows = []
    for name in names:
        try:
            robot = Robot.from_example(name)
        except ImpulsekitError as error:
            click.echo(f"{name}: {error}", err=True)
            continue
        rows.append(
            [name, str(robot.nq), str(robot.nv), str(example_path(name).relative_to(folder))]
        )
    click.echo(f"Files are in {folder}")
    click.echo("\n".join(table(["name", "nq", "nv", "file"], rows)))


ROOTS = ("fixed", "planar", "sagittal", "freeflyer")
# Limits as large as this are written where a joint has none [rad, m].
UNLIMITED = 1e15


@click.command()
@click.argument("path")
@click.option("--root", type=click.Choice(ROOTS), help="Between the world and the root link.")
def inspect(path: str, root: str | None) -> None:
    """Show links, joints, masses and what was assumed of a robot's file.

    PATH is a URDF, MJCF or SDF file, or the name of an example robot.
    """
    from ..robot import Robot
    from ..robot.examples import example_names

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        file = pathlib.Path(path)
        if not file.exists() and (path in example_names() or not file.suffix):
            robot = Robot.from_example(path, root or "fixed")
        else:
            robot = Robot.from_file(path, root)
    click.echo("\n".join(_described(robot)))


def _described(robot: Robot) -> Iterator[str]:
    from ..formatting import table

    sizes = f"{len(robot.links)} links, {robot.nv} degrees of freedom"
    yield f"{robot.name}: {sizes}, {robot.mass:.6g} kg in motion"
    yield ""
    if robot.links:
        names = list(robot.model.names)
        rows = [
            [link.name, f"{link.mass:.6g}", names[link.joint_id] if link.joint_id else "world"]
            for link in robot.links
        ]
        yield from table(["link", "mass kg", "moved by"], rows)
        yield ""
    if robot.joint_names:
        yield from table(
            ["joint", "kind", "lower", "upper", "armature"],
            [_joint_row(robot, name) for name in robot.joint_names],
        )
        yield ""
    for title, sentences in (
        ("Assumed", robot.assumptions),
        ("Closed loops", tuple(f"{loop.name} ({loop.kind})" for loop in robot.loops)),
        ("Moves no mass", tuple(str(motion) for motion in robot.massless_motions)),
    ):
        if sentences:
            yield f"{title}:"
            yield from (f"  {sentence}" for sentence in sentences)


def _joint_row(robot: Robot, name: str) -> list[str]:
    model = robot.model
    joint = model.joints[robot.joint_id(name)]
    kind = joint.shortname().removeprefix("JointModel")
    bounds = ["-", "-"]
    if joint.nq == 1:
        values = (model.lowerPositionLimit[joint.idx_q], model.upperPositionLimit[joint.idx_q])
        bounds = [f"{v:.6g}" if abs(v) < UNLIMITED else "none" for v in values]
    armature = max(model.armature[joint.idx_v : joint.idx_v + joint.nv], default=0.0)
    return [name, kind, *bounds, f"{armature:.6g}"]


FIRST_SCENE = """\
# A first scene: a robot arm is struck on its flange.
#   impulsekit solve {name}                     velocities, joint loads, energy
#   impulsekit solve {name} --html page.html    the same as an interactive replay
#   impulsekit simulate {name}                  the motion that follows

[robot]
example = "{robot}"                  # "impulsekit robots" lists more; or urdf = "my_robot.urdf"
root = "{root}"                 # fixed, planar, sagittal or freeflyer
{state}
[[impulses]]                     # what strikes: N s and N m s, world axes, at a point of a frame
name = "blow"
frame = "{frame}"
linear = [0, 0, -2]
at = [0, 0, 0]

# Remove the "#" to add a brake that holds while the blow acts:
# [[constraints]]
# kind = "joint_lock"
# joint = "{joint}"

# Or a contact with the floor, the plane z = 0 of the world:
# [[contacts]]
# name = "floor"
# kind = "contact"
# frame = "{frame}"
# friction = 0.5

[motion]                         # of "impulsekit simulate"
duration = 0.5                   # s

[[report.points]]                # points whose velocity the report shows
label = "struck point"
frame = "{frame}"
"""
PANDA_STATE = """
[state.q]                        # by joint name [rad, m]; joints not named stay neutral
panda_joint2 = 0.3
panda_joint4 = -1.8
"""


@click.command()
@click.argument("file", type=click.Path())
@click.option("--robot", default="panda", show_default=True, help="An example robot by name.")
@click.option(
    "--root",
    type=click.Choice(["fixed", "planar", "sagittal", "freeflyer"]),
    default="fixed",
    show_default=True,
    help="How its base is held.",
)
@click.option("--force", is_flag=True, help="Replace FILE if it exists.")
def init(file: str, robot: str, root: str, force: bool) -> None:
    """Write a first scene to FILE (TOML), with comments on every entry."""
    import shlex
    from pathlib import Path

    from ..errors import FileError, shown
    from ..files import write_file
    from ..robot import Robot

    model = Robot.from_example(robot, root)
    if not force and Path(file).exists():
        raise FileError(f"{shown(file, 200)}: the file exists; --force replaces it", path=file)
    # The last link is the tool of an arm, or the tip of some limb.
    frame = "panda_hand" if robot == "panda" else model.links[-1].name
    moving = [joint for joint in model.joint_names if joint != "root_joint"]
    text = FIRST_SCENE.format(
        name=shlex.quote(shown(Path(file).name, 80)),
        robot=robot,
        root=root,
        state=PANDA_STATE if robot == "panda" else "",
        frame=frame,
        joint=moving[-1] if moving else "root_joint",
    )
    write_file(file, text)
    command = shlex.join(["impulsekit", "solve", file])
    click.echo(f"wrote {shown(file, 200)}; solve it: {shown(command, 240)}")
