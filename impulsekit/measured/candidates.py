"""Laws to compare: what each changes in a scene."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..design.measurement import Measurement
from ..errors import InputError
from ..scene import JointLock, Law, RestitutionTable, Scene

__all__ = ["LawCandidate", "usual_candidates"]

# e by speed is fitted at these percentiles of the speeds of the impacts' fastest contacts.
PERCENTILES = (10.0, 50.0, 90.0)
# A speed this near to the next [share of the fastest] is no point of its own.
TOO_NEAR = 0.05
# Impacts whose speeds tell the percentiles; more change them by little.
MOST_LOOKED_AT = 200


@dataclass(frozen=True)
class LawCandidate:
    """One way to predict impacts.

    Attributes:
        name: in the table.
        law: in place of the scene's; None: the scene's own.
        speeds: e by approach speed, at these speeds [m/s]; none: the scene's own.
        by_group: e of its own for each ``Measurement.group``; or the names of the coefficients
            that a group has of its own, "restitution" and "friction".
        group_of: the group of an impact by what is known before it, in place of
            ``Measurement.group``.
        locked, controlled: joints that keep their velocity, as a lock with velocity="kept" or in
            ``Scene.controlled``; the others are as in the scene.

    Raises:
        InputError: no name, or speeds that do not rise.

    Example:
        >>> from impulsekit import Law
        >>> LawCandidate("Stronge", Law("stronge", "path")).law.slip
        'path'
    """

    name: str
    law: Law | None = None
    speeds: tuple[float, ...] = ()
    by_group: bool | Sequence[str] = False
    group_of: Callable[[Measurement], str] | None = None
    locked: tuple[str, ...] = ()
    controlled: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not self.name or not isinstance(self.name, str):
            raise InputError("LawCandidate: name must be text that is not empty")
        for field in ("speeds", "locked", "controlled"):
            object.__setattr__(self, field, tuple(getattr(self, field)))
        if self.speeds:
            # The table says what is wrong with them.
            RestitutionTable(self.speeds, (0.0,) * len(self.speeds))

    def scene(self, scene: Scene) -> Scene:
        """A scene under this candidate.

        Raises:
            InputError, UnknownNameError: as ``Scene``.
        """
        contacts: list[Any] = []
        for entry in scene.contacts:
            value: Any = entry.restitution
            if self.speeds and isinstance(value, float):
                table = RestitutionTable(self.speeds, (value,) * len(self.speeds))
                contacts.append(replace(entry, restitution=table))
            else:
                contacts.append(entry)
        locks = [JointLock(joint, velocity="kept") for joint in self.locked]
        return replace(
            scene,
            contacts=contacts,
            law=self.law or scene.law,
            constraints=[*scene.constraints, *locks],
            controlled=[*scene.controlled, *self.controlled],
        )


def usual_candidates(measurements: Sequence[Measurement]) -> list[LawCandidate]:
    """Newton, Poisson and Stronge, slip at the end and along the path, e by speed and by group.

    Along the path only where no impact has more than one contact, as the laws have it; e by
    group only where there are several.
    """
    found = [LawCandidate("Newton, slip at the end", Law())]
    found.append(LawCandidate("Poisson, slip at the end", Law("poisson")))
    alone = all(len(m.scene.contacts) == 1 for m in measurements)
    if alone:
        found += [
            LawCandidate(f"{law.capitalize()}, along the path", Law(law, "path"))
            for law in ("newton", "poisson", "stronge")
        ]
    speeds = _speeds(measurements)
    if len(speeds) > 1:
        found.append(LawCandidate("Newton, e by speed", Law(), speeds=speeds))
        if alone:
            law = Law("poisson", "path")
            found.append(LawCandidate("Poisson, along the path, e by speed", law, speeds=speeds))
    if len({m.group for m in measurements}) > 1:
        found.append(LawCandidate("Newton, e by what meets", Law(), by_group=True))
    return found


def _speeds(measurements: Sequence[Measurement]) -> tuple[float, ...]:
    """Where e by speed is fitted: percentiles of the approach speeds, rounded to two digits."""
    from ..design.parameters import scene_of
    from ..impact.solver import solve_without_warnings

    found = []
    for m in measurements[:: max(1, len(measurements) // MOST_LOOKED_AT)]:
        impact = solve_without_warnings(scene_of(m, [], np.zeros(0), {}), m.q, m.v_before)
        for contact in impact.contacts:
            if contact.points and contact.points[0].normal is not None:
                found.append(-float(contact.points[0].normal @ contact.velocity_before))
    approaching = [speed for speed in found if speed > 0.0]
    if not approaching:
        return ()
    points = [float(f"{p:.2g}") for p in np.percentile(approaching, PERCENTILES)]
    kept: list[float] = []
    for point in points:
        if not kept or point - kept[-1] > TOO_NEAR * points[-1]:
            kept.append(point)
    return tuple(kept)
