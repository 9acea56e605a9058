"""``impulsekit robots`` lists the example robots, ``impulsekit inspect`` shows a robot."""

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
    from ..display import table
    from ..errors import ImpulsekitError
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

    PATH is a URDF, xacro, MJCF or SDF file, or the name of an example robot.
    """
    from ..robot import Robot
    from ..robot.examples import example_names

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        if not pathlib.Path(path).exists() and path in example_names():
            robot = Robot.from_example(path, root or "fixed")
        else:
            robot = Robot.from_file(path, root)
    click.echo("\n".join(_described(robot)))


def _described(robot: Robot) -> Iterator[str]:
    from ..display import table

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
