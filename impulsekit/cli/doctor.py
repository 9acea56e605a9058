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
import packaging.requirements
from packaging.specifiers import SpecifierSet

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
    bounds: SpecifierSet
    extra: str

    @property
    def verdict(self) -> str:
        """ "ok", or what is wrong and the line that puts it right."""
        version = installed(self.name)
        if version is not None and self.bounds.contains(version, prereleases=True):
            return "ok"
        fault = "missing" if version is None else f"expected {self.bounds}"
        return f'{fault}: pip install "{self.name}{self.bounds}"'


@click.command()
@click.pass_context
def doctor(ctx: click.Context) -> None:
    """Show versions, where pinocchio was loaded from, and what is missing."""
    from ..formatting import table

    needed = requirements()
    rows = [
        ["python", platform.python_version(), "core", sys.executable],
        ["impulsekit", __version__, "core", str(Path(__file__).parents[1])],
    ]
    rows += [[r.name, installed(r.name) or "-", r.extra or "core", r.verdict] for r in needed]
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
    for need in map(packaging.requirements.Requirement, lines):
        extra = re.search(r"""extra\s*==\s*["']([^"']+)""", str(need.marker))
        part = extra[1] if extra else ""
        if need.name != "impulsekit" and part != "all":
            found.setdefault((need.name, part), Requirement(need.name, need.specifier, part))
    return sorted(found.values(), key=lambda r: r.extra != "")


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
