"""On what machine, with which versions, and when a benchmark was run."""

from __future__ import annotations

import datetime
import os
import platform
from importlib.metadata import PackageNotFoundError, version

from impulsekit import __version__

__all__ = ["about"]

PACKAGES = (
    "pin",
    "numpy",
    "scipy",
    "numba",
    "mujoco",
    "exudyn",
    "crocoddyl",
    "example-robot-data",
)


def about() -> dict[str, str]:
    """Facts by name, as text. The machine is told by its kind, not by its name."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    facts = {
        "date": datetime.datetime.now(datetime.UTC).date().isoformat(),
        "machine": f"{cores}-core {platform.machine().replace('_', '-')}",
        "system": platform.system(),
        "Python": platform.python_version(),
        "impulsekit": __version__,
    }
    for name in PACKAGES:
        try:
            facts[name] = version(name)
        except PackageNotFoundError:
            continue
    return facts
