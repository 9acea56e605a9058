"""``python -m benchmarks``: run time against error, as tables, diagrams and a report."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from .command import Command

PARTS = ("rows", "claims")


@click.command(cls=Command)
@click.option(
    "--quick", is_flag=True, help="Small problems, fewer methods and rounds: two minutes."
)
@click.option(
    "--out",
    "-o",
    type=click.Path(),
    default="bench_results",
    show_default=True,
    help="Folder of the results.",
)
@click.option("--problems", "-p", multiple=True, metavar="FAMILY", help="Only this family.")
@click.option("--methods", "-m", multiple=True, metavar="NAME", help="Only methods so called.")
@click.option("--part", multiple=True, type=click.Choice(PARTS), help="Only this part.")
@click.option("--peers/--no-peers", default=True, help="Other programs, if they are installed.")
@click.option("--list", "listing", is_flag=True, help="List families and methods, and stop.")
@click.option("--quiet", "-q", is_flag=True, help="No progress.")
def main(
    quick: bool,
    out: str,
    problems: tuple[str, ...],
    methods: tuple[str, ...],
    part: tuple[str, ...],
    peers: bool,
    listing: bool,
    quiet: bool,
) -> None:
    """Time impulsekit and other programs on problems whose answers are known exactly.

    OUT receives report.md, rows and claims as CSV and JSON, and diagrams as SVG. A
    method that misses a problem's tolerance does not count as fast there.
    """
    from impulsekit.cli.common import one_thread_each

    one_thread_each()
    from .methods.registry import few
    from .methods.registry import methods as named

    chosen = named(methods, peers)
    if quick and not methods:
        chosen = few(chosen)
    if listing:
        _list(chosen)
        return
    from .run import Wish, whole

    wish = Wish(quick, tuple(problems), tuple(chosen), part or PARTS)
    path = whole(wish, Path(out), _teller(quiet))
    click.echo(str(path))


def _list(chosen: list[Any]) -> None:
    from .problems.registry import FAMILIES

    click.echo("families of problems")
    for family in FAMILIES:
        click.echo(f"  {family}")
    click.echo("methods")
    for method in chosen:
        lack = method.missing()
        click.echo(f"  {method.label}" + (f"   ({lack})" if lack else ""))


def _teller(quiet: bool) -> Any:
    if quiet:
        return lambda name: None
    return lambda name: click.echo(name, err=True)


if __name__ == "__main__":
    main(prog_name="python -m benchmarks")
