"""``python -m benchmarks.fuzz``: fuzz, and keep the files that were found wanting."""

from __future__ import annotations

import collections
import pathlib
import time

import click

from .pool import Finding, fuzz
from .target import file_of


@click.command()
@click.option("--files", default=2000, show_default=True, type=click.IntRange(min=1))
@click.option("--jobs", default=2, show_default=True, type=click.IntRange(min=1))
@click.option("--seed", default=0, show_default=True)
@click.option("--first", default=0, show_default=True, help="Number of the first file.")
@click.option("--keep", default="fuzz_findings", show_default=True, type=click.Path())
@click.pass_context
def main(ctx: click.Context, files: int, jobs: int, seed: int, first: int, keep: str) -> None:
    """Load FILES broken URDFs and scene files; the exit status is 1 if any is a finding."""
    from tqdm import tqdm

    begin = time.perf_counter()
    with tqdm(total=files, unit="file", mininterval=1.0) as bar:
        tally = fuzz(
            files, jobs=jobs, seed=seed, first=first, progress=lambda done: bar.update(done - bar.n)
        )
    minutes = (time.perf_counter() - begin) / 60.0
    click.echo(f"{tally.files} files in {minutes:.1f} min, seed {seed}: what came of them")
    by_kind: dict[str, collections.Counter] = {}
    for (kind, outcome), count in tally.outcomes.items():
        by_kind.setdefault(kind, collections.Counter())[outcome] += count
    for kind, counter in sorted(by_kind.items()):
        told = ", ".join(f"{outcome} {count}" for outcome, count in counter.most_common())
        click.echo(f"  {kind}: {told}")
    click.echo(f"{len(tally.findings)} findings")
    for finding in tally.findings:
        _keep(pathlib.Path(keep), seed, finding)
        click.echo(f"\n{finding.number} ({finding.kind}): {finding.words}")
    ctx.exit(1 if tally.findings else 0)


def _keep(folder: pathlib.Path, seed: int, finding: Finding) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    kind, content = file_of(seed, finding.number)
    ending = "toml" if kind.endswith("scene") else "urdf"
    (folder / f"{seed}_{finding.number}.{ending}").write_bytes(content)


if __name__ == "__main__":
    main()
