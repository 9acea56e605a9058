"""Trees of any length: known impulses in O(n) time and memory, without Pinocchio's data."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from .._core import Bodies, Joint, Model, joint_sizes, unit_parts
from ..errors import (
    InputError,
    NotFiniteError,
    RangeError,
    ShapeError,
    StateError,
    UnknownNameError,
    a_thing,
    quoted,
)
from ..errors.calls import public
from ..formatting import one_line
from ..impact.flat.model import flat_model_of
from ..robot import Robot
from ..robot.arrays import floats, lock
from ..rows.entries import Site
from ..scene import AppliedImpulse, JointImpulse
from ..scene.numbers import vector

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

__all__ = ["LongImpact", "LongTree", "long_chain", "long_tree"]

# Tolerance for the length of a unit vector.
UNIT = 1e-6
_KINDS = {
    "revolute": Joint.angle,
    "prismatic": Joint.slide,
    "spherical": Joint.ball,
    "planar": Joint.planar,
    "freeflyer": Joint.free,
}


@public
class LongTree:
    """A tree of any number of rigid bodies under known impulses.

    Created by ``long_chain`` or ``long_tree``. Time and memory are proportional to the number
    of bodies, about 2 kB each; Pinocchio's data grow with its cube and end near 600 bodies.

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

    def __init__(
        self, core: Model, joints: np.ndarray, bodies: np.ndarray, robot: Robot | None = None
    ) -> None:
        # (bodies, 3) first entries of q and v of each joint, and its entries of v; the core's body
        # of each; (units, 2) first entry and length of each unit vector in q.
        self._core, self._joints, self._bodies, self._robot = core, joints, bodies, robot
        self.bodies = len(bodies)
        self.nq, self.nv = core.nq, core.nv
        self._units = np.array(unit_parts(core), dtype=int).reshape(-1, 2)

    def __repr__(self) -> str:
        return one_line("LongTree", f"{self.bodies} bodies", nq=self.nq, nv=self.nv)

    def neutral(self) -> np.ndarray:
        """(nq,) angles and lengths zero, rotations none."""
        if self._robot is not None:
            return self._robot.neutral()
        q = np.zeros(self.nq)
        # A circle begins with its cosine, a quaternion ends with what is 1.
        first, size = self._units.T
        q[first + np.where(size == 2, 0, 3)] = 1.0
        return q

    def solve(
        self,
        impulses: Sequence[AppliedImpulse | JointImpulse],
        q: ArrayLike | None = None,
        v: ArrayLike | None = None,
    ) -> LongImpact:
        """Solve how fast everything moves an instant after known impulses.

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
        return LongImpact(self, tuple(impulses), q, v)

    def site(
        self, frame: str, at: ArrayLike = (0.0, 0.0, 0.0)
    ) -> tuple[int, np.ndarray, np.ndarray]:
        """The body of a frame, from 0, a point of the frame and its axes in those of the joint.

        Raises:
            UnknownNameError: no such frame.
        """
        point = np.array(at, dtype=float)
        if self._robot is None:
            return self._numbered(frame, "link"), point, np.eye(3)
        site = Site.of(self._robot, frame, point)
        if not site.moves:
            raise InputError(f'an impulse on "{frame}" moves nothing')
        return site.joint_id - 1, site.placement.translation, site.placement.rotation

    def speeds_of_joint(self, joint: str) -> tuple[int, int]:
        """The first entry of v of a joint, and how many it has.

        Raises:
            UnknownNameError: no such joint.
        """
        if self._robot is not None:
            body = self._robot.joint_id(joint) - 1
        elif joint == "root_joint" and self._joints[0, 2] != 1:
            body = 0
        else:
            body = self._numbered(joint, "joint")
        return int(self._joints[body, 1]), int(self._joints[body, 2])

    def _numbered(self, name: str, kind: str) -> int:
        head, _, tail = str(name).partition("_")
        if head == kind and tail.isdecimal() and 1 <= int(tail) <= self.bodies:
            return int(tail) - 1
        known = (f"{kind}_1", f"{kind}_{self.bodies}")
        raise UnknownNameError.among(kind, str(name), known)

    def _check_units(self, q: np.ndarray) -> None:
        for size in (2, 4):
            first = self._units[self._units[:, 1] == size, 0]
            lengths = np.linalg.norm(q[first[:, None] + np.arange(size)], axis=1)
            wrong = np.flatnonzero(np.abs(lengths - 1.0) > UNIT)
            if wrong.size:
                body = int(np.searchsorted(self._joints[:, 0], first[wrong[0]], side="right"))
                length = float(lengths[wrong[0]])
                raise StateError(
                    f"configuration q: the unit vector of body {body} has length "
                    f"{length:.9g}, expected 1 within {UNIT:g}",
                    joint=f"joint_{body}",
                    value=length,
                )


@public
class LongImpact:
    """The result of an impact on a long tree. All arrays are read-only.

    Attributes:
        dv: (nv,) the velocity jump.
        v_after: (nv,) the velocity after.
        q, v_before: (nq,), (nv,) the state before.
        twists_after: (bodies, 6) velocity of each joint's origin as of its child, and angular
            velocity, world axes [m/s, rad/s].
        reactions: (bodies, 6) the wrench impulse that each parent gives its child, at the joint's
            origin, world axes, linear [N s] before angular [N m s].

    Example:
        >>> import numpy as np
        >>> from impulsekit import AppliedImpulse
        >>> from impulsekit.long import long_chain
        >>> chain = long_chain(1000)
        >>> blow = AppliedImpulse("link_1000", linear=[0, 5, 0])
        >>> impact = chain.solve([blow], chain.neutral(), np.zeros(chain.nv))
        >>> impact.dv.shape == (chain.nv,)
        True
    """

    def __init__(
        self,
        owner: LongTree,
        impulses: tuple[AppliedImpulse | JointImpulse, ...],
        q: np.ndarray,
        v: np.ndarray,
    ) -> None:
        self._owner, self.q, self.v_before = owner, q, v
        core, of_core = owner._core, owner._bodies
        places = core.placements(q).reshape(-1, 12)[of_core]
        self._turns = places[:, :9].reshape(-1, 3, 3)
        struck, wrenches, kicks = self._acting(impulses)
        bodies = of_core[struck].astype(np.intc)
        found = core.apply_impulses(q, v, kicks, bodies, wrenches)
        self.dv = found.dv
        self.v_after = v + self.dv
        self.twists_after = found.twists.reshape(-1, 6)[of_core - 1]
        self.reactions = found.reactions.reshape(-1, 6)[of_core - 1]
        lock(q, v, self.dv, self.v_after, self.twists_after, self.reactions)

    def __repr__(self) -> str:
        jump = f"|dv|={float(np.linalg.norm(self.dv)):.6g}"
        return one_line("LongImpact", f"{self._owner.bodies} bodies", jump)

    def velocity_at(self, link: str, at: ArrayLike = (0.0, 0.0, 0.0)) -> np.ndarray:
        """(3,) the velocity of a point of a link after the impact, world axes [m/s].

        Args:
            link: the link.
            at: the point in the link's coordinates [m].
        """
        body, point, _ = self._owner.site(link, vector(at, "at"))
        twist = self.twists_after[body]
        found: np.ndarray = twist[:3] + np.cross(twist[3:], self._turns[body] @ point)
        return found

    def _acting(
        self, impulses: tuple[AppliedImpulse | JointImpulse, ...]
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return struck bodies, (k, 6) wrenches in the axes of their joints, (nv,) in joints."""
        struck: list[int] = []
        wrenches: list[np.ndarray] = []
        kicks = np.zeros(self._owner.nv)
        for entry in impulses:
            if isinstance(entry, AppliedImpulse):
                body, point, axes = self._owner.site(entry.frame, entry.at)
                turn = axes if entry.axes == "local" else self._turns[body].T
                force = turn @ entry.linear
                wrenches.append(
                    np.array([*force, *(turn @ entry.angular + np.cross(point, force))])
                )
                struck.append(body)
            elif isinstance(entry, JointImpulse):
                first, size = self._owner.speeds_of_joint(entry.joint)
                if len(entry.values) != size:
                    what = f'impulse in joint "{entry.joint}"'
                    raise ShapeError.of(what, (size,), (len(entry.values),))
                kicks[first : first + size] += entry.values
            else:
                raise InputError(
                    f"an impulse must be an AppliedImpulse or a JointImpulse, got {a_thing(entry)}"
                )
        return np.array(struck, dtype=int), np.concatenate([*wrenches, np.zeros(0)]), kicks


