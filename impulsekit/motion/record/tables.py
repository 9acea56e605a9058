"""The states and the events of a motion as labelled tables."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin

from ...errors import MissingExtraError
from .energies import energies_of, momenta_of

if TYPE_CHECKING:
    from .sampled import SampledMotion

__all__ = ["coordinate_names", "event_table", "state_table"]


def state_table(motion: SampledMotion) -> Any:
    """States, energies and momenta over time as an ``xarray.Dataset``; see ``to_xarray``."""
    with MissingExtraError.unless("xarray", "study", "Trajectory.to_xarray"):
        import xarray
    energy, momentum = energies_of(motion), momenta_of(motion)
    robot = motion.scene.robot
    names_q, names_v = coordinate_names(robot.model)
    return xarray.Dataset(
        {
            "q": (("time", "coordinate"), motion.q),
            "v": (("time", "speed"), motion.v),
            "kinetic_energy": ("time", energy.kinetic, {"units": "J"}),
            "potential_energy": ("time", energy.gravity + energy.springs, {"units": "J"}),
            "linear_momentum": (("time", "axis"), momentum.linear, {"units": "kg m/s"}),
            "angular_momentum": (("time", "axis"), momentum.angular, {"units": "kg m2/s"}),
        },
        coords={
            "time": ("time", motion.t, {"units": "s"}),
            "coordinate": names_q,
            "speed": names_v,
            "axis": ["x", "y", "z"],
        },
        attrs={
            "robot": robot.name,
            "status": motion.status.name,
            "impact_times": np.array([time for time, _ in motion.impacts]),
        },
    )


def event_table(motion: SampledMotion) -> Any:
    """The impacts and the rests of a motion as an ``xarray.Dataset``; see ``Trajectory.events``."""
    with MissingExtraError.unless("xarray", "study", "Trajectory.events"):
        import xarray
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
            "status": ("impact", [impact.status.name for _, impact in impacts]),
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


def coordinate_names(model: pin.Model) -> tuple[list[str], list[str]]:
    """A name for every entry of q and of v."""
    names: tuple[list[str], list[str]] = ([], [])
    for joint, name in zip(list(model.joints)[1:], list(model.names)[1:], strict=True):
        for own, count in zip(names, (joint.nq, joint.nv), strict=True):
            own.extend([name] if count == 1 else [f"{name}[{i}]" for i in range(count)])
    return names
