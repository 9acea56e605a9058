"""``python -m benchmarks.stress``: sweeps to the edge, each answer right or said not to be."""

from __future__ import annotations

import click

from ..command import Command


@click.command(cls=Command)
@click.option("--quick", is_flag=True, help="A thirtieth of the scenes.")
@click.option("--sweeps", metavar="NAME,...", help="Only these; --list names them.")
@click.option("--list", "listing", is_flag=True, help="Name the sweeps, and what they do.")
@click.option("--seed", type=click.IntRange(min=0), default=0, help="Of the random numbers.")
@click.option("--out", "-o", type=click.Path(file_okay=False), help="Folder for the report.")
@click.option("--jobs", "-j", type=click.IntRange(min=1), help="Processes; by default a core each.")
@click.option("--quiet", "-q", is_flag=True, help="No progress bar.")
@click.pass_context
def main(
    ctx: click.Context,
    quick: bool,
    sweeps: str | None,
    listing: bool,
    seed: int,
    out: str | None,
    jobs: int | None,
    quiet: bool,
) -> None:
    """Hold impulsekit against 50-digit answers where numbers are at their worst.

    Masses, lengths and impulses of all sizes, singular configurations, redundant rows, contacts
    at every edge of their laws. The exit status is 0 only if no answer is silently wrong, and
    none that is called valid leaves more of its equations than rounding does; stderr names the
    sweeps in which one is or does. With --out the report (stress.md, stress.json), all points
    (points.csv) and a picture for each sweep are written.
    """
    import os
    import pathlib
    import sys
    import time

    from rich.console import Console
    from rich.table import Table

    from impulsekit.cli.common import is_terminal
    from impulsekit.errors import UnknownNameError

    from .report import HEAD, cells, lines_of, whole_of, write_report
    from .run import ALL, jobs_of, run
    from .sweep import Point

    if listing:
        for sweep in ALL:
            click.echo(f"{sweep.name:20s} {sweep.what}")
        return
    chosen = ALL
    if sweeps is not None:
        names = [name.strip() for name in sweeps.split(",") if name.strip()]
        known = {sweep.name: sweep for sweep in ALL}
        for name in names:
            if name not in known:
                raise UnknownNameError.among("sweep", name, known)
        chosen = tuple(known[name] for name in names)
    work = jobs_of(chosen, seed, 1.0 / 30.0 if quick else 1.0)
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    processes = jobs or cores or 1
    points: list[Point] = []
    start = time.perf_counter()
    shown = None if quiet or not is_terminal(sys.stderr) else len(work)
    if shown is None:
        for some in run(work, processes):
            points += some
    else:
        from tqdm import tqdm

        with tqdm(total=shown, unit="case") as bar:
            for some in run(work, processes, lambda done: bar.update(done - bar.n)):
                points += some
    seconds = time.perf_counter() - start
    order = {sweep.name: i for i, sweep in enumerate(chosen)}
    points.sort(key=lambda p: (order[p.sweep], p.value, p.repeat, p.state))
    whole = whole_of(points)
    table = Table(*HEAD, box=None, header_style="", padding=(0, 1))
    for column in table.columns[1:]:
        column.justify = "right"
    lines = lines_of(points)
    for line in (*lines, whole):
        table.add_row(*cells(line))
    width = None if is_terminal(sys.stdout) else 160
    Console(width=width, highlight=False, soft_wrap=True).print(table)
    click.echo(
        f"{whole.scenes} scenes, {whole.points} answers in {seconds:.0f} s: "
        f"{whole.wrong} silently wrong, {whole.said} said so"
    )
    complaints = [line.complaint for line in lines if line.complaint]
    for complaint in complaints:
        click.echo(complaint, err=True)
    if out is not None:
        write_report(points, pathlib.Path(out), seconds)
        click.echo(f"report: {pathlib.Path(out) / 'stress.md'}", err=True)
    ctx.exit(1 if complaints else 0)


if __name__ == "__main__":
    main(prog_name="python -m benchmarks.stress")
