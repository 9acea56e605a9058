"""What a file or folder of public recordings holds, and one report on all of it."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from pathlib import Path

from benchmarks.recorded import drops, elbow, landings, tosses
from benchmarks.recorded.section import Section, joined
from benchmarks.recorded.tensors import read_tensor
from impulsekit.errors import FileError, ImpulsekitError, InputError, shown

# Folders in a folder are looked into so deep.
DEPTH = 6
DROPS = ("ellipse_uniform.mat", "squareDataPhilUpdated.mat")
CUBE = re.compile(r"cube_tosses.*\.npz")
Progress = Callable[[int, int], object]


def measured_report(
    path: str | os.PathLike[str],
    *,
    threads: int | None = None,
    progress: Progress | None = None,
    tell: Callable[[str], object] | None = None,
) -> str:
    """Errors of laws and motions on recordings, beside published figures.

    A data set that cannot be read is told in its place if there are others.

    Args:
        path: a file or folder, see ``find_data``.
        threads: how many follow motions; None for all cores.
        progress: called with steps done and in all, for each set of data anew.
        tell: called with the name of each set of data before it is worked on.

    Raises:
        FileError, InputError: there is nothing to be read, with where it can be had.
    """
    found = find_data(path)
    sections = []
    for kind, place in found:
        if tell is not None:
            tell(f"{kind}: {shown(os.fspath(place), 200)}")
        if len(found) == 1:
            return str(_section(kind, place, threads, progress))
        try:
            sections.append(_section(kind, place, threads, progress))
        except ImpulsekitError as error:
            sections.append(Section(kind, [f"left out: {error}"]))
    return joined(sections)


def find_data(path: str | os.PathLike[str]) -> list[tuple[str, Path]]:
    """(kind, place) of each set of data in a folder and those in it; of a file, what it is.

    Kinds are "cube", "elbow", "drops" and "landings".

    Raises:
        FileError: the file or folder does not exist.
        InputError: no data that is known, with where it can be had.
    """
    top = Path(path)
    label = shown(os.fspath(path), 200)
    if not top.exists():
        raise FileError(f"{label}: no such file; {_where()}", path=os.fspath(path))
    if not top.is_dir():
        return [("drops" if top.suffix == ".mat" else "cube", top)]
    found: list[tuple[str, Path]] = []
    for folder, below, files in os.walk(top):
        here = Path(folder)
        deep = len(here.relative_to(top).parts)
        below[:] = [] if deep >= DEPTH else sorted(n for n in below if not n.startswith("."))
        numbered = sorted(n for n in files if re.fullmatch(r"\d+\.pt", n))
        if numbered:
            found.append((_kind_of_tensor(here / numbered[0]), here))
        if any(re.fullmatch(r"x_\d+\.npy", name) for name in files):
            found.append(("landings", here))
        for name in sorted(files):
            if CUBE.fullmatch(name):
                found.append(("cube", here / name))
            elif name in DROPS and name not in {place.name for _, place in found}:
                found.append(("drops", here / name))
    if not found:
        raise InputError(f"{label}: no recordings that are known; {_where()}")
    order = ("cube", "elbow", "drops", "landings")
    return sorted(found, key=lambda each: order.index(each[0]))


def _kind_of_tensor(path: Path) -> str:
    """What a folder of tosses holds, by the numbers of a sample in its first file."""
    try:
        shape = read_tensor(path).shape
    except FileError:
        return "cube"
    return "elbow" if shape[-1:] == (elbow.ELBOW_COLUMNS,) else "cube"


def _section(kind: str, place: Path, threads: int | None, progress: Progress | None) -> Section:
    if kind == "cube":
        return tosses.toss_section(place, threads=threads, progress=progress)
    if kind == "elbow":
        return elbow.elbow_section(place, threads=threads, progress=progress)
    if kind == "drops":
        return drops.drop_section(place, progress=progress)
    return landings.landing_section(place, progress=progress)


def _where() -> str:
    several = ("tosses of a cube", tosses), ("of an elbow", elbow), ("planar drops", drops)
    places = [f"{what}: {module.WHERE}" for what, module in several]
    return "; ".join([*places, f"landings of Cassie: {landings.WHERE}"])
