"""``impulsekit robots``: the robots of example-robot-data."""

from __future__ import annotations

import click

__all__ = ["robots"]


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
    from ..display.table import table
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
