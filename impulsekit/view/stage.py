"""The stage around the robot: light, ground, grid, and a camera that fits."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin

from ..errors import InputError, RangeError, quoted
from .drawing import Drawing, node_name, shapes
from .motions import Plane, triad

# [m] The extent of a flat scene, to divide by.
LEAST_EXTENT = 1e-9
# [m] The distance of the camera, and the size of the scene, where all is at one point.
LEAST_DISTANCE = 1e-6
# Of the shadows' depth: less draws stripes, more lets shadows come off their bodies.
BIAS = -0.0008
# [of the scene's radius] Lines above the floor, so that neither hides the other.
LIFTED = 6e-4
# A plane is drawn this far below its place, of the robot's radius.
SUNK = 2e-3

FIELD_OF_VIEW = 35.0  # degrees
SKY = (0.90, 0.93, 0.96)
HORIZON = (0.97, 0.98, 0.99)
GROUND = (0.80, 0.82, 0.84, 1.0)
WALL = (0.80, 0.85, 0.90, 0.45)
# A body deeper under a plane than this share of the picture is not to be hidden by it.
DEEP = 0.1
# From below the ground hides nothing.
GROUND_FROM_BELOW = (0.80, 0.82, 0.84, 0.25)
# Name, direction from which it shines, intensity; the first one casts shadows.
SUNS = {
    "impulsekit key": ((0.45, -0.6, 1.3), 0.5),
    "impulsekit fill": ((-0.8, -0.4, 0.35), 0.14),
}
LINES = (0.66, 0.69, 0.72)
# A square about the origin with edges of 2.
SQUARE = np.array([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]])
FACES = np.array([[0, 1, 2], [0, 2, 3]])
# A scene whose thinnest extent is below this share of the next is flat: it is seen from its front.
FLAT = 0.35
# Lines of the grid are at most this share of the radius apart.
GRID_SHARE = 0.4


@dataclass(frozen=True, eq=False)
class Camera:
    """The camera's position, its target and its upward direction: (3,) in the world [m]."""

    position: np.ndarray
    target: np.ndarray
    up: np.ndarray

    def in_player(self) -> dict[str, list[float]]:
        """Return the three in the player's axes, in which y is up."""
        found = {"position": self.position, "target": self.target, "up": self.up}
        return {name: [float(x), float(z), -float(y)] for name, (x, y, z) in found.items()}


# The direction of the camera by name, along the world's axes.
VIEWS = {
    "front": (1.0, 0.0, 0.12),
    "back": (-1.0, 0.0, 0.12),
    "left": (0.0, 1.0, 0.12),
    "right": (0.0, -1.0, 0.12),
    "top": (0.0, -1e-3, 1.0),
}


def camera_of(
    view: Any,
    points: np.ndarray,
    subject: np.ndarray,
    planes: Sequence[Plane] = (),
    is_planar: bool = False,
) -> Camera:
    """Return the camera of ``replay``: by name, by place, or for None one that fits.

    Raises:
        InputError: no name of a view, no position, and no pair of positions.
        RangeError: the camera is at its own target.
    """
    if view is None:
        return fitting_camera(points, subject, planes, is_planar=is_planar)
    if isinstance(view, str):
        if view not in VIEWS:
            raise RangeError.of("replay: camera", quoted(view), ", ".join(map(quoted, VIEWS)))
        return fitting_camera(points, subject, planes, np.array(VIEWS[view]), is_planar)
    pair = np.asarray(view, dtype=float) if np.shape(view) in ((3,), (2, 3)) else None
    if pair is None or not np.isfinite(pair).all():
        raise InputError(
            "replay: camera must be a position (x, y, z) [m], a pair of position and target, or "
            f"one of {', '.join(map(quoted, VIEWS))}; got {view!r}"
        )
    low, high = subject.min(axis=0), subject.max(axis=0)
    place, target = pair if pair.ndim == 2 else (pair, 0.5 * (low + high))
    if np.linalg.norm(place - target) < LEAST_DISTANCE:
        raise RangeError.of("replay: camera", list(place), "a position apart from its target")
    up = np.array([0.0, 0.0, 1.0])
    return Camera(place, target, up)


