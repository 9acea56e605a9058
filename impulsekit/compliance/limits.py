"""Limits of force and pressure where a robot touches a person, by region of the body."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from ..scene.numbers import keep, positive, text

__all__ = ["ISO_TS_15066", "BodyRegion"]

# [Pa] of 1 N/cm².
PER_CM2 = 1e4


@dataclass(frozen=True)
class BodyRegion:
    """A region of the body: how heavy and stiff it is, and what it may bear.

    Attributes:
        name: of the region.
        mass: effective mass [kg].
        stiffness: effective spring constant [N/m].
        force: largest permissible quasi-static force [N].
        pressure: largest permissible quasi-static pressure, at its most sensitive place [Pa].
        transient: factor on both while a transient contact lasts; 1 where none is permitted
            beyond the quasi-static values.
        source: where the values are from.

    Raises:
        RangeError, NotFiniteError, InputError.

    Example:
        >>> forearm = BodyRegion("forearm", mass=2.0, stiffness=40e3, force=160, pressure=1.8e6)
        >>> forearm.transient
        2.0
    """

    name: str
    mass: float
    stiffness: float
    force: float
    pressure: float
    transient: float = 2.0
    source: str = "user"

    def __post_init__(self) -> None:
        text(self.name, "BodyRegion: name")
        fields = ("mass", "stiffness", "force", "pressure", "transient")
        keep(self, "BodyRegion", positive, *fields)


def _iso(
    name: str, mass: float, per_mm: float, force: float, per_cm2: float, transient: float = 2.0
) -> BodyRegion:
    pressure = per_cm2 * PER_CM2
    return BodyRegion(name, mass, 1e3 * per_mm, force, pressure, transient, SOURCE)


SOURCE = "ISO/TS 15066:2016, tables A.2 and A.3 (taken over by ISO 10218-2:2025)"

# Table A.3: effective mass [kg] and spring constant [N/mm]; table A.2: force [N] and the smallest
# of the region's pressures [N/cm²]. Transient contact doubles both, but at skull and face, where
# the table permits none: there the quasi-static values stand.
ISO_TS_15066: Mapping[str, BodyRegion] = MappingProxyType(
    {
        region.name: region
        for region in (
            _iso("skull", 4.4, 150.0, 130.0, 110.0, 1.0),
            _iso("face", 4.4, 75.0, 65.0, 110.0, 1.0),
            _iso("neck", 1.2, 50.0, 150.0, 140.0),
            _iso("back", 40.0, 35.0, 210.0, 160.0),
            _iso("chest", 40.0, 25.0, 140.0, 120.0),
            _iso("abdomen", 40.0, 10.0, 110.0, 140.0),
            _iso("pelvis", 40.0, 25.0, 180.0, 210.0),
            _iso("upper arm", 3.0, 30.0, 150.0, 190.0),
            _iso("forearm", 2.0, 40.0, 160.0, 180.0),
            _iso("hand", 0.6, 75.0, 140.0, 190.0),
            _iso("thigh", 75.0, 50.0, 220.0, 220.0),
            _iso("lower leg", 75.0, 60.0, 130.0, 210.0),
        )
    }
)
