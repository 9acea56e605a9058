"""``impulsekit robots``: the robots that example-robot-data brings along."""

from __future__ import annotations

import click

__all__ = ["robots"]


@click.command()
@click.option("--long", "-l", is_flag=True, help="With nq, nv (on a fixed root) and the file.")
def robots(long: bool) -> None:
    """List the robots that a scene file may name, one a line."""
    from ..robot.examples import data_folder, example_names, example_path

    if not long:
        click.echo("\n".join(example_names()))
        return
    from ..errors import ImpulsekitError
    from ..robot import Robot
    from ..view.table import table

    folder = data_folder() / "robots"
    rows = []
    for name in example_names():
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
