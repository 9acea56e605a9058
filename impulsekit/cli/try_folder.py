"""Every robot file of a folder, loaded, struck, solved, checked and drawn: a table."""

from __future__ import annotations

import pathlib
import subprocess
import sys
import warnings
from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING

import click

from ..errors import ImpulsekitError

if TYPE_CHECKING:
    from ..impact import Impact

__all__ = ["try_folder", "try_robot"]

CHECKED, REFUSED, EMPTY = "checked", "refused", "without a robot in it"
FOREIGN, DISAGREES = "with an error that is not ours", "that the check contradicts"
# What the outermost element of a robot file may be.
OUTERMOST = ("robot", "mujoco", "sdf", "gazebo", "model", "world")
# What another reader gets to say before it is given up [s].
PATIENCE = 60.0
# Another program's reader may take the interpreter down, so it runs in one of its own.
_OTHERS = """
import sys
path, said = sys.argv[1], []
try:
    import pinocchio
    said.append(f"Pinocchio reads it (nv {pinocchio.buildModelFromUrdf(path).nv})")
except Exception:
    pass
try:
    import mujoco
    said.append(f"MuJoCo reads it (nv {mujoco.MjModel.from_xml_path(path).nv})")
except Exception:
    pass
sys.stdout.write("; ".join(said) or "Pinocchio and MuJoCo refuse it, too")
"""


def try_folder(
    folder: pathlib.Path, roots: Sequence[str], *, replay: bool = False, others: bool = False
) -> None:
    """Print the table of all robot files below a folder, and what became of them.

    Args:
        folder: where they are.
        roots: under each of which every file is tried.
        replay: whether each is drawn, too.
        others: whether Pinocchio and MuJoCo are asked to read what is refused.
    """
    from ..display.table import table
    from ..robot.any_file import SUFFIXES

    files = sorted(path for path in folder.rglob("*") if path.suffix.lower() in SUFFIXES)
    rows, kinds = [], Counter[str]()
    of_files: dict[str, set[pathlib.Path]] = {REFUSED: set(), EMPTY: set()}
    for path in files:
        for each in roots:
            kind, *result = try_robot(path, each, replay)
            kinds[kind] += 1
            of_files.setdefault(kind, set()).add(path)
            if others and kind == REFUSED and each == roots[0]:
                result[-1] += f" ({_said_by_others(path)})"
            rows.append([str(path.relative_to(folder)), each, *result])
    head = ["file", "root", "nv", "solve", "check", *(["replay"] if replay else []), "says"]
    if rows:
        click.echo("\n".join(table(head, rows)))
    counts = ", ".join(f"{count} {kind}" for kind, count in kinds.most_common())
    click.echo(
        f"{len(files)} files, each under {len(roots)} root{'s'[len(roots) == 1 :]}: {counts}"
    )
    holding, refused = len(files) - len(of_files[EMPTY]), len(of_files[REFUSED])
    if holding:
        share = 100.0 * refused / holding
        click.echo(f"{refused} of {holding} files with a robot in them are refused ({share:.1f} %)")
    if kinds[FOREIGN] or kinds[DISAGREES]:
        raise click.exceptions.Exit(1)


def try_robot(path: pathlib.Path, root: str | None, replay: bool) -> list[str]:
    """The kind of outcome, what each step says, and the first fault.

    Args:
        path: a robot file.
        root: "fixed", "planar", "sagittal" or "freeflyer"; None for that of the file.
        replay: whether a page is drawn, too.
    """
    from .. import AppliedImpulse, Scene, check, solve
    from ..errors import SingularMassError
    from ..robot import Robot
    from ..robot.base import WORLD, WORLD_LINK

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
            scene = Scene.of_robot(robot, impulses=[AppliedImpulse(struck, linear=[1, 2, 3])])
            impact = solve(scene, robot.neutral(), robot.velocity())
            steps["solve"] = impact.status.name
            checked = check(impact)
            steps["check"] = "agrees" if checked.agrees else "NO"
            if replay:
                steps["replay"] = _drawn(impact)
    except SingularMassError as error:
        return ["with a joint that moves no mass", *steps.values(), _one_line(error, path)]
    except ImpulsekitError as error:
        kind = REFUSED if not _is_empty(path, error) else EMPTY
        kind = "not solved or checked" if steps["nv"] else kind
        return [kind, *steps.values(), _one_line(error, path)]
    except Exception as error:  # what must not happen is what the table is for
        return [FOREIGN, *steps.values(), f"{type(error).__name__}: {_one_line(error, path)}"]
    return [CHECKED if steps["check"] == "agrees" else DISAGREES, *steps.values(), says]


def _is_empty(path: pathlib.Path, error: ImpulsekitError) -> bool:
    """Whether a refused file is no robot's: another kind of XML, or macros and no link."""
    from ..robot.any_file import outermost

    try:
        element = outermost(path.read_bytes())
    except OSError:
        return False
    return element not in OUTERMOST or "has no link" in str(error)


def _said_by_others(path: pathlib.Path) -> str:
    try:
        run = subprocess.run(
            [sys.executable, "-c", _OTHERS, str(path)],
            capture_output=True, text=True, timeout=PATIENCE, check=False,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return "other readers take longer than a minute"
    lines = run.stdout.strip().splitlines()
    return lines[-1] if lines else "another reader ends the interpreter"


def _drawn(impact: Impact) -> str:
    import tempfile

    from ..view.replay import replay

    with tempfile.TemporaryDirectory() as folder:
        replay(impact, pathlib.Path(folder) / "page.html")
    return "drawn"


def _one_line(error: Exception, path: pathlib.Path) -> str:
    text = " ".join(str(error).removeprefix(f"{path}: ").split())
    return text if len(text) <= 160 else text[:157] + "..."
