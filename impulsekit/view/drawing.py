"""``Drawing``: the objects of a page, as commands for meshcat's player."""

from __future__ import annotations

import pathlib
import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np
import pinocchio as pin
import umsgpack

from ..errors import MissingExtraError

with warnings.catch_warnings():
    # meshcat 0.3.2 still imports an event loop that pyzmq has given up. No server is started.
    warnings.filterwarnings("ignore", message=r"zmq\.eventloop\.ioloop", append=False)
    warnings.filterwarnings("ignore", category=SyntaxWarning, module=r"meshcat\.")
    import meshcat
    from meshcat import geometry as shapes

ROOT = "impulsekit"
SEGMENTS = 32


def packed(command: dict[str, Any]) -> bytes:
    """Pack a command as meshcat's player reads it."""
    return umsgpack.packb(command)


def player_script() -> str:
    """Return the JavaScript of meshcat's own player, from the installed package.

    Raises:
        MissingExtraError: the package came without it.
    """
    path = pathlib.Path(str(meshcat.__file__)).parent / "viewer" / "dist" / "main.min.js"
    try:
        return path.read_text(encoding="utf-8")
    except OSError:
        raise MissingExtraError(
            f"meshcat came without its player, {path}: pip install --force-reinstall meshcat",
            package="meshcat",
            extra="",
        ) from None


def node_name(index: int, name: str) -> str:
    """Return a node's name: never the same twice, never a path, never a word JavaScript knows.

    Example:
        >>> node_name(3, "arm/elbow")
        '3 arm:elbow'
    """
    return f"{index} {name.replace('/', ':')}"


def node_path(path: Sequence[str]) -> str:
    """Return the path of a node in the player."""
    return "/" + "/".join((ROOT, *path))


class Lathe(shapes.Geometry):
    """The surface that a (p, 2) profile of radius and height [m] sweeps about the z axis.

    A point that is listed twice in a row is a sharp edge.
    """

    def __init__(self, profile: Any, segments: int = SEGMENTS) -> None:
        super().__init__()
        self.points = [{"x": float(x), "y": float(y)} for x, y in profile]
        self.segments = segments

    def intrinsic_transform(self) -> np.ndarray:
        """Return the rotation that undoes the player's, which turns profiles about its y axis."""
        return np.array([[1.0, 0, 0, 0], [0, 0, -1.0, 0], [0, 1.0, 0, 0], [0, 0, 0, 1.0]])

    def lower(self, _data: dict[str, Any]) -> dict[str, Any]:
        """Return it as three.js writes it."""
        whole = {"phiStart": 0.0, "phiLength": 2.0 * np.pi, "segments": self.segments}
        return {"uuid": self.uuid, "type": "LatheGeometry", "points": self.points} | whole


