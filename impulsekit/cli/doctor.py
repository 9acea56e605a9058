"""``impulsekit doctor``: what is installed, what is missing, and which pinocchio is loaded."""

from __future__ import annotations

import contextlib
import importlib.metadata
import json
import platform
import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import click

from .. import __version__

# In a process of its own: a pinocchio built for another Python may take the process down.
_PROBE = (
    "import json, pinocchio, coal; "
    "print(json.dumps([pinocchio.__version__, pinocchio.__file__, coal.__version__]))"
)


def installed(name: str) -> str | None:
    """Return the version of a package that is installed, or None."""
    with contextlib.suppress(importlib.metadata.PackageNotFoundError):
        return importlib.metadata.version(name)
    return None


@dataclass(frozen=True)
class Requirement:
    """A line of the package's own metadata: ``extra`` is "" for the core."""

    name: str
    bounds: str
    extra: str

    @property
    def installed(self) -> str | None:
        """The version that is installed, or None."""
        return installed(self.name)

    @property
    def verdict(self) -> str:
        """ "ok", or what is wrong and the line that puts it right."""
        version = self.installed
        if version is not None and within(version, self.bounds):
            return "ok"
        fault = "missing" if version is None else f"expected {self.bounds}"
        return f'{fault}: pip install "{self.name}{self.bounds}"'


@click.command()
@click.pass_context
def doctor(ctx: click.Context) -> None:
    """Show versions, where pinocchio was loaded from, and what is missing."""
    from ..display.table import table

    needed = requirements()
    rows = [
        ["python", platform.python_version(), "core", sys.executable],
        ["impulsekit", __version__, "core", str(Path(__file__).parents[1])],
    ]
    rows += [[r.name, r.installed or "-", r.extra or "core", r.verdict] for r in needed]
    click.echo("\n".join(table(["package", "version", "part", "state"], rows)))
    click.echo()
    warnings = [f"{r.name}: {r.verdict}" for r in needed if not r.extra and r.verdict != "ok"]
    warnings += _pinocchio()
    if not needed:
        warnings.append(
            "impulsekit is not installed, only found on the path: what it needs is not known here;"
            " pip install . in its folder"
        )
    for warning in warnings:
        click.echo(f"warning: {warning}", err=True)
    if warnings:
        ctx.exit(1)
    click.echo("All that the core needs is there.")


def requirements() -> list[Requirement]:
    """The requirements of the installed impulsekit, the core first, each package once a part.

    None where it is not installed, only found on the path.
    """
    found: dict[tuple[str, str], Requirement] = {}
    lines: list[str] = []
    with contextlib.suppress(importlib.metadata.PackageNotFoundError):
        lines = importlib.metadata.requires("impulsekit") or []
    for line in lines:
        spec, _, marker = line.partition(";")
        match = re.match(r"([A-Za-z0-9._-]+)\s*(\[[^]]*\])?\s*(.*)", spec.strip())
        if match is None or match[1] == "impulsekit":
            continue
        extra = re.search(r"""extra\s*==\s*["']([^"']+)""", marker)
        part = extra[1] if extra else ""
        if part == "all":
            continue
        found.setdefault((match[1], part), Requirement(match[1], match[3].strip("() "), part))
    return sorted(found.values(), key=lambda r: r.extra != "")


def within(version: str, bounds: str) -> bool:
    """Return whether a version keeps bounds such as "<5,>=4.1"; other signs are ignored.

    Example:
        >>> within("4.10.1", "<5,>=4.1"), within("5.0", "<5,>=4.1")
        (True, False)
    """
    mine = _numbers(version)
    for sign, bound in re.findall(r"(>=|<(?!=))\s*([0-9][0-9.]*)", bounds):
        limit = _numbers(bound)
        size = max(len(mine), len(limit))
        below = mine + (0,) * (size - len(mine)) < limit + (0,) * (size - len(limit))
        if below == (sign == ">="):
            return False
    return True


def _numbers(version: str) -> tuple[int, ...]:
    match = re.match(r"\d+(\.\d+)*", version)
    return tuple(map(int, match[0].split("."))) if match else ()


def _pinocchio() -> list[str]:
    """Say which pinocchio is imported; the warnings about it."""
    probe = subprocess.run(
        [sys.executable, "-P", "-c", _PROBE], capture_output=True, text=True, check=False
    )
    if probe.returncode != 0:
        last = (probe.stderr.strip().splitlines() or [f"exit status {probe.returncode}"])[-1]
        return [f"pinocchio cannot be imported: {last}"]
    version, file, coal = json.loads(probe.stdout.splitlines()[-1])
    click.echo(f"pinocchio {version} (coal {coal}) is imported from {file}")
    warnings = []
    home = None
    with contextlib.suppress(importlib.metadata.PackageNotFoundError):
        home = Path(str(importlib.metadata.distribution("pin").locate_file(""))).resolve()
    if home is None or not Path(file).resolve().is_relative_to(home):
        hint = " (ROS brings its own)" if "/opt/ros" in file else ""
        warnings.append(
            f"pinocchio is not the one of the package pin{hint}; take its folder out of "
            "PYTHONPATH, or work in a virtual environment"
        )
    if other := installed("pinocchio"):
        warnings.append(
            f'the package "pinocchio" {other} is another project of that name; '
            "pip uninstall pinocchio && pip install --force-reinstall pin"
        )
    return warnings
