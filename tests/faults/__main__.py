"""``python -m tests.faults``: the table of faults and the words they get."""

from __future__ import annotations

import pathlib

import click

from .table import faults_by_room, told_by_room, written

TABLE = pathlib.Path(__file__).with_name("faults.md")


@click.command()
@click.option("--output", "-o", default=str(TABLE), show_default=True, type=click.Path())
@click.pass_context
def main(ctx: click.Context, output: str) -> None:
    """Commit every fault and write down what the user gets; status 1 if one is not ours."""
    told = told_by_room()
    path = pathlib.Path(output)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(written(told), encoding="utf-8")
    stray = [one for room in told.values() for one in room if not one.is_ours]
    count = sum(map(len, faults_by_room().values()))
    click.echo(f"{count} faults, {count - len(stray)} with an error of ours: {output}")
    for one in stray:
        click.echo(f"not ours: {one.what}: {one.kind}: {one.words}", err=True)
    ctx.exit(1 if stray else 0)


if __name__ == "__main__":
    main()
