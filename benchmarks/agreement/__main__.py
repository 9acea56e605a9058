"""Batches beside ``solve``, row by row, on random scenes of all example robots.

Run with ``python -m benchmarks.agreement [ROWS] [-o FILE] [-j PROCESSES]``, 10 000
rows by default. What stands in the file already is not done again.
"""

from __future__ import annotations

import argparse
import csv
import multiprocessing
import pathlib
import sys
from concurrent.futures import ProcessPoolExecutor, as_completed

import numpy as np

from benchmarks.about import about
from benchmarks.stress.bodies import random_state
from impulsekit.robot.examples import example_names

from .agreement import BAR, KINDS, agreement, loaded_robot, random_scene

COLUMNS = ("robot", "nv", "kind", "rows", "worst", "harder", "statuses", "date", "machine")


def _line(name: str, kind: str, rows: int) -> dict[str, str] | None:
    """The figures of one robot; the random numbers are the same however the work is shared."""
    robot = loaded_robot(name)
    if robot is None:
        return None
    rng = np.random.default_rng([2, example_names().index(name), KINDS.index(kind)])
    found = agreement(random_scene(robot, kind, rng), *random_state(robot, rng, rows))
    known = about()
    figures = (name, robot.nv, kind, found.rows, f"{found.worst:.1e}", found.harder, found.statuses)
    cells = (*map(str, figures), known["date"], known["machine"])
    return dict(zip(COLUMNS, cells, strict=True))


def main() -> None:
    """Write a line for every robot and kind of scene."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("rows", type=int, nargs="?", default=10_000)
    parser.add_argument("--out", "-o", type=pathlib.Path, help="CSV file, which is gone on with")
    parser.add_argument("--jobs", "-j", type=int, default=1, help="processes")
    given = parser.parse_args()
    lines: list[dict[str, str]] = []
    if given.out is not None and given.out.exists():
        with given.out.open(newline="") as file:
            lines = [line for line in csv.DictReader(file) if int(line["rows"]) == given.rows]
    done = {(line["robot"], line["kind"]) for line in lines}
    jobs = [(name, kind) for name in example_names() for kind in KINDS if (name, kind) not in done]
    for line in lines:
        _tell(line)
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(given.jobs, mp_context=context) as pool:
        for future in as_completed([pool.submit(_line, *job, given.rows) for job in jobs]):
            found = future.result()
            if found is not None:
                lines.append(found)
                _tell(found)
                _keep(lines, given.out)
    highest = max(float(line["worst"]) for line in lines)
    apart = sum(int(line["statuses"]) for line in lines)
    verdict = "held" if highest <= BAR and not apart else "NOT HELD"
    sys.stdout.write(
        f"largest difference {highest:.1e}, {apart} statuses differ   {BAR:g} {verdict}\n"
    )


def _tell(line: dict[str, str]) -> None:
    above = float(line["worst"]) > BAR or int(line["statuses"]) > 0
    sys.stdout.write(
        f"{line['robot']:36s} nv {line['nv']:>3s} {line['kind']:8s} {line['rows']:>7s} rows   "
        f"{line['worst']}   {line['harder']} by 50 digits   "
        f"{line['statuses']} statuses differ{'   ABOVE' if above else ''}\n"
    )
    sys.stdout.flush()


def _keep(lines: list[dict[str, str]], path: pathlib.Path | None) -> None:
    if path is None:
        return
    order = {name: i for i, name in enumerate(example_names())}
    kept = sorted(lines, key=lambda line: (order[line["robot"]], line["kind"]))
    partial = path.with_suffix(".partial")
    with partial.open("w", newline="") as file:
        table = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        table.writeheader()
        table.writerows(kept)
    partial.replace(path)


if __name__ == "__main__":
    main()
