"""``impulsekit batch``: a scene at many random states, into a store."""

from __future__ import annotations

from typing import Any

import click

__all__ = ["batch"]


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

    Rows stream to a Zarr store. A run that was stopped goes on when it is called again. The
    exit status is 0 only if every row is valid.
    """
    import pathlib

    from ..batch.study import load_study, run_study, summarize

    study = load_study(file)
    folder = store or str(pathlib.Path(file).with_suffix("")) + "_rows"
    if scheduler or workers:
        with _client(scheduler, workers, threads) as client:
            run_study(study, folder, progress=not quiet, client=client)
    else:
        run_study(study, folder, progress=not quiet, threads=threads)
    summary = summarize(folder)
    click.echo(f"{folder}: {summary}")
    if plot:
        from ..batch.study.summary import plot_study

        plot_study(folder, plot)
    ctx.exit(0 if all(status.valid for status in summary.statuses) else 1)


def _client(scheduler: str | None, workers: int | None, threads: int | None) -> Any:
    from ..errors import MissingExtraError

    try:
        from distributed import Client, LocalCluster
    except ImportError:
        raise MissingExtraError.of("distributed", "batch", "a study on a cluster") from None
    if scheduler:
        return Client(scheduler)
    return Client(
        LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None),
        set_as_default=False,
    )
