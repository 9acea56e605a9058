"""Geoms of a MuJoCo model as plain data, coal's shapes of them, which may touch, and states."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import pinocchio as pin

from ..errors import InputError, ShapeError, a_thing
from ..errors.calls import public
from .arrays import array_of

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

# The least condim with which a contact resists sliding, spin about the normal, and rolling.
_SLIDES, _SPINS, _ROLLS = 3, 4, 6


class TouchingPair(NamedTuple):
    """Two geoms that may touch, and their friction.

    Attributes:
        first, second: names of the geoms.
        friction: µ of sliding; 0 for condim 1.
        torsion, rolling: moments over the normal force [m]; 0 below condim 4 and 6.
        fixed: whether the second one is fixed to the world.
        uneven: whether sliding or rolling friction differs between the two tangents.
    """

    first: str
    second: str
    friction: float
    torsion: float
    rolling: float
    fixed: bool
    uneven: bool = False

    def within(self, prefix: str) -> TouchingPair:
        """Return the same with a prefix before its names."""
        return self._replace(first=prefix + self.first, second=prefix + self.second)


# Indices of two geoms, condim, and µ twice, torsion, rolling twice.
_Found = tuple[int, int, int, np.ndarray]


def pairs_of(mj: Any, known: set[str]) -> tuple[TouchingPair, ...]:
    """Return the pairs that MuJoCo tests: by contype and conaffinity, <pair> and <exclude>.

    None where the file disables contacts.

    Args:
        mj: a ``mujoco.MjModel``.
        known: the names of the geoms that have a shape.
    """
    import mujoco

    if mj.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_CONTACT:
        return ()
    explicit = {_signature(mj, mj.pair_geom1[i], mj.pair_geom2[i]): i for i in range(mj.npair)}
    found = []
    for first, second, condim, numbers in (*_automatic(mj, set(explicit)), *_explicit(mj)):
        if mj.body_weldid[mj.geom_bodyid[first]] == 0:
            first, second = second, first
        names = tuple(mj.geom(int(i)).name or f"geom_{i}" for i in (first, second))
        if known.issuperset(names):
            fixed = bool(mj.body_weldid[mj.geom_bodyid[second]] == 0)
            found.append(_pair(mj, names, condim, numbers, fixed=fixed))
    return tuple(found)


def _signature(mj: Any, first: int, second: int) -> tuple[int, int]:
    bodies = int(mj.geom_bodyid[first]), int(mj.geom_bodyid[second])
    return min(bodies), max(bodies)


def _automatic(mj: Any, taken: set[tuple[int, int]]) -> Iterator[_Found]:
    import mujoco

    weld = mj.body_weldid[mj.geom_bodyid]
    parent = mj.body_weldid[mj.body_parentid[weld]]
    excluded = {(int(s) >> 16, int(s) & 0xFFFF) for s in mj.exclude_signature}
    excluded |= {(b, a) for a, b in excluded}
    # The bits of flags differ between versions of MuJoCo.
    with_parents = bool(mj.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_FILTERPARENT)
    for i in range(mj.ngeom):
        touches = (mj.geom_contype[i] & mj.geom_conaffinity[i + 1 :]) | (
            mj.geom_contype[i + 1 :] & mj.geom_conaffinity[i]
        )
        apart = weld[i] != weld[i + 1 :]
        kin = (parent[i + 1 :] == weld[i]) & (weld[i] != 0)
        kin |= (parent[i] == weld[i + 1 :]) & (weld[i + 1 :] != 0)
        for j in np.flatnonzero((touches != 0) & apart & (with_parents | ~kin)) + i + 1:
            bodies = _signature(mj, i, int(j))
            if bodies not in excluded and bodies not in taken:
                yield i, int(j), *_friction(mj, i, int(j))


def _explicit(mj: Any) -> Iterator[_Found]:
    for i in range(mj.npair):
        yield int(mj.pair_geom1[i]), int(mj.pair_geom2[i]), int(mj.pair_dim[i]), mj.pair_friction[i]


def _friction(mj: Any, first: int, second: int) -> tuple[int, np.ndarray]:
    """condim, and µ twice, torsion, rolling twice.

    The geom of higher priority decides, otherwise the larger value of both.
    """
    ends = [first, second]
    priority = mj.geom_priority[ends]
    if priority[0] != priority[1]:
        ends = [ends[int(np.argmax(priority))]]
    slide, spin, roll = mj.geom_friction[ends].max(axis=0)
    return int(mj.geom_condim[ends].max()), np.array([slide, slide, spin, roll, roll])


def _pair(
    mj: Any, names: tuple[str, ...], condim: int, numbers: np.ndarray, *, fixed: bool
) -> TouchingPair:
    """A pair with the coefficients that its condim has; a global override replaces them."""
    import mujoco

    if mj.opt.enableflags & mujoco.mjtEnableBit.mjENBL_OVERRIDE:
        numbers = mj.opt.o_friction
    slide, across, spin, roll, over = map(float, numbers)
    slides, spins, rolls = condim >= _SLIDES, condim >= _SPINS, condim >= _ROLLS
    return TouchingPair(
        names[0],
        names[1],
        slide if slides else 0.0,
        spin if spins else 0.0,
        roll if rolls else 0.0,
        fixed,
        (slides and slide != across) or (rolls and roll != over),
    )


_KINDS = ("plane", "hfield", "sphere", "capsule", "ellipsoid", "cylinder", "box", "mesh")
# MuJoCo draws the groups below this one unless it is told otherwise.
_FIRST_HIDDEN_GROUP = 3
# Half the thickness of the plate that a finite plane is drawn as [m].
_PLATE = 1e-3


@dataclass(frozen=True, eq=False)
class PlainShape:
    """A geom.

    Attributes:
        name: as in the file, or "geom_" and its number.
        frame: the body's frame.
        kind: "plane", "sphere", "capsule", "ellipsoid", "cylinder", "box" or "mesh".
        size: MuJoCo's sizes (half lengths) [m].
        rotation, translation: in the body's frame; (3, 3) and (3,).
        vertices, faces: of a mesh, (n, 3) [m] and (m, 3); None for other kinds.
        rgba: its colour.
        collides, drawn: whether it is collision geometry, whether it is drawn.
        friction: the sliding friction of MuJoCo's contacts.
    """

    name: str
    frame: str
    kind: str
    size: np.ndarray
    rotation: np.ndarray
    translation: np.ndarray
    vertices: np.ndarray | None
    faces: np.ndarray | None
    rgba: tuple[float, ...]
    collides: bool
    drawn: bool
    friction: float


def shapes_of(mj: Any, frames: Sequence[str]) -> tuple[PlainShape, ...]:
    """Return the geoms of a ``mujoco.MjModel`` but height fields and signed distance fields.

    Args:
        mj: the model.
        frames: by body, the name of its frame.
    """
    shapes = []
    for i in range(mj.ngeom):
        number = int(mj.geom_type[i])
        if number >= len(_KINDS) or _KINDS[number] == "hfield":
            continue
        vertices = faces = None
        if _KINDS[number] == "mesh":
            mesh = int(mj.geom_dataid[i])
            first, count = int(mj.mesh_vertadr[mesh]), int(mj.mesh_vertnum[mesh])
            vertices = np.array(mj.mesh_vert[first : first + count], dtype=float)
            first, count = int(mj.mesh_faceadr[mesh]), int(mj.mesh_facenum[mesh])
            faces = np.array(mj.mesh_face[first : first + count], dtype=int)
        material = int(mj.geom_matid[i])
        rgba = mj.mat_rgba[material] if material >= 0 else mj.geom_rgba[i]
        shapes.append(
            PlainShape(
                mj.geom(i).name or f"geom_{i}",
                frames[int(mj.geom_bodyid[i])],
                _KINDS[number],
                np.array(mj.geom_size[i], dtype=float),
                rotation_of(mj.geom_quat[i]),
                np.array(mj.geom_pos[i], dtype=float),
                vertices,
                faces,
                tuple(float(value) for value in rgba),
                bool(mj.geom_contype[i] or mj.geom_conaffinity[i]),
                int(mj.geom_group[i]) < _FIRST_HIDDEN_GROUP,
                float(mj.geom_friction[i][0]),
            )
        )
    return tuple(shapes)


def rotation_of(wxyz: np.ndarray) -> np.ndarray:
    """Return (3, 3) of a quaternion w, x, y, z."""
    w, x, y, z = (float(value) for value in wxyz)
    return pin.Quaternion(w, x, y, z).normalized().toRotationMatrix()


def coal_shape(shape: PlainShape, *, drawn: bool) -> Any:
    """Return the shape as coal has it; None for a plane without end that is to be drawn."""
    import coal

    size = shape.size
    if shape.kind == "plane":
        if not drawn:
            return coal.Halfspace(np.array([0.0, 0.0, 1.0]), 0.0)
        if not size[:2].all():
            return None
        return coal.Box(2.0 * size[0], 2.0 * size[1], 2.0 * _PLATE)
    if shape.kind == "sphere":
        return coal.Sphere(size[0])
    if shape.kind == "capsule":
        return coal.Capsule(size[0], 2.0 * size[1])
    if shape.kind == "cylinder":
        return coal.Cylinder(size[0], 2.0 * size[1])
    if shape.kind == "ellipsoid":
        return coal.Ellipsoid(*size)
    if shape.vertices is None or shape.faces is None:
        return coal.Box(*(2.0 * size))
    mesh = coal.BVHModelOBBRSS()
    mesh.beginModel(len(shape.faces), len(shape.vertices))
    mesh.addVertices(shape.vertices)
    mesh.addTriangles(shape.faces)
    mesh.endModel()
    if not drawn:
        mesh.buildConvexRepresentation(False)
        return mesh.convex
    return mesh


# mjJNT_FREE and mjJNT_BALL.
_FREE, _BALL = 0, 1


@public
def mujoco_state(data: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return q (nq,) and v (nv,) of ``Robot.from_mjcf(data.model)`` at the state of MuJoCo's data.

    MuJoCo's quaternions are w, x, y, z; the linear velocity of its free joints is in world axes,
    the angular one in body axes.

    Args:
        data: a ``mujoco.MjData``; only ``model``, ``qpos`` and ``qvel`` are read.

    Raises:
        InputError: it is no such data.
        ShapeError: of qpos or qvel.

    Example:
        >>> import mujoco
        >>> ball = "<body><freejoint/><geom size='1'/></body>"
        >>> text = f"<mujoco><worldbody>{ball}</worldbody></mujoco>"
        >>> data = mujoco.MjData(mujoco.MjModel.from_xml_string(text))
        >>> mujoco_state(data)[0].tolist()
        [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]
    """
    _check_data(data, "mujoco_state")
    q, v = np.array(data.qpos, dtype=float), np.array(data.qvel, dtype=float)
    for what, own, count in (("qpos", q, data.model.nq), ("qvel", v, data.model.nv)):
        if own.shape != (count,):
            raise ShapeError.of(what, (count,), own.shape)
    for turn, speed in _turns(data.model):
        if speed is not None:
            v[speed] = rotation_of(q[turn]).T @ v[speed]
        q[turn] = np.roll(q[turn], -1)
    return q, v


