"""``impulsekit inspect``: what a robot's file holds, or whether a folder of them works."""

from __future__ import annotations

import pathlib
import warnings
from collections.abc import Iterator
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from ..robot import Robot

__all__ = ["inspect"]

ROOTS = ("fixed", "planar", "sagittal", "freeflyer")
# Under these each robot of a folder is tried.
TRIED = ("fixed", "freeflyer")
# Limits as large as this are written where a joint has none [rad, m].
UNLIMITED = 1e15


@click.command()
@click.argument("path")
@click.option("--root", type=click.Choice(ROOTS), help="Between the world and the root link.")
@click.option("--replay/--no-replay", default=False, help="Of a folder: draw each robot, too.")
@click.option(
    "--others/--no-others",
    default=False,
    help="Of a folder: say which refused files Pinocchio and MuJoCo read.",
)
def inspect(path: str, root: str | None, replay: bool, others: bool) -> None:
    """Show links, joints, masses and what was assumed of a robot's file.

    PATH is a URDF, xacro, MJCF or SDF file, the name of an example robot, or a folder: then
    each robot file below it is loaded, struck, solved and checked under both roots, and the
    results are a table.
    """
    if pathlib.Path(path).is_dir():
        from .try_folder import try_folder

        try_folder(pathlib.Path(path), (root,) if root else TRIED, replay=replay, others=others)
        return
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
    from ..display.table import table

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
