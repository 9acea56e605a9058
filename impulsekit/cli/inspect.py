"""``impulsekit inspect``: what a robot's file holds, or whether a folder of them works."""

from __future__ import annotations

import pathlib
import warnings
from collections import Counter
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from ..robot import Robot

__all__ = ["inspect", "try_robot"]

ROOTS = ("fixed", "planar", "freeflyer")
FOREIGN, DISAGREES = "with an error that is not ours", "that the check contradicts"
# Limits as large as this are written where a joint has none [rad, m].
UNLIMITED = 1e15


@click.command()
@click.argument("path")
@click.option("--root", type=click.Choice(ROOTS), help="Between the world and the root link.")
@click.option("--replay/--no-replay", default=False, help="Of a folder: draw each robot, too.")
def inspect(path: str, root: str | None, replay: bool) -> None:
    """Show links, joints, masses and what was assumed of a robot's file.

    PATH is a URDF, xacro, MJCF or SDF file, the name of an example robot, or a folder: then
    each robot file below it is loaded, struck, solved and checked under both roots, and the
    results are a table.
    """
    if pathlib.Path(path).is_dir():
        _inspect_folder(pathlib.Path(path), root, replay)
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
    from ..view.table import table

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


def _inspect_folder(folder: pathlib.Path, root: str | None, replay: bool) -> None:
    from ..robot.any_file import SUFFIXES
    from ..view.table import table

    files = sorted(path for path in folder.rglob("*") if path.suffix.lower() in SUFFIXES)
    rows, kinds = [], Counter[str]()
    for path in files:
        for each in (root,) if root else ("fixed", "freeflyer"):
            kind, *result = try_robot(path, each, replay)
            kinds[kind] += 1
            rows.append([str(path.relative_to(folder)), each, *result])
    head = ["file", "root", "nv", "solve", "check", *(["replay"] if replay else []), "says"]
    if rows:
        click.echo("\n".join(table(head, rows)))
    counts = ", ".join(f"{count} {kind}" for kind, count in kinds.most_common())
    click.echo(f"{len(files)} files, each under {1 if root else 2} roots: {counts}")
    if kinds[FOREIGN] or kinds[DISAGREES]:
        raise click.exceptions.Exit(1)


def try_robot(path: pathlib.Path, root: str, replay: bool) -> list[str]:
    """The kind of outcome, what each step says, and the first fault.

    Args:
        path: a robot file.
        root: "fixed", "planar" or "freeflyer".
        replay: whether a page is drawn, too.
    """
    from .. import AppliedImpulse, check, solve
    from ..errors import ImpulsekitError, SingularMassError
    from ..robot import Robot
    from ..robot.robot import WORLD, WORLD_LINK

    steps = {"nv": "", "solve": "", "check": "", **({"replay": ""} if replay else {})}
    says = ""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            robot = Robot.from_file(path, root)
            steps["nv"] = str(robot.nv)
            moving = [link for link in robot.links if link.joint_id > 0]
            if not moving:
                return ["that cannot move", *steps.values(), "nothing in it can move"]
            heaviest = max(moving, key=lambda link: link.mass).name
            struck = WORLD_LINK if heaviest == WORLD else heaviest
            scene = robot.scene(impulses=[AppliedImpulse(struck, linear=[1, 2, 3])])
            impact = solve(scene, robot.neutral(), robot.velocity())
            steps["solve"] = impact.status.name
            steps["check"] = "agrees" if check(impact).agrees else "NO"
            if replay:
                steps["replay"] = _drawn(impact)
    except SingularMassError as error:
        return ["with a joint that moves no mass", *steps.values(), _one_line(error)]
    except ImpulsekitError as error:
        kind = "not solved or checked" if steps["nv"] else "refused"
        return [kind, *steps.values(), _one_line(error)]
    except Exception as error:  # what must not happen is what the table is for
        return [FOREIGN, *steps.values(), f"{type(error).__name__}: {_one_line(error)}"]
    return ["checked" if steps["check"] == "agrees" else DISAGREES, *steps.values(), says]


def _drawn(impact: Any) -> str:
    import tempfile

    from ..view.replay import replay

    with tempfile.TemporaryDirectory() as folder:
        replay(impact, pathlib.Path(folder) / "page.html")
    return "drawn"


def _one_line(error: Exception) -> str:
    text = " ".join(str(error).split())
    return text if len(text) <= 160 else text[:157] + "..."
