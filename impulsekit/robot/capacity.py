"""Whether Pinocchio's data of a model fits into memory: it grows with the cube of its size."""

from __future__ import annotations

import os
import pathlib

import pinocchio as pin

from ..errors import RangeError

__all__ = ["check_capacity", "free_memory"]

# Measured: 0.5 GB for 200 degrees of freedom, 4 GB for 400 (tensors of second derivatives).
BYTES = 63
# One for what solves, one for its results.
COPIES = 2
# Below this nothing has to be looked up.
ALWAYS_FITS = 100


def check_capacity(model: pin.Model, copies: int = COPIES) -> None:
    """Prove that data can be made for a model, before the system kills the process for it.

    Raises:
        RangeError: it would not fit into the memory that is free.
    """
    if model.nv <= ALWAYS_FITS:
        return
    needed, free = copies * BYTES * model.nv**3, free_memory()
    if needed > free:
        raise RangeError(
            f"a robot of {model.nv} degrees of freedom needs {needed / 1e9:.1f} GB, and "
            f"{free / 1e9:.1f} GB are free; impulsekit.long takes large trees",
            what="degrees of freedom",
            value=model.nv,
            allowed="what fits into memory",
        )


def free_memory() -> float:
    """Bytes that are free, or can be made so; infinite where the system does not tell."""
    try:
        for line in pathlib.Path("/proc/meminfo").read_text().splitlines():
            if line.startswith("MemAvailable:"):
                return 1024.0 * float(line.split()[1])
    except (OSError, ValueError, IndexError):
        pass
    try:
        return float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    except (AttributeError, ValueError, OSError):
        return float("inf")
