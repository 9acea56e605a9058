"""The events of a motion as a labelled table."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import MissingExtraError

if TYPE_CHECKING:
    from .trajectory import Trajectory

__all__ = ["event_table"]


def event_table(motion: Trajectory) -> Any:
    """The impacts and the rests of a motion as an ``xarray.Dataset``; see ``Trajectory.events``."""
    try:
        import xarray
    except ImportError:
        raise MissingExtraError.of("xarray", "study", "Trajectory.events") from None
    contacts = list(motion.scene.entry_names("contacts"))
    impacts, count = motion.impacts, len(motion.impacts)
    impulse = np.full((count, len(contacts), 3), np.nan)
    touching = np.zeros((count, len(contacts)), dtype=bool)
    mode = np.full((count, len(contacts)), "separated", dtype="<U9")
    for row, (_, impact) in enumerate(impacts):
        for column, result in enumerate(impact.contacts):
            # A joint stop has one number, along its joint.
            impulse[row, column, : len(result.impulse)] = result.impulse
            touching[row, column], mode[row, column] = result.touching, result.mode
    energies = [(impact.energy.before, impact.energy.change) for _, impact in impacts]
    before, change = np.array(energies).reshape(-1, 2).T
    by_contact = ("impact", "contact")
    return xarray.Dataset(
        {
            "status": ("impact", [impact.status_of_shown.name for _, impact in impacts]),
            "energy_before": ("impact", before, {"units": "J"}),
            "energy_change": ("impact", change, {"units": "J"}),
            "impulse": ((*by_contact, "axis"), impulse, {"units": "N s"}),
            "touching": (by_contact, touching),
            "mode": (by_contact, mode),
            "rest_contact": ("rest", [rest.contact for rest in motion.rests]),
            "rest_start": ("rest", [rest.start for rest in motion.rests], {"units": "s"}),
            "rest_end": ("rest", [rest.end for rest in motion.rests], {"units": "s"}),
        },
        coords={
            "impact_time": ("impact", [time for time, _ in impacts], {"units": "s"}),
            "contact": contacts,
            "axis": ["x", "y", "z"],
        },
        attrs={"robot": motion.scene.robot.name, "status": motion.status.name},
    )
