"""``impulsekit batch``: a scene at many random states, into a store."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any

import click

from .common import INTERRUPTED

# So long a client and its workers may take to end [s].
CLOSING = 5.0


@click.command()
@click.argument("file", type=click.Path())
@click.option(
    "--store", "-o", type=click.Path(), help="Folder of the rows; by default FILE without ending."
)
@click.option("--threads", type=click.IntRange(min=1), help="Threads of each process.")
@click.option("--workers", type=click.IntRange(min=1), help="Processes of a local Dask cluster.")
@click.option("--scheduler", metavar="ADDRESS", help="A Dask scheduler, such as tcp://host:8786.")
@click.option("--plot", type=click.Path(), help="Histograms to this picture (svg, png, pdf).")
@click.option("--quiet", "-q", is_flag=True, help="No progress bar.")
@click.pass_context
def batch(
    ctx: click.Context,
    file: str,
    store: str | None,
    threads: int | None,
    workers: int | None,
    scheduler: str | None,
    plot: str | None,
    quiet: bool,
) -> None:
    """Solve the scene in FILE at the random states of its [batch] table.

    With `motion = true` in that table the rows are motions, followed on all cores.

    Rows stream to a store. A run that was stopped goes on when it is called again. The
    exit status is 0 only if every row is valid.
    """
    import os

    from ..batch.study.store import check_store
    from ..study import load_study, run_study, summarize
    from .common import check_outputs

    folder = store or os.path.splitext(file)[0] + "_rows"
    check_outputs(picture=plot)
    check_store(folder)
    study = load_study(file)
    try:
        if scheduler or workers:
            with _client(scheduler, workers) as client:
                run_study(study, folder, progress=not quiet, client=client)
        else:
            run_study(study, folder, progress=not quiet, threads=threads)
    except KeyboardInterrupt:
        click.echo(_how_to_go_on(folder), err=True)
        ctx.exit(INTERRUPTED)
    summary = summarize(folder)
    click.echo(f"{folder}: {summary}")
    if plot:
        from ..view.plots.results import plot_study

        plot_study(folder, plot)
    ctx.exit(0 if summary.valid else 1)


def _how_to_go_on(folder: str) -> str:
    """Words on the rows of a run that was stopped, and the command that goes on with it."""
    import shlex
    import sys

    from ..errors import ImpulsekitError
    from ..study import summarize

    done = f"nothing is written to {folder} yet"
    with suppress(ImpulsekitError):
        summary = summarize(folder)
        done = f"{summary.written} of {summary.rows} rows are written to {folder}"
    command = shlex.join(["impulsekit", *sys.argv[1:]])
    return f"interrupted: {done}; to go on, run the same command again:\n  {command}"


@contextmanager
def _client(scheduler: str | None, workers: int | None) -> Iterator[Any]:
    from ..errors import MissingExtraError, RangeError, quoted

    with MissingExtraError.unless("distributed", "study", "a study on a cluster"):
        from distributed import Client, LocalCluster
    if scheduler:
        try:
            client = Client(scheduler)
        except ValueError as error:
            raise RangeError.of(
                "--scheduler", quoted(scheduler), "an address such as tcp://host:8786"
            ) from error
        with client:
            yield client
        return
    cluster = LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None)
    client = Client(cluster, set_as_default=False)
    try:
        client.run(_ignore_interrupts)
        yield client
    finally:
        for each in (client, cluster):
            # What does not end by then ends with this process.
            with suppress(TimeoutError):
                each.close(timeout=CLOSING)


def _ignore_interrupts() -> None:
    """A terminal sends Ctrl-C to workers, too; one that it ends leaves this process waiting."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