def fitting_camera(
    points: np.ndarray,
    subject: np.ndarray,
    planes: Sequence[Plane] = (),
    direction: np.ndarray | None = None,
    is_planar: bool = False,
) -> Camera:
    """Return a camera that sees all (n, 3) points, with the (m, 3) ``subject`` in the middle.

    It takes a picture of any shape from square to twice as wide as high, sees flat scenes from
    their broad side, and is in front of the ``planes``; a ``direction`` is kept as it is.
    """
    up = np.array([0.0, 0.0, 1.0])
    if is_planar and planes and not any(plane.normal[2] > 0.5 for plane in planes):
        # The floor of a planar robot is in its own plane; beside others such a plane is a wall.
        up = planes[0].normal
    if direction is None:
        direction = _fitting_direction(points, planes, up)
    direction = direction / np.linalg.norm(direction)
    right = np.cross(up, direction)
    right /= np.linalg.norm(right)
    across = np.cross(direction, right)
    target = 0.5 * (subject.min(axis=0) + subject.max(axis=0))
    corners = points - target
    # A little space is left around everything.
    tangent = math.tan(math.radians(0.5 * FIELD_OF_VIEW)) / 1.15
    needed = np.maximum(np.abs(corners @ right) / 1.15, np.abs(corners @ across)) / tangent
    distance = float((corners @ direction + needed).max())
    return Camera(target + max(distance, LEAST_DISTANCE) * direction, target, up)


def _fitting_direction(points: np.ndarray, planes: Sequence[Plane], up: np.ndarray) -> np.ndarray:
    """Return the direction from which a scene is seen best."""
    axes = triad(up)
    low, high = (points @ axes).min(axis=0), (points @ axes).max(axis=0)
    extents = np.maximum(high - low, LEAST_EXTENT)
    thin = int(np.argmin(extents))
    flat = extents[thin] < FLAT * np.sort(extents)[1]
    if flat and thin == 2:
        local = np.array([0.0, -0.62, 1.0])
    elif flat:
        local = np.array([0.28, 0.28, 0.22])
        local[thin] = 1.0 if thin == 0 else -1.0
    else:
        local = np.array([0.9, -0.75, 0.42])
    direction = axes @ (local / np.linalg.norm(local))
    for plane in planes:
        facing = float(direction @ plane.normal)
        if facing < 0.0:
            direction = direction - 2.0 * facing * plane.normal
    return direction


def draw_stage(
    drawing: Drawing,
    points: np.ndarray,
    planes: Sequence[Plane],
    camera: Camera,
    bodies: np.ndarray | None = None,
) -> None:
    """Draw light, ground, grid and background around the (n, 3) points.

    Args:
        drawing: takes the commands.
        points: the corners of all bodies and arrows [m].
        planes: those that contacts name; the ground is laid under everything if none is level.
        camera: its view.
        bodies: (n, 3) the corners of the bodies; ground above some of them is translucent.
    """
    low, high = points.min(axis=0), points.max(axis=0)
    middle = 0.5 * (low + high)
    radius = max(0.5 * float(np.linalg.norm(high - low)), LEAST_DISTANCE)
    _background(drawing, camera, radius)
    _lights(drawing, middle, radius, camera.up)
    if not planes:
        # Under everything; a scene above the world's origin has that as its floor.
        foot = np.array([middle[0], middle[1], min(low[2], 0.0)])
        planes = [Plane(foot, np.array([0.0, 0.0, 1.0]))]
    size = 6.0 * radius
    for i, plane in enumerate(planes):
        solid = i == 0 or float(plane.normal @ camera.up) > 0.5
        if bodies is not None and len(bodies):
            depth = float(((plane.origin - bodies) @ plane.normal).max())
            solid = solid and depth < DEEP * radius
        # Just under the plane itself, or bodies on it would flicker.
        placement = plane.placement(middle) * pin.SE3(
            np.eye(3), np.array([0.0, 0.0, -SUNK * radius])
        )
        path = ("stage", node_name(i, "plane"))
        color, half = GROUND if solid else WALL, 0.5 * size
        drawing.add(
            (*path, "surface"),
            shapes.TriangularMeshGeometry(half * SQUARE, FACES),
            color,
            one_sided=solid,
        )
        if solid:
            below = shapes.TriangularMeshGeometry(half * SQUARE, FACES[:, ::-1])
            drawing.add((*path, "from below"), below, GROUND_FROM_BELOW)
        drawing.add_lines((*path, "grid"), _grid(size, radius, placement), LINES)
        drawing.place(path, placement)