@public
def set_mujoco_state(data: Any, q: ArrayLike, v: ArrayLike) -> None:
    """Write q (nq,) and v (nv,) of ``Robot.from_mjcf(data.model)`` into MuJoCo's data.

    Nothing else of the data changes: call ``mujoco.mj_forward(data.model, data)`` after it.

    Args:
        data: a ``mujoco.MjData``.
        q, v: the robot's state, as in ``Impact.q`` and ``Impact.v_after``.

    Raises:
        InputError: ``data`` is no such data.
        ShapeError, NotFiniteError.

    Example:
        >>> import mujoco
        >>> ball = "<body><freejoint/><geom size='1'/></body>"
        >>> text = f"<mujoco><worldbody>{ball}</worldbody></mujoco>"
        >>> data = mujoco.MjData(mujoco.MjModel.from_xml_string(text))
        >>> set_mujoco_state(data, [0, 0, 1, 1, 0, 0, 0], [0, 0, -1, 0, 0, 0])
        >>> data.qpos.tolist(), data.qvel.tolist()[:3]
        ([0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0])
    """
    _check_data(data, "set_mujoco_state")
    qpos = array_of(q, (data.model.nq,), "set_mujoco_state: q")
    qvel = array_of(v, (data.model.nv,), "set_mujoco_state: v")
    for turn, speed in _turns(data.model):
        qpos[turn] = np.roll(qpos[turn], 1)
        if speed is not None:
            qvel[speed] = rotation_of(qpos[turn]) @ qvel[speed]
    data.qpos[:], data.qvel[:] = qpos, qvel


def _check_data(data: Any, what: str) -> None:
    if not all(hasattr(data, name) for name in ("model", "qpos", "qvel")):
        raise InputError(f"{what} takes a mujoco.MjData, not {a_thing(data)}")


def _turns(mj: Any) -> Iterator[tuple[slice, slice | None]]:
    """Yield by free or ball joint its quaternion in qpos, its velocity in world axes in qvel."""
    for kind, first, speed in zip(mj.jnt_type, mj.jnt_qposadr, mj.jnt_dofadr, strict=True):
        if kind == _FREE:
            yield slice(first + 3, first + 7), slice(speed, speed + 3)
        elif kind == _BALL:
            yield slice(first, first + 4), None
