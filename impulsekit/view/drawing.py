"""``Drawing``: what a page shows, as the commands that meshcat's player understands."""

from __future__ import annotations

import pathlib
import warnings
from collections.abc import Sequence
from types import ModuleType
from typing import Any

import numpy as np
import pinocchio as pin

from ..errors import MissingExtraError
from .surfaces import Surface, mesh, typed


def meshcat() -> ModuleType:
    """The package meshcat; no server is started and no port is opened.

    Raises:
        MissingExtraError: it is not installed.
    """
    with warnings.catch_warnings():
        # meshcat 0.3.2 still imports an event loop that pyzmq has given up.
        warnings.filterwarnings("ignore", message=r"zmq\.eventloop\.ioloop", append=False)
        warnings.filterwarnings("ignore", category=SyntaxWarning, module=r"meshcat\.")
        try:
            import meshcat
        except ImportError as error:
            raise MissingExtraError(
                f"a replay needs meshcat: pip install meshcat ({error})",
                package="meshcat",
                extra="",
            ) from None
    return meshcat


def packed(command: dict) -> bytes:
    """A command as meshcat's player reads it."""
    import umsgpack

    return umsgpack.packb(command)


def player_script() -> str:
    """The JavaScript of meshcat's own player, from the installed package.

    Raises:
        MissingExtraError: the package came without it.
    """
    path = pathlib.Path(str(meshcat().__file__)).parent / "viewer" / "dist" / "main.min.js"
    try:
        return path.read_text(encoding="utf-8")
    except OSError:
        raise MissingExtraError(
            f"meshcat came without its player, {path}: pip install --force-reinstall meshcat",
            package="meshcat",
            extra="",
        ) from None


ROOT = "impulsekit"


def node_name(index: int, name: str) -> str:
    """A node's name: never the same twice, never a path, never a word JavaScript knows.

    Example:
        >>> node_name(3, "arm/elbow")
        '3 arm:elbow'
    """
    return f"{index} {name.replace('/', ':')}"