@public
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


@public
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
        return _of_robot(parents)
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
    return _joined(
        above,
        np.array([_KINDS[name] for name in names]),
        _array(np.broadcast_to(np.asarray(axes, dtype=float), (n, 3)), (n, 3), "axes"),
        _array(turn, (n, 3, 3), "rotations"),
        _array(shift, (n, 3), "translations"),
        _array(masses, (n,), "masses"),
        _array(centres, (n, 3), "centres"),
        _array(inertias, (n, 3, 3), "inertias"),
    )


def _of_robot(robot: Robot) -> LongTree:
    model = robot.model
    flat = flat_model_of(robot)
    if flat.core.has_followers or flat.core.has_ellipsoids:
        raise InputError("a long tree has no joints that follow others, and no ellipsoids")
    joints = np.array([(joint.idx_q, joint.idx_v, joint.nv) for joint in list(model.joints)[1:]])
    return LongTree(flat.core, joints, np.array(flat.bodies[1:]), robot)


def _joined(
    parents: np.ndarray,
    kinds: np.ndarray,
    axes: np.ndarray,
    rotations: np.ndarray,
    translations: np.ndarray,
    masses: np.ndarray,
    centres: np.ndarray,
    inertias: np.ndarray,
) -> LongTree:
    n = len(parents)
    sizes = np.array(joint_sizes())[kinds]
    first = np.cumsum(sizes, axis=0) - sizes
    square = (centres**2).sum(axis=1)[:, None, None] * np.eye(3)
    about = inertias + masses[:, None, None] * (square - centres[:, :, None] * centres[:, None, :])
    rows, columns = np.triu_indices(3)
    bodies = Bodies(
        parent=(parents + 1).astype(np.intc),
        joint=kinds.astype(np.intc),
        q=first[:, 0].astype(np.intc),
        v=first[:, 1].astype(np.intc),
        axis=axes,
        rotation=rotations,
        shift=translations,
        mass=masses,
        moment=masses[:, None] * centres,
        inertia=np.ascontiguousarray(about[:, rows, columns]),
        pitch=np.zeros(n),
        ratio=np.ones(n),
        offset=np.zeros(n),
    )
    nq, nv = sizes.sum(axis=0).tolist()
    joints = np.column_stack([first, sizes[:, 1]])
    return LongTree(Model(bodies, np.zeros(nv), nq), joints, np.arange(1, n + 1))


def _array(values: Any, shape: tuple[int, ...], what: str) -> np.ndarray:
    array = floats(values, what, copied=False)
    if array.shape != shape:
        raise ShapeError.of(what, shape, array.shape)
    if not np.isfinite(array).all():
        raise NotFiniteError.of(what, "an entry", "a NaN or an infinity")
    return array


def _vector(values: Any, size: int, what: str) -> np.ndarray:
    return np.array(_array(values, (size,), what))