def capsule(radius: float, half_length: float) -> Lathe:
    """Return a cylinder along z of twice the ``half_length`` with round ends [m]."""
    angles = np.linspace(-0.5 * np.pi, 0.5 * np.pi, SEGMENTS // 2 + 2)
    heights = radius * np.sin(angles) + np.where(angles > 0.0, half_length, -half_length)
    return Lathe(np.column_stack([radius * np.maximum(np.cos(angles), 0.0), heights]))


def cylinder(radius: float, half_length: float, top_radius: float | None = None) -> Lathe:
    """Return a cylinder along z about the origin; with a ``top_radius`` a cone [m]."""
    top = radius if top_radius is None else top_radius
    low, high = (radius, -half_length), (top, half_length)
    return Lathe([(0.0, -half_length), low, low, high, high, (0.0, half_length)])


def arrow(length: float, width: float, heads: int = 1) -> Lathe:
    """Return an arrow along z from the origin to ``length``, its shaft ``width`` thick [m].

    Two ``heads`` mean a couple. A short arrow gets a smaller head, never a longer body.
    """
    head = min(3.2 * width, 0.8 * length / heads)
    shaft, rim = 0.5 * min(width, 0.5 * head), 0.36 * head
    base = length - heads * head
    profile = [(0.0, 0.0), (shaft, 0.0), (shaft, 0.0), (shaft, base), (shaft, base)]
    for i in range(heads):
        z = base + i * head
        profile += [(rim, z), (rim, z), (0.0, z + head), (0.0, z + head)]
    return Lathe(profile, 20)


class Tube(shapes.Geometry):
    """A tube of ``radius`` along the (n, 3) ``points`` [m], n of 2 or more."""

    def __init__(self, points: np.ndarray, radius: float) -> None:
        super().__init__()
        self.points, self.radius = points, radius

    def lower(self, _data: dict[str, Any]) -> dict[str, Any]:
        """Return it as three.js writes it."""
        count = len(self.points)
        curve = {"type": "CatmullRomCurve3", "points": self.points.tolist(), "closed": False,
                 "curveType": "centripetal", "arcLengthDivisions": 2 * count}  # fmt: skip
        return {"uuid": self.uuid, "type": "TubeGeometry", "path": curve, "radius": self.radius,
                "tubularSegments": count - 1, "radialSegments": 6, "closed": False}  # fmt: skip


class Drawing:
    """Objects, their places and their tracks over playback time.

    Paths are tuples of node names below ``ROOT``.

    Attributes:
        commands: in the order in which the player runs them.
    """

    def __init__(self) -> None:
        self.commands: list[dict[str, Any]] = []
        self._clips: dict[str, list[dict[str, Any]]] = {}

    def add(
        self,
        path: Sequence[str],
        shape: shapes.Geometry,
        color: Sequence[float],
        placements: Sequence[pin.SE3] = (),
        *,
        glow: float = 0.0,
        shade: float = 0.0,
        one_sided: bool = False,
    ) -> None:
        """Draw a shape once, or once at each of several ``placements``.

        Args:
            path: the node; its own transform comes on top.
            shape: of meshcat's geometries.
            color: red, green, blue and opacity in [0, 1].
            placements: copies share one geometry.
            glow: the share of its colour that shines without light, for arrows.
            shade: opacity with which it is seen through everything before it.
            one_sided: it is not seen from behind, as nothing translucent is.
        """
        opacity = float(color[3]) if len(color) > 3 else 1.0
        solid = opacity == 1.0
        # Flat shading keeps the edges of CAD parts.
        flat = isinstance(shape, shapes.TriangularMeshGeometry)
        look = {
            "color": _hex(color),
            "vertexColors": flat and shape.color is not None,
            "flatShading": flat,
            "shininess": 20,
            "specular": 0x222222,
            "emissive": _hex([glow * c for c in color[:3]]),
        }
        side = 2 if solid and not one_sided else 0
        materials = [shapes.MeshPhongMaterial(opacity=opacity, side=side, depthWrite=solid, **look)]
        if shade > 0.0:
            seen = {"transparent": True, "depthTest": False, "depthWrite": False}
            materials.append(shapes.MeshPhongMaterial(opacity=shade, **seen, **look))
        data: dict[str, Any] = {"geometries": [], "materials": []}
        # Names that are the same at every run, unlike meshcat's.
        shape.uuid = "geometry"
        shape.lower_in_object(data)
        for i, material in enumerate(materials):
            material.uuid = f"material {i}"
            material.lower_in_object(data)
        own = shape.intrinsic_transform()
        turns = [placement.homogeneous @ own for placement in placements] or [own]
        meshes = [
            {
                "uuid": f"mesh {i} {j}",
                "type": "Mesh",
                "geometry": shape.uuid,
                "material": material.uuid,
                "matrix": turn.T.ravel().tolist(),
            }
            for i, turn in enumerate(turns)
            for j, material in enumerate(materials)
        ]
        group = {"uuid": "group", "type": "Group", "children": meshes}
        self.add_object(node_path(path), meshes[0] if len(meshes) == 1 else group, **data)

    def add_lines(self, path: Sequence[str], points: np.ndarray, color: Sequence[float]) -> None:
        """Draw (n, 3) points two by two as thin lines [m]."""
        data = {"attributes": {"position": shapes.pack_numpy_array(points.T)}}
        self.add_object(
            node_path(path),
            {"uuid": "lines", "type": "LineSegments", "geometry": "points", "material": "line"},
            [{"uuid": "points", "type": "BufferGeometry", "data": data}],
            [{"uuid": "line", "type": "LineBasicMaterial", "color": _hex(color)}],
        )

    def add_object(
        self,
        path: str,
        thing: dict[str, Any],
        geometries: Sequence[dict[str, Any]] = (),
        materials: Sequence[dict[str, Any]] = (),
    ) -> None:
        """Draw an object of three.js, such as a light, at an absolute path."""
        whole = {
            "metadata": {"version": 4.5, "type": "Object"},
            "geometries": list(geometries),
            "materials": list(materials),
            "object": thing,
        }
        self.commands.append({"type": "set_object", "path": path, "object": whole})

    def place(self, path: Sequence[str], placement: pin.SE3) -> None:
        """Put a node at a placement in its parent."""
        matrix = placement.homogeneous.T.ravel().tolist()
        self.commands.append({"type": "set_transform", "path": node_path(path), "matrix": matrix})

    def set(self, path: str, key: str, value: Any) -> None:
        """Set a property of a node, or of the camera or background, at an absolute path."""
        self.commands.append(
            {"type": "set_property", "path": path, "property": key, "value": value}
        )

    def move(
        self,
        path: Sequence[str],
        times: np.ndarray,
        places: np.ndarray,
        scales: np.ndarray | None = None,
    ) -> None:
        """Let a node go through (F, 7) ``places``, xyz and quaternion xyzw, at (F,) times [s].

        It is drawn ``scales`` (F,) as large. Constant values get no track.
        """
        self.place(path, pin.XYZQUATToSE3(places[0]))
        tracks = {".position": places[:, :3], ".quaternion": places[:, 3:]}
        if scales is not None:
            tracks[".scale"] = np.repeat(scales[:, None], 3, axis=1)
            self.set(node_path(path), "scale", tracks[".scale"][0].tolist())
        for name, values in tracks.items():
            if np.ptp(values, axis=0).max() > 0.0:
                kind = "quaternion" if name == ".quaternion" else "vector3"
                self._track(path, name, kind, times, _floats(values))

    def show_between(self, path: Sequence[str], start: float, end: float, duration: float) -> None:
        """Show a node from ``start`` until before ``end`` of the playback [s], and only then."""
        keys = {0.0: start <= 0.0}
        if 0.0 < start <= duration:
            keys[start] = True
        if 0.0 < end < duration:
            keys[end] = False
        if duration > 0.0:
            self.set(node_path(path), "visible", keys[0.0])
            if len(keys) > 1:
                self._track(path, ".visible", "bool", np.array(list(keys)), list(keys.values()))

    def animate(self, duration: float, *, loop: bool) -> None:
        """Load all tracks, if anything moves."""
        # One length for all, or clips that end earlier would start again by themselves.
        clips = [
            {
                "path": path,
                "clip": {"fps": 1, "name": "default", "duration": duration, "tracks": tracks},
            }
            for path, tracks in self._clips.items()
        ]
        # The player can be moved by hand only after it has started once.
        options = {"play": True, "repetitions": 1_000_000 if loop else 1}
        if clips:
            self.commands.append(
                {"type": "set_animation", "animations": clips, "options": options, "path": ""}
            )

    def _track(
        self, path: Sequence[str], name: str, kind: str, times: np.ndarray, values: Any
    ) -> None:
        track = {"name": name, "type": kind, "times": _floats(times), "values": values}
        self._clips.setdefault(node_path(path), []).append(track)


def _floats(values: np.ndarray) -> Any:
    # The player keeps single precision; as a typed array a number costs four bytes.
    return shapes.pack_numpy_array(np.ascontiguousarray(values, dtype=np.float32).ravel())["array"]


def _hex(color: Sequence[float]) -> int:
    red, green, blue = (round(255 * min(max(float(c), 0.0), 1.0)) for c in color[:3])
    return red << 16 | green << 8 | blue
