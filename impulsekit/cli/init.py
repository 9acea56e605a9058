"""``impulsekit init``: a first scene file, ready to solve and to change."""

from __future__ import annotations

import click

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