class Drawing:
    """Objects, their places and their tracks over playback time.

    Paths are tuples of node names below ``ROOT``.

    Attributes:
        commands: in the order in which the player gets them.
    """

    def __init__(self) -> None:
        self.commands: list[dict[str, Any]] = []
        self._clips: dict[str, list[dict[str, Any]]] = {}

    def add(
        self,
        path: Sequence[str],
        surface: Surface,
        color: Sequence[float],
        placements: Sequence[pin.SE3] = (),
        *,
        glow: float = 0.0,
        shade: float = 0.0,
        one_sided: bool = False,
    ) -> None:
        """Draw a surface once, or once at each of several ``placements``.

        Args:
            path: the node; its own transform comes on top.
            surface: what is drawn.
            color: red, green, blue and opacity in [0, 1].
            placements: copies share one geometry.
            glow: how much of its colour shines without light, for arrows.
            shade: opacity of what is seen of it through everything that stands before it.
            one_sided: whether it is not seen from behind, as nothing translucent is.
        """
        opacity = float(color[3]) if len(color) > 3 else 1.0
        base = {
            "type": "MeshPhongMaterial",
            "color": _hex(color),
            "vertexColors": surface.colored,
            # The player works out normals of a mesh for a single one only.
            "flatShading": surface.flat,
            "shininess": 20,
            "specular": 0x222222,
            "emissive": _hex([glow * c for c in color[:3]]),
        }
        materials = [
            base
            | {
                "opacity": opacity,
                "transparent": opacity < 1.0,
                "side": 2 if opacity == 1.0 and not one_sided else 0,
                "depthWrite": opacity == 1.0,
            }
        ]
        if shade > 0.0:
            see = {"opacity": shade, "transparent": True, "depthTest": False, "depthWrite": False}
            materials.append(base | see)
        for i, material in enumerate(materials):
            material["uuid"] = f"material {i}"
        turns = [placement.homogeneous @ surface.turn for placement in placements]
        meshes = [
            {
                "uuid": f"mesh {i} {j}",
                "type": "Mesh",
                "geometry": "geometry",
                "material": material["uuid"],
                "matrix": turn.T.ravel().tolist(),
            }
            for i, turn in enumerate(turns or [surface.turn])
            for j, material in enumerate(materials)
        ]
        group = {"uuid": "group", "type": "Group", "children": meshes}
        self.add_object(
            self._path(path),
            meshes[0] if len(meshes) == 1 else group,
            [surface.geometry | {"uuid": "geometry"}],
            materials,
        )

    def add_lines(self, path: Sequence[str], points: np.ndarray, color: Sequence[float]) -> None:
        """Draw (n, 3) points two by two as thin lines [m]."""
        faces = np.zeros((0, 3))
        surface = mesh(points, faces)
        del surface.geometry["data"]["index"]
        self.add_object(
            self._path(path),
            {"uuid": "lines", "type": "LineSegments", "geometry": "points", "material": "line"},
            [surface.geometry | {"uuid": "points"}],
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
        self.commands.append({"type": "set_transform", "path": self._path(path), "matrix": matrix})

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

        It is drawn ``scales`` (F,) as large. What never changes gets no track.
        """
        self.place(path, pin.XYZQUATToSE3(places[0]))
        if len(times) < 2:
            return
        tracks = {".position": places[:, :3], ".quaternion": places[:, 3:]}
        if scales is not None:
            tracks[".scale"] = np.repeat(scales[:, None], 3, axis=1)
        for name, values in tracks.items():
            kind = "quaternion" if name == ".quaternion" else "vector3"
            if np.ptp(values, axis=0).max() > 0.0:
                self._tracks(path).append(_track(name, kind, times, values))
            elif name == ".scale":
                self.set(self._path(path), "scale", values[0].tolist())

    def show_between(self, path: Sequence[str], start: float, end: float, duration: float) -> None:
        """Show a node from ``start`` until before ``end`` of the playback [s], and only then."""
        if duration == 0.0:
            return
        keys = [(0.0, start <= 0.0)]
        if start > 0.0:
            keys.append((start, True))
        if end < duration:
            keys.append((end, False))
        times, shown = zip(*keys, strict=True)
        self.set(self._path(path), "visible", bool(shown[0]))
        if len(keys) > 1:
            self._tracks(path).append(
                {
                    "name": ".visible",
                    "type": "bool",
                    "times": _floats(np.array(times)),
                    "values": list(shown),
                }
            )

    def animation(self, duration: float, *, loop: bool) -> dict[str, Any] | None:
        """The command that loads all tracks; None where nothing moves."""
        if not self._clips:
            return None
        # One length for all, or clips that end earlier would start again by themselves.
        clips = [
            {
                "path": path,
                "clip": {"fps": 1, "name": "default", "duration": duration, "tracks": tracks},
            }
            for path, tracks in self._clips.items()
        ]
        return {
            "type": "set_animation",
            "animations": clips,
            # The player can be moved by hand only after it has started once.
            "options": {"play": True, "repetitions": 1_000_000 if loop else 1},
            "path": "",
        }

    def _tracks(self, path: Sequence[str]) -> list[dict[str, Any]]:
        return self._clips.setdefault(self._path(path), [])

    def _path(self, path: Sequence[str]) -> str:
        return "/" + "/".join((ROOT, *path))


def _track(name: str, kind: str, times: np.ndarray, values: np.ndarray) -> dict[str, Any]:
    # The player keeps single precision; as typed arrays a key costs four bytes a number.
    return {"name": name, "type": kind, "times": _floats(times), "values": _floats(values)}


def _floats(values: np.ndarray) -> Any:
    return typed(np.asarray(values, dtype=np.float32))


def _hex(color: Sequence[float]) -> int:
    red, green, blue = (round(255 * min(max(float(c), 0.0), 1.0)) for c in color[:3])
    return red << 16 | green << 8 | blue
