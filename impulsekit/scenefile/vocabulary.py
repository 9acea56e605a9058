"""The lists of a scene file, and the frozen dataclasses that their entries become.

How to add an entry kind:

1. Write the frozen dataclass in ``scene/``, an ``Entry``. Its fields are the keys of the file, so
   they are text, numbers, booleans, or tuples of these; their types carry their checks
   (``NotNegative``, ``Vector``, ``Name``), and ``_check`` has what no field has by itself.
2. ``section`` names the list of ``Scene``; ``check_robot`` proves that an entry fits a robot.
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

from ..errors import ImpulsekitError, UnknownNameError, quoted
from ..robot import Robot
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
from .faults import Faults

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
        if item.name in ("stiffness", "stiffness_ratio") and cls in _CONTACTS:
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


# Keys that a table cannot have by mistake but for standing below it.
MOVED = ("gravity", "gap_bound", "controlled")


def read_section(section: Section, raw: Any, robot: Robot | None, faults: Faults) -> Any:
    """Return the entries of a section that could be made, each checked alone against the robot."""
    if not section.many:
        raw = (raw,)
    if not isinstance(raw, tuple):
        faults.add(f"{section.name} must be a list of tables, [[{section.name}]]")
        return ()
    entries = []
    for i, table in enumerate(raw):
        place = f"{section.name}[{i}]" if section.many else section.name
        if not isinstance(table, dict):
            faults.add(f"{place} must be a table, got {quoted(table)}")
            continue
        entry = _read_entry(section, table, place, faults)
        if entry is not None:
            if robot is not None:
                _check_entry(robot, entry, place, faults)
            entries.append(entry)
    return tuple(entries) if section.many else next(iter(entries), None)


def _read_entry(section: Section, table: dict[str, Any], place: str, faults: Faults) -> Any:
    kind = _kind(section, table, place, faults)
    if kind is None:
        return None
    cls = section.kinds[kind]
    if len(section.kinds) > 1:
        table = {key: value for key, value in table.items() if key != "kind"}
    model = faults.validated(model_of(cls), table, place, MOVED)
    if model is None:
        return None
    return _made(cls, model, place, faults)


def _made(cls: type, model: pydantic.BaseModel, place: str, faults: Faults) -> Any:
    """The dataclass that a model stands for, or what is left of it without faulty fields."""
    values: dict[str, Any] = {}
    for key in [name for name in type(model).model_fields if name in model.model_fields_set]:
        value = getattr(model, key)
        if isinstance(value, pydantic.BaseModel):
            nested = next(one for one in NESTED if model_of(one) is type(value))
            value = _made(nested, value, f"{place}.{key}", faults)
            if value is None:
                continue
        values[key] = value
    while True:
        try:
            return cls(**values)
        except ImpulsekitError as error:
            field = faults.add_error(place, error)
            if field not in values or model_of(cls).model_fields[field].is_required():
                return None
            del values[field]


def _kind(section: Section, table: dict[str, Any], place: str, faults: Faults) -> str | None:
    kinds = section.kinds
    if len(kinds) == 1:
        return next(iter(kinds))
    if "kind" in table:
        kind = table["kind"]
        if not isinstance(kind, str) or kind not in kinds:
            faults.add(f"{place}.kind: {UnknownNameError.among('kind', str(kind), kinds)}")
            return None
        return kind
    if not section.needs_kind:
        # The kind with most keys of the entry, so that a misspelt key is reported as such.
        shared = {
            kind: len(table.keys() & set(model_of(cls).model_fields)) for kind, cls in kinds.items()
        }
        best = [kind for kind, count in shared.items() if count == max(shared.values())]
        if len(best) == 1:
            return best[0]
    names = ", ".join(f'"{kind}"' for kind in kinds)
    faults.add(f"{place}.kind is missing, expected one of {names}")
    return None


def _check_entry(robot: Robot, entry: Any, place: str, faults: Faults) -> None:
    """Check one entry against the robot.

    An unknown name is put right and the entry tried again, so that the next one shows.
    """
    put_right = False
    for _ in range(16):
        try:
            entry.check_robot(robot, place)
            return
        except UnknownNameError as error:
            at, better = _with_name_put_right(entry, error)
            faults.add(f"{place}{at}: {str(error).removeprefix(f'{place}: ')}")
            if better is None:
                return
            entry, put_right = better, True
        except ImpulsekitError as error:
            # What follows from the name that was put in is no fault of the file.
            if not put_right:
                faults.add(str(error))
            return


def _with_name_put_right(entry: Any, error: UnknownNameError) -> tuple[str, Any]:
    """The place of an unknown name in an entry, and the entry with a known one instead."""
    right = next(iter((*error.nearest, *error.known)), None)
    for item in dataclasses.fields(entry):
        value = getattr(entry, item.name)
        if isinstance(value, tuple) and error.name in value:
            better: Any = tuple(right if x == error.name else x for x in value)
        elif value == error.name:
            better = right
        else:
            continue
        try:
            return f".{item.name}", dataclasses.replace(entry, **{item.name: better})
        except ImpulsekitError:
            return f".{item.name}", None
    return "", None
