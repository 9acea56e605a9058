"""``LongImpact``: what known impulses do to a long tree."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Protocol

import numpy as np

from ..display import one_line
from ..errors import InputError, ShapeError, a_thing
from ..robot.arrays import lock, read_only
from ..scene import AppliedImpulse, JointImpulse
from ..scene.numbers import vector
from .kernels import layout
from .tree import Tree

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


__all__ = ["LongImpact"]


class Named(Protocol):
    """Links and joints of a long tree by name, as ``LongTree`` has them."""

    def site(self, frame: str, at: ArrayLike) -> tuple[int, np.ndarray, np.ndarray]:
        """The body of a frame, a point of the frame in the body's axes, the frame's axes."""

    def body_of_joint(self, joint: str) -> int:
        """The body behind a joint."""


class LongImpact:
    """The result of an impact on a long tree. All arrays are read-only.

    Attributes:
        dv: (nv,) the velocity jump.
        v_after: (nv,) the velocity after.
        q, v_before: (nq,), (nv,) the state before.

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
        owner: Named,
        tree: Tree,
        impulses: tuple[AppliedImpulse | JointImpulse, ...],
        q: np.ndarray,
        v: np.ndarray,
    ) -> None:
        from .kernels.alone import jump

        self._owner, self._tree = owner, tree
        self.q, self.v_before = q, v
        self._places = layout.places(tree.bodies, tree.nq, tree.nv, 0, 0, 0, 0)
        dof_at, q_at, v_at, dv_at = self._places[:4]
        self._dof_at = dof_at
        self._blows = self._tables(impulses)
        # Zeros, so that no body is loaded that nothing strikes.
        self._work = work = np.zeros(self._places[-1])
        work[q_at:v_at] = q
        work[v_at:dv_at] = v
        mask = self._loaded()
        loaded, placed = (mask, np.flatnonzero(mask)), np.ones(tree.bodies + 1, dtype=bool)
        tables = tree.ints, tree.floats, tree.dofs, tree.armature
        jump(*tables, tree.bodies, loaded, placed, self._blows, work, self._places)
        self.dv = work[dv_at : dv_at + tree.nv].copy()
        self.v_after = v + self.dv
        lock(self.q, self.v_before, self.dv, self.v_after)

    def __repr__(self) -> str:
        jump = f"|dv|={float(np.linalg.norm(self.dv)):.6g}"
        return one_line("LongImpact", f"{self._tree.bodies} bodies", jump)

    @cached_property
    def reactions(self) -> np.ndarray:
        """(bodies, 6) the wrench impulse that each parent gives its child.

        At the joint's origin, world axes, linear [N s] before angular [N m s].
        """
        from .kernels.alone import reactions

        tree, rows = self._tree, self._rows()
        rows[:, layout.FORCE : layout.FORCE + 6] = 0.0
        reactions(tree.ints, tree.floats, tree.bodies, self._blows, self._work, self._places)
        found = self._in_world(layout.FORCE)[1:]
        return read_only(found)

    def velocity_at(self, link: str, at: ArrayLike = (0.0, 0.0, 0.0)) -> np.ndarray:
        """(3,) the velocity of a point of a link after the impact, world axes [m/s].

        Args:
            link: the link.
            at: the point in the link's coordinates [m].
        """
        body, point, _ = self._owner.site(link, vector(at, "at"))
        row = self._twists[body] + self._rows()[body, layout.JUMP : layout.JUMP + 6]
        rotation = self._rows()[body, layout.ROTATION : layout.ROTATION + 9].reshape(3, 3)
        return rotation @ (row[:3] + np.cross(row[3:], point))

    @cached_property
    def twists_after(self) -> np.ndarray:
        """(bodies, 6) velocity of each joint's origin as of its child, and angular velocity."""
        found = (self._turned(self._twists) + self._in_world(layout.JUMP))[1:]
        return read_only(found)

    @cached_property
    def _twists(self) -> np.ndarray:
        """(bodies + 1, 6) the twists before the impact, in the axes of the bodies."""
        from .kernels.alone import speeds

        rows = self._rows()[:, layout.TWIST : layout.TWIST + 6]
        if not self.v_before.any():
            return np.zeros_like(rows)
        tree, everyone = self._tree, np.arange(1, self._tree.bodies + 1)
        speeds(tree.ints, tree.floats, tree.dofs, everyone, self._work, self._places)
        return rows

    def _in_world(self, first: int) -> np.ndarray:
        """(bodies + 1, 6) spatial vectors of the bodies' rows in world axes."""
        return self._turned(self._rows()[:, first : first + 6])

    def _turned(self, vectors: np.ndarray) -> np.ndarray:
        """(bodies + 1, 6) spatial vectors in the axes of the bodies, in world axes."""
        rotations = self._rows()[:, layout.ROTATION : layout.ROTATION + 9].reshape(-1, 3, 3)
        return np.einsum("bij,bkj->bki", rotations, vectors.reshape(-1, 2, 3)).reshape(-1, 6)

    def _rows(self) -> np.ndarray:
        """(bodies + 1, BODY) what the kernels know of each body."""
        return self._work[: self._dof_at].reshape(-1, layout.BODY)

    def _loaded(self) -> np.ndarray:
        """(bodies + 1,) True for the bodies struck and all between them and the world."""
        ints, _, kicks, _ = self._blows
        table = self._tree.ints.reshape(-1, layout.BODY_INTS)
        parents = table[:, 0].tolist()
        firsts = table[1:, 3]
        struck = ints[:: layout.BLOW_INTS].tolist()
        struck += np.searchsorted(firsts, kicks[::2], side="right").tolist()
        loaded = np.zeros(self._tree.bodies + 1, dtype=bool)
        for body in struck:
            while body > 0 and not loaded[body]:
                loaded[body] = True
                body = parents[body]
        return loaded

    def _tables(
        self, impulses: tuple[AppliedImpulse | JointImpulse, ...]
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        ints: list[int] = []
        floats: list[np.ndarray] = []
        kicks: list[int] = []
        given: list[float] = []
        for entry in impulses:
            if isinstance(entry, AppliedImpulse):
                body, point, axes = self._owner.site(entry.frame, entry.at)
                ints.extend((body, int(entry.axes == "local"), len(given)))
                floats.extend((point, axes.ravel()))
                given.extend((*entry.linear, *entry.angular))
            elif isinstance(entry, JointImpulse):
                at = self._owner.body_of_joint(entry.joint) * layout.BODY_INTS
                first, size = self._tree.ints[at + 3 : at + 5].tolist()
                if len(entry.values) != size:
                    raise ShapeError.of(
                        f'impulse in joint "{entry.joint}"', (size,), (len(entry.values),)
                    )
                for k in range(size):
                    kicks.extend((first + k, len(given) + k))
                given.extend(entry.values)
            else:
                raise InputError(
                    f"an impulse must be an AppliedImpulse or a JointImpulse, got {a_thing(entry)}"
                )
        return (
            np.array(ints, dtype=np.int64),
            np.concatenate([*floats, np.zeros(0)]),
            np.array(kicks, dtype=np.int64),
            np.array(given, dtype=float),
        )
