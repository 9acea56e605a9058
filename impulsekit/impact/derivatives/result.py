"""``Derivatives``: how v⁺ and every impulse change with what an impact starts from."""

from __future__ import annotations

import weakref
from collections.abc import Callable, Container, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, overload

import numpy as np

from ..._core import Parameters
from ...errors import UnknownNameError
from ...formatting import Displayed
from ...robot.arrays import read_only
from ...scene import AppliedImpulse, Contact, JointStop
from .refusals import refuse_what_has_none
from .status import DerivativeStatus

if TYPE_CHECKING:
    from ..._core import Derivation
    from ...scene import Scene
    from ..flat.scene import FlatScene
    from ..result import Impact

__all__ = ["PARAMETERS", "Derivatives", "layout_of"]

# What derivatives can be taken by, in one impact and in batches.
PARAMETERS = ("q", "v", "impulses", "restitution", "friction", "at", "normal")
ByName: TypeAlias = Mapping[str, np.ndarray]


class Layout:
    """The core's rows and columns of the results and the parameters of a scene.

    It does not hold the scene.

    Attributes:
        starts: of each kind of parameter its first column.
        columns: by parameter its columns: a slice, or by the name of an entry.
        struck: the names of known impulses, which are there whatever touches.
        rows: by result its rows: "v_after", and each constraint and contact by name.
        count: how many rows there are.
    """

    def __init__(self, scene: Scene, flat: FlatScene) -> None:
        self.starts = at = Parameters(flat.core)
        nv, rows = scene.robot.nv, len(flat.names)
        blows, contacts = scene.entry_names("impulses"), scene.entry_names("contacts")
        self.order = at.impulses + np.argsort(np.array(flat.order, dtype=int))
        sizes = np.cumsum([len(entry.values) for entry in scene.impulses])
        placed = [
            name
            for name, entry in zip(blows, scene.impulses, strict=True)
            if isinstance(entry, AppliedImpulse)
        ]
        planes = {i: n for i, n in enumerate(contacts) if isinstance(scene.contacts[i], Contact)}

        def threes(start: int, names: Mapping[int, str]) -> dict[str, slice]:
            return {n: slice(start + 3 * i, start + 3 * i + 3) for i, n in names.items()}

        self.columns: dict[str, Any] = {
            "q": slice(at.q, at.v),
            "v": slice(at.v, at.impulses),
            "impulses": dict(zip(blows, np.split(self.order, sizes[:-1]), strict=False)),
            "restitution": {n: at.restitution + i for i, n in enumerate(contacts)},
            "friction": {n: at.friction + i for i, n in enumerate(contacts)},
            "at": {**threes(at.blow_points, dict(enumerate(placed))), **threes(at.points, planes)},
            "normal": threes(at.normals, planes),
        }
        self.struck = frozenset(blows)
        self.rows = {"v_after": slice(0, nv)}
        for name, where in zip(scene.entry_names("held"), flat.slices, strict=True):
            self.rows[name] = slice(nv + where.start, nv + where.stop)
        for i, (name, entry) in enumerate(zip(contacts, scene.contacts, strict=True)):
            first = nv + rows + 3 * i
            self.rows[name] = slice(first, first + (1 if isinstance(entry, JointStop) else 3))
        self.count = nv + rows + 3 * len(contacts)
        self._weights: dict[tuple[str, ...], np.ndarray] = {}
        self.contacts = slice(nv + rows, self.count)

    def pulled(self, found: Derivation, *of: str) -> np.ndarray:
        """(k, columns) the derivatives of results, one below the other, by all parameters."""
        weights = self._weights.get(of)
        if weights is None:
            unit, rows = np.eye(self.count), {**self.rows, "contact_impulses": self.contacts}
            weights = self._weights[of] = np.concatenate([unit[rows[name]] for name in of])
        return found.pull_back(weights)

    def part(self, table: np.ndarray, by: str, touched: Container[str]) -> np.ndarray | ByName:
        """The columns of one kind of parameter, of contacts those that touch."""
        where = self.columns[by]
        if isinstance(where, slice):
            return table[:, where]
        parts = {n: table[:, c] for n, c in where.items() if n in self.struck or n in touched}
        for array in parts.values():
            array.setflags(write=False)
        return MappingProxyType(parts)


def layout_of(scene: Scene, flat: FlatScene) -> Layout:
    """Return the rows and columns of a scene in the core, made once.

    Raises:
        InputError: scenes that are not differentiated.
    """
    layout = _layouts.get(flat)
    if layout is None:
        refuse_what_has_none(scene)
        layout = _layouts[flat] = Layout(scene, flat)
    return layout


