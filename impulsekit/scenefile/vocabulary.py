"""The lists of a scene file and the frozen dataclasses behind their entries.

How to add an entry kind:

1. Write the frozen dataclass in ``scene/``. Its fields are the keys of the file, so they
   are text, numbers, booleans, or tuples of these; ``Vector`` for three numbers, ``Any``
   for numbers or text, one or several. A value that is wrong raises an ``InputError``
   whose ``what`` ends in ``": field"``.
2. Give ``Scene`` the list, and let it check an entry against the robot.
3. Add one line to ``SECTIONS``: ``kind = "joint_lock"`` in the file is the key of that
   dictionary. Keys, types, nearest names, reading and writing follow from the dataclass.
   What stands as a table within an entry goes to ``NESTED``.
"""

from __future__ import annotations

import dataclasses
import functools
import typing
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Annotated, Any

import pydantic
from pydantic_core import PydanticCustomError

from ..scene.coefficients import (
    BY_MATERIAL,
    EllipticFriction,
    FrictionTable,
    Restitution,
    RestitutionTable,
    StaticKinetic,
)
from ..scene.constraints import DistanceAnchor, FrameAnchor, JointCoupling, JointLock, PointAnchor
from ..scene.contacts import Collision, Contact, JointStop, Rope
from ..scene.forces import (
    PD,
    Actuator,
    AppliedForce,
    JointFriction,
    JointSpring,
    Spring,
    TorqueTable,
)
from ..scene.impulses import AppliedImpulse, JointImpulse
from ..scene.law import Law
from ..scene.materials import Material, MaterialPair
from ..scene.motion import MotionSettings
from ..scene.points import DesignPoint, ReportPoint

STRICT = pydantic.ConfigDict(extra="forbid", strict=True, allow_inf_nan=False, frozen=True)


@dataclass(frozen=True)
class Section:
    """One list (or one table) of a scene file, and of ``Scene`` under the same name.

    Attributes:
        name: the key in the file and the field of ``Scene``.
        kinds: what ``kind = "..."`` may say, and the dataclass that it stands for.
        needs_kind: False where the keys of an entry tell its kind by themselves.
        many: False for a single table such as ``[law]``.
    """

    name: str
    kinds: dict[str, type] = field(default_factory=dict)
    needs_kind: bool = True
    many: bool = True

    def kind_of(self, entry: Any) -> str | None:
        """Return the name that the class of an entry has in the file; None for no kind."""
        return next((kind for kind, cls in self.kinds.items() if type(entry) is cls), None)


SECTIONS: tuple[Section, ...] = (
    Section("impulses", {"applied": AppliedImpulse, "joint": JointImpulse}, needs_kind=False),
    Section(
        "constraints",
        {
            "point_anchor": PointAnchor,
            "frame_anchor": FrameAnchor,
            "distance_anchor": DistanceAnchor,
            "joint_lock": JointLock,
            "joint_coupling": JointCoupling,
        },
    ),
    Section(
        "contacts",
        {"contact": Contact, "joint_stop": JointStop, "collision": Collision, "rope": Rope},
    ),
    Section(
        "forces",
        {
            "joint_spring": JointSpring,
            "joint_friction": JointFriction,
            "spring": Spring,
            "actuator": Actuator,
            "applied_force": AppliedForce,
        },
    ),
    Section("law", {"law": Law}, many=False),
    Section("materials", {"material": Material, "pair": MaterialPair}, needs_kind=False),
)

# How a motion is followed: of the file, not of the scene.
MOTION = Section("motion", {"motion": MotionSettings}, many=False)
POINTS = Section("report.points", {"point": ReportPoint}, needs_kind=False)
DESIGN = Section("design.points", {"point": DesignPoint}, needs_kind=False)


# Dataclasses that may stand as a table within an entry.
NESTED: tuple[type, ...] = (
    Restitution,
    RestitutionTable,
    PD,
    TorqueTable,
    StaticKinetic,
    FrictionTable,
    EllipticFriction,
)
# Their stiffness may be infinite: ``stiffness = inf``.
_CONTACTS = (Contact, JointStop, Collision, MaterialPair)
# Those of them that may stand for a coefficient of restitution.
_RESTITUTIONS = (Restitution, RestitutionTable)


@functools.cache
def model_of(cls: type) -> type[pydantic.BaseModel]:
    """Return the pydantic model with the fields, types and defaults of a frozen dataclass."""
    hints = typing.get_type_hints(cls)
    fields: dict[str, Any] = {}
    for item in dataclasses.fields(cls):
        required = default_of(item) is dataclasses.MISSING
        hint = _in_file(hints[item.name])
        if item.name == "stiffness" and cls in _CONTACTS:
            hint = Annotated[float, pydantic.AllowInfNan(True)] | None
        fields[item.name] = (hint, ... if required else None)
    return pydantic.create_model(cls.__name__, __config__=STRICT, **fields)


def default_of(item: dataclasses.Field) -> Any:
    """Return the default of a field, ``dataclasses.MISSING`` where it has none."""
    if item.default_factory is not dataclasses.MISSING:
        return item.default_factory()
    return item.default


def _in_file(hint: Any) -> Any:
    """The type that a field's type becomes in a file, which holds no functions."""
    if hint is Any:
        return Annotated[Any, pydantic.AfterValidator(_plain)]
    options = typing.get_args(hint)
    if any(typing.get_origin(option) is Callable for option in options):
        return _without_functions(hint)
    return hint


def _plain(value: Any) -> Any:
    """A number or text, or a tuple of numbers or of texts."""
    entries = value if isinstance(value, tuple) else (value,)
    for kinds in (str, int | float):
        if all(isinstance(x, kinds) and not isinstance(x, bool) for x in entries):
            return value
    raise PydanticCustomError("plain_type", "numbers or text, one or several")


@functools.cache
def _without_functions(hint: Any) -> Any:
    """A choice without functions: a number, numbers, or the table with most of its keys."""
    options = [o for o in typing.get_args(hint) if typing.get_origin(o) is not Callable]
    words = [o for o in options if typing.get_origin(o) is typing.Literal]
    options = [o for o in options if o not in words]
    nested = [o for o in options if o in NESTED]
    plain = [o for o in options if o not in NESTED]
    if plain == [float] and not nested:
        nested = list(_RESTITUTIONS)
    if not nested and len(plain) == 1:
        return plain[0]

    def tag_of(value: Any) -> str:
        if words and value == BY_MATERIAL:
            return "<word>"
        if not isinstance(value, dict | pydantic.BaseModel):
            return "<numbers>" if isinstance(value, tuple) and len(plain) > 1 else "<number>"
        keys = value.keys() if isinstance(value, dict) else type(value).model_fields.keys()
        best = max(nested, key=lambda cls: len(keys & model_of(cls).model_fields.keys()))
        return f"<{best.__name__}>"

    whole: Any = Annotated[plain[0], pydantic.Tag("<number>")]
    if len(plain) > 1:
        whole |= Annotated[plain[1], pydantic.Tag("<numbers>")]
    for word in words:
        whole |= Annotated[word, pydantic.Tag("<word>")]
    for cls in nested:
        whole |= Annotated[model_of(cls), pydantic.Tag(f"<{cls.__name__}>")]
    return Annotated[whole, pydantic.Discriminator(tag_of)]
