"""``python -m tests.docs``: build the documentation and open every page of it in Chromium."""

from __future__ import annotations

import pathlib
import subprocess
import sys
import time

import click

from ..view.browser import browser
from .site import examine

ROOT = pathlib.Path(__file__).parents[2]
SITE = ROOT / "docs/_build/html"


@click.command()
@click.option("--built", is_flag=True, help="Open the pages as they are, without a build.")
@click.pass_context
def main(ctx: click.Context, built: bool) -> None:
    """Build the documentation and open every page; status 1 if one has a fault."""
    if not built:
        begin = time.perf_counter()
        command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "docs", str(SITE)]
        if subprocess.run(command, cwd=ROOT, check=False).returncode:
            ctx.exit(1)
        click.echo(f"built in {time.perf_counter() - begin:.0f} s")
    begin = time.perf_counter()
    with browser() as opened:
        count, faults = examine(SITE, opened)
    for fault in faults:
        click.echo(fault, err=True)
    seconds = time.perf_counter() - begin
    click.echo(f"{count} pages opened in {seconds:.0f} s, {len(faults)} faults")
    ctx.exit(1 if faults or not count else 0)


if __name__ == "__main__":
    main()
