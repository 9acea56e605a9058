"""Trees of any length: known impulses in O(n) time and memory, without Pinocchio's data."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..display import one_line
from ..errors import (
    InputError,
    NotFiniteError,
    RangeError,
    ShapeError,
    StateError,
    UnknownNameError,
    quoted,
)
from ..robot import Robot
from ..robot.arrays import floats
from ..rows.entries import Site
from ..scene import AppliedImpulse, JointImpulse
from .kernels import layout
from .long_impact import LongImpact
from .tree import Tree, joined_tree, tree_of

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

__all__ = ["LongTree", "long_chain", "long_tree"]

# Tolerance for the length of a unit quaternion.
UNIT = 1e-6
_KINDS = {
    "revolute": layout.ANGLE,
    "prismatic": layout.SLIDE,
    "spherical": layout.QUATERNION,
    "planar": layout.PLANAR,
    "freeflyer": layout.FREE,
}


class LongTree:
    """A tree of any number of rigid bodies under known impulses.

    Created by ``long_chain`` or ``long_tree``. Time and memory are proportional to the number
    of bodies, about 0.8 kB each; Pinocchio's data grow with its cube and end near 600 bodies.

    Attributes:
        bodies: number of bodies; the links are link_1, link_2, ... and their
            joints joint_1, joint_2, ... (the root's "root_joint"), or as in the robot.
        nq, nv: of its configurations and velocities, in Pinocchio's layout.

    Example:
        >>> import numpy as np
        >>> n, com = 999, [1.0, 0.0, 0.0]
        >>> body = {"masses": [1] * n, "centres": [com] * n, "inertias": [np.eye(3)] * n}
        >>> tree = long_tree(np.arange(n) - 1, **body)
        >>> tree.bodies, tree.nv
        (999, 999)
    """

    def __init__(self, tree: Tree, robot: Robot | None = None) -> None:
        self._tree, self._robot = tree, robot
        self.bodies, self.nq, self.nv = tree.bodies, tree.nq, tree.nv

    def __repr__(self) -> str:
        return one_line("LongTree", f"{self.bodies} bodies", nq=self.nq, nv=self.nv)

    def neutral(self) -> np.ndarray:
        """(nq,) angles and lengths zero, rotations none."""
        q = np.zeros(self.nq)
        table = self._tree.ints.reshape(-1, layout.BODY_INTS)[1:]
        for kind, entry in (
            (layout.CIRCLE, 0),
            (layout.GEARED_CIRCLE, 0),
            (layout.PLANAR, 2),
            (layout.QUATERNION, 3),
            (layout.FREE, 6),
        ):
            q[table[table[:, 1] == kind, 2] + entry] = 1.0
        return q

    def solve(
        self,
        impulses: Sequence[AppliedImpulse | JointImpulse],
        q: ArrayLike | None = None,
        v: ArrayLike | None = None,
    ) -> LongImpact:
        """How fast everything moves an instant after known impulses.

        Args:
            impulses: blows on links and kicks in joints, as in a ``Scene``.
            q: (nq,) configuration; the neutral one by default.
            v: (nv,) velocity before; at rest by default.

        Raises:
            InputError: no list of impulses.
            ShapeError, NotFiniteError, StateError: what is wrong with q or v.
            UnknownNameError: no link or joint of that name.
        """
        if not isinstance(impulses, Iterable) or isinstance(impulses, str):
            raise InputError(f"impulses must be a list of impulses, got {quoted(impulses)}")
        q = self.neutral() if q is None else _vector(q, self.nq, "configuration q")
        v = np.zeros(self.nv) if v is None else _vector(v, self.nv, "velocity v")
        self._check_units(q)
        return LongImpact(self, self._tree, tuple(impulses), q, v)

    def site(
        self, frame: str, at: ArrayLike = (0.0, 0.0, 0.0)
    ) -> tuple[int, np.ndarray, np.ndarray]:
        """The body of a frame, a point of the frame in the body's axes, the frame's axes.

        Raises:
            UnknownNameError: no such frame.
        """
        point = np.array(at, dtype=float)
        if self._robot is not None:
            site = Site.of(self._robot, frame, point)
            if not site.moves:
                raise InputError(f'an impulse on "{frame}" moves nothing')
            body = self._tree.body(site.joint_id)
            turn = self._tree.turns[body].T
            return body, turn @ site.placement.translation, turn @ site.placement.rotation
        body = self._numbered(frame, "link")
        turn = self._tree.turns[body].T
        return body, turn @ point, turn

    def body_of_joint(self, joint: str) -> int:
        """The body behind a joint.

        Raises:
            UnknownNameError: no such joint.
        """
        if self._robot is not None:
            return self._tree.body(self._robot.joint_id(joint))
        if joint == "root_joint" and self._tree.ints[layout.BODY_INTS + 4] != 1:
            return 1
        return self._numbered(joint, "joint")

    def _numbered(self, name: str, kind: str) -> int:
        head, _, tail = str(name).partition("_")
        if head == kind and tail.isdecimal() and 1 <= int(tail) <= self.bodies:
            return int(tail)
        known = (f"{kind}_1", f"{kind}_{self.bodies}")
        raise UnknownNameError.among(kind, str(name), known)

    def _check_units(self, q: np.ndarray) -> None:
        table = self._tree.ints.reshape(-1, layout.BODY_INTS)
        for kind, skip, size in (
            (layout.CIRCLE, 0, 2),
            (layout.GEARED_CIRCLE, 0, 2),
            (layout.PLANAR, 2, 2),
            (layout.QUATERNION, 0, 4),
            (layout.FREE, 3, 4),
        ):
            bodies = np.flatnonzero(table[1:, 1] == kind) + 1
            units = q[table[bodies, 2][:, None] + skip + np.arange(size)]
            lengths = np.sqrt((units**2).sum(axis=1))
            wrong = np.flatnonzero(np.abs(lengths - 1.0) > UNIT)
            if wrong.size:
                raise StateError(
                    f"configuration q: the unit vector of body {bodies[wrong[0]]} has length "
                    f"{lengths[wrong[0]]:.9g}, expected 1 within {UNIT:g}",
                    joint=f"joint_{bodies[wrong[0]]}",
                    value=float(lengths[wrong[0]]),
                )


def long_chain(
    links: int = 10,
    mass: float = 1.0,
    length: float = 1.0,
    *,
    radius: float | None = None,
    root: str = "planar",
) -> LongTree:
    """The chain of ``chain_urdf``, of any length: uniform slender rods along x, pinned about z.

    Args:
        links: how many rods.
        mass: of each [kg].
        length: of each [m].
        radius: of each [m]; a fiftieth of the length by default.
        root: how the near end of link_1 is held: "planar", "freeflyer", or "revolute"
            (a pin about z).

    Raises:
        RangeError, NotFiniteError, InputError: as for ``chain_urdf``.

    Example:
        >>> from impulsekit import AppliedImpulse
        >>> chain = long_chain(1000)
        >>> blow = AppliedImpulse("link_1000", linear=[0, 5, 0], at=[1, 0, 0])
        >>> impact = chain.solve([blow])
        >>> round(float(impact.velocity_at("link_1000", at=[1, 0, 0])[1]), 6)
        17.320508
    """
    from ..chain import _checked, _inertias

    n, m, span, r = _checked(links, mass, length, radius)
    if root not in ("planar", "freeflyer", "revolute"):
        raise RangeError.of("root", repr(root), '"planar", "freeflyer" or "revolute"')
    axial, transverse = _inertias(m, span, r)
    inertia = np.zeros((n, 3, 3))
    inertia[:] = np.diag([axial, transverse, transverse])
    translation = np.zeros((n, 3))
    translation[1:, 0] = span
    return long_tree(
        np.arange(-1, n - 1),
        masses=np.full(n, m),
        centres=np.tile([span / 2, 0.0, 0.0], (n, 1)),
        inertias=inertia,
        translations=translation,
        joints=[root, *["revolute"] * (n - 1)],
    )


def long_tree(
    parents: ArrayLike | Robot,
    *,
    masses: ArrayLike | None = None,
    centres: ArrayLike | None = None,
    inertias: ArrayLike | None = None,
    translations: ArrayLike | None = None,
    rotations: ArrayLike | None = None,
    joints: str | Sequence[str] = "revolute",
    axes: ArrayLike = (0.0, 0.0, 1.0),
) -> LongTree:
    """Create a tree from arrays with one row per body, or from a ``Robot``.

    Args:
        parents: (n,) index of each body's parent, from 0; -1 for the world. A parent stands
            before its children. Or a ``Robot``, without further arguments.
        masses: (n,) [kg].
        centres: (n, 3) mass centres in the body's frame, whose origin is its joint [m].
        inertias: (n, 3, 3) about the mass centre, in the body's axes [kg m²].
        translations: (n, 3) of the joint in the parent's frame [m]; zero by default.
        rotations: (n, 3, 3) of the joint's axes in the parent's; none by default.
        joints: "revolute", "prismatic", "spherical", "planar" or "freeflyer"; one for all
            or one each.
        axes: (3,) or (n, 3) unit axes of revolute and prismatic joints, in joint axes.

    Raises:
        ShapeError, NotFiniteError, RangeError, UnknownNameError, InputError.

    Example:
        >>> import numpy as np
        >>> body = {"masses": [1] * 2, "centres": [[0, 0, 0]] * 2, "inertias": [np.eye(3)] * 2}
        >>> two = long_tree([-1, 0], joints="prismatic", **body)
        >>> two.nq, two.nv
        (2, 2)
    """
    if isinstance(parents, Robot):
        model = parents.model
        try:
            return LongTree(tree_of(model, range(1, model.njoints)), parents)
        except KeyError as kind:
            raise InputError(f"a long tree has no joints of the kind {kind}") from None
    above = np.asarray(parents)
    n = above.size
    if above.ndim != 1 or not n or above.dtype.kind not in "iu":
        raise ShapeError.of("parents", (max(n, 1),), above.shape, "whole numbers")
    if (above >= np.arange(n)).any() or above.min() < -1:
        at = int(np.flatnonzero((above >= np.arange(n)) | (above < -1))[0])
        raise RangeError.of(
            f"parents[{at}]", int(above[at]), f"-1 or a body that stands before, 0 to {at - 1}"
        )
    names = [joints] * n if isinstance(joints, str) else list(joints)
    if len(names) != n:
        raise ShapeError.of("joints", (n,), (len(names),))
    for name in set(names):
        if name not in _KINDS:
            raise UnknownNameError.among("kind of joint", str(name), _KINDS)
    if masses is None or centres is None or inertias is None:
        raise InputError("long_tree: give masses, centres and inertias")
    turn = np.broadcast_to(np.eye(3), (n, 3, 3)) if rotations is None else rotations
    shift = np.zeros((n, 3)) if translations is None else translations
    tree = joined_tree(
        above,
        np.array([_KINDS[name] for name in names]),
        _array(np.broadcast_to(np.asarray(axes, dtype=float), (n, 3)), (n, 3), "axes"),
        _array(turn, (n, 3, 3), "rotations"),
        _array(shift, (n, 3), "translations"),
        _array(masses, (n,), "masses"),
        _array(centres, (n, 3), "centres"),
        _array(inertias, (n, 3, 3), "inertias"),
    )
    return LongTree(tree)


def _array(values: Any, shape: tuple[int, ...], what: str) -> np.ndarray:
    array = floats(values, what, copied=False)
    if array.shape != shape:
        raise ShapeError.of(what, shape, array.shape)
    if not np.isfinite(array).all():
        raise NotFiniteError.of(what, "an entry", "a NaN or an infinity")
    return array


def _vector(values: Any, size: int, what: str) -> np.ndarray:
    return np.array(_array(values, (size,), what))