def _background(drawing: Drawing, camera: Camera, radius: float) -> None:
    drawing.set("/Background", "top_color", list(SKY))
    drawing.set("/Background", "bottom_color", list(HORIZON))
    drawing.set("/Grid", "visible", False)
    drawing.set("/Axes", "visible", False)
    eye = "/Cameras/default/rotated/<object>"
    distance = float(np.linalg.norm(camera.position - camera.target))
    drawing.set(eye, "fov", FIELD_OF_VIEW)
    drawing.set(eye, "near", 0.02 * distance)
    drawing.set(eye, "far", 20.0 * (distance + radius))
    drawing.set(eye, "position", camera.in_player()["position"])


def _lights(drawing: Drawing, middle: np.ndarray, radius: float, up: np.ndarray) -> None:
    for name in ("SpotLight", "PointLightNegativeX", "PointLightPositiveX", "FillLight"):
        drawing.set(f"/Lights/{name}", "visible", False)
    drawing.set("/Lights/AmbientLight/<object>", "intensity", 0.5)
    for i, (name, (direction, intensity)) in enumerate(SUNS.items()):
        unit = np.array(direction) / np.linalg.norm(direction)
        place = middle + 4.0 * radius * (triad(up) @ unit)
        half = 2.2 * radius
        light = {
            "uuid": f"{name} light",
            "type": "DirectionalLight",
            "color": 0xFFFFFF,
            "intensity": intensity,
            "matrix": pin.SE3(np.eye(3), place).homogeneous.T.ravel().tolist(),
            "shadow": {
                "bias": BIAS,
                "radius": 3.0,
                "mapSize": [2048, 2048] if i == 0 else [1, 1],
                "camera": {
                    "uuid": f"{name} shadow",
                    "type": "OrthographicCamera",
                    "left": -half,
                    "right": half,
                    "top": half,
                    "bottom": -half,
                    "near": 0.1 * radius,
                    "far": 12.0 * radius,
                    "zoom": 1,
                },
            },
        }
        path = f"/Lights/{name}"
        drawing.add_object(path, light)
        if i > 0:
            # The player lets every object cast shadows; one sun is enough.
            drawing.set(f"{path}/<object>", "castShadow", False)


def grid_step(radius: float) -> float:
    """Return the width of a cell of the grid: 1, 2 or 5 times a power of ten [m].

    Example:
        >>> grid_step(1.0)
        0.2
    """
    power = 10.0 ** math.floor(math.log10(GRID_SHARE * radius))
    return float(next(f for f in (5, 2, 1) if f * power <= GRID_SHARE * radius) * power)


def _grid(size: float, radius: float, placement: pin.SE3) -> np.ndarray:
    """Return (n, 3): the ends of the lines, which go through round numbers of the world."""
    step, half = grid_step(radius), 0.5 * size
    ends = []
    for axis in (0, 1):
        offset = float(placement.rotation[:, axis] @ placement.translation)
        values = np.arange(math.ceil((offset - half) / step) * step - offset, half, step)
        line = np.full((len(values), 2, 3), LIFTED * radius)
        line[:, :, axis], line[:, :, 1 - axis] = values[:, None], (-half, half)
        ends.append(line.reshape(-1, 3))
    return np.concatenate(ends)