_layouts: weakref.WeakKeyDictionary[FlatScene, Layout] = weakref.WeakKeyDictionary()


@dataclass(frozen=True, eq=False, repr=False)
class Derivatives(Displayed):
    """Derivatives of v⁺ and of all impulses of an impact; arrays are read-only.

    ``found["v_after", "q"]`` is ∂v⁺/∂q. The first name is "v_after", or that of a constraint or
    of a contact that touches, for its impulse p (k,) in the rows and axes of the result: a
    constraint's own rows, a contact's world axes. The second says by what:

    - "q", "v": (k, nv) by the configuration and by v⁻. A change of the configuration is δ (nv,)
      on its tangent, q ⊕ δ as Pinocchio's ``integrate`` has it, along the directions of v.
    - "impulses": by known impulse, (k, 6) linear before angular in the axes of the impulse, or
      (k, n) for one in a joint with n degrees of freedom.
    - "restitution", "friction": by contact that touches, (k,); a restitution that changes with
      speed is shifted as a whole. NaN for one of several redundant contacts, whose coefficients
      can change only together.
    - "at": by known impulse and by contact on a plane that touches, (k, 3) by its point, in the
      coordinates of its frame.
    - "normal": by contact on a plane that touches, (k, 3) in the coordinates of ``against``;
      a change along the normal changes nothing.

    An impulse that shares its load with redundant ones is not determined: NaN.

    Attributes:
        impact: the answer that they belong to.
        status: whether they exist; look at ``status.exists`` first.
        edges: what is on the edge of its mode, a sentence each.
    """

    impact: Impact = field(repr=False)
    status: DerivativeStatus
    edges: tuple[str, ...]
    _layout: Layout = field(repr=False)
    _found: Derivation = field(repr=False)
    _by_inertia: Callable[[int], np.ndarray] = field(repr=False)
    _tables: dict[str, np.ndarray] = field(repr=False, default_factory=dict)

    @property
    def results(self) -> tuple[str, ...]:
        """The results that were differentiated: "v_after", constraints, contacts that touch."""
        names, touched = self.impact.scene.entry_names("contacts"), self._touched
        return tuple(name for name in self._layout.rows if name not in names or name in touched)

    @property
    def _touched(self) -> frozenset[str]:
        names = self.impact.scene.entry_names("contacts")
        return frozenset(names[entry] for entry in self.impact.solved.core.rows.entries)

    @overload
    def __getitem__(self, key: tuple[str, Literal["q", "v"]]) -> np.ndarray: ...

    @overload
    def __getitem__(
        self,
        key: tuple[str, Literal["impulses", "restitution", "friction", "at", "normal"]],
    ) -> ByName: ...

    @overload
    def __getitem__(self, key: tuple[str, str]) -> Any: ...

    def __getitem__(self, key: tuple[str, str]) -> Any:
        """Return ∂ of the first by the second: an array, or arrays by name."""
        of, by = key
        if by not in PARAMETERS:
            raise UnknownNameError.among("parameter", str(by), PARAMETERS)
        table = self._tables.get(of)
        if table is None:
            if of != "v_after" and of not in self.results:
                raise UnknownNameError.among("result", str(of), self.results)
            table = self._tables[of] = read_only(self._layout.pulled(self._found, of))
        return self._layout.part(table, by, self._touched)

    def by_state(self, *of: str) -> dict[str, np.ndarray]:
        """By result (k, 2 nv) its derivatives by q and v, side by side.

        Args:
            of: "v_after", or "contact_impulses" (3 C,) of all contacts in world axes, zero where
                they do not touch.
        """
        nv = self.impact.scene.robot.nv
        table = self._layout.pulled(self._found, *of)[:, : 2 * nv]
        found, start = {}, 0
        for name in of:
            size = nv if name == "v_after" else len(table) - start
            found[name] = table[start : start + size]
            start += size
        return found

    def by_inertia(self, joint: str) -> np.ndarray:
        """(nv, 10) ∂v⁺ by the inertia of the body behind a joint.

        Its parameters are those of ``pinocchio.Inertia.toDynamicParameters``: m, m c (3),
        then I_xx, I_xy, I_yy, I_xz, I_yz, I_zz about the joint's origin, in its frame.

        Raises:
            UnknownNameError: the robot has no such joint.
        """
        return read_only(self._by_inertia(self.impact.scene.robot.joint_id(joint)))
