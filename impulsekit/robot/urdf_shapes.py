"""The <visual> and <collision> elements of a URDF, checked, with meshes in named folders only."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin

from ..errors import shown
from .robot_xml import Place
from .urdf import UrdfText

# What of each shape of a URDF is a size [m].
_SIZES = {
    "box": ("size",),
    "cylinder": ("radius", "length"),
    "sphere": ("radius",),
    "capsule": ("radius", "length"),
}


@dataclass(frozen=True)
class UrdfShape:
    """A <visual> or <collision> of a URDF.

    Attributes:
        link: that it is on.
        placement: in the link.
        kind: "box", "cylinder", "sphere", "capsule" or "mesh".
        sizes: of the shape, or the three scales of a mesh.
        path: of a mesh; "" for other kinds.
        rgba: its colour; None where it has none.
    """

    link: str
    placement: pin.SE3
    kind: str
    sizes: tuple[float, ...]
    path: str
    rgba: tuple[float, ...] | None


def urdf_shapes(urdf: UrdfText, tag: str, folders: Sequence[str]) -> Iterator[UrdfShape]:
    """Yield the shapes of a URDF with this ``tag``, checked.

    Args:
        urdf: the URDF.
        tag: "visual" or "collision".
        folders: where meshes may be, the URDF's own first.

    Raises:
        UrdfError: it names the link and the fault.
    """
    shared = {
        material.get("name", ""): color
        for material in urdf.root.findall("material")
        if (color := material.find("color")) is not None
    }
    for link in urdf.root.findall("link"):
        place = Place(urdf.path or "URDF text", f'link "{shown(link.get("name", ""))}"')
        for item in link.findall(tag):
            yield _shape(item, link.get("name", ""), place, folders, shared)


def _shape(
    item: Element, link: str, place: Place, folders: Sequence[str], shared: dict[str, Element]
) -> UrdfShape:
    place.name(item.get("name", ""))
    geometry = item.find("geometry")
    kind = None if geometry is None else next(iter(geometry), None)
    if kind is None:
        raise place.fault(f"its <{item.tag}> has no <geometry> with a shape in it")
    if kind.tag not in (*_SIZES, "mesh"):
        known = ", ".join(f"<{one}>" for one in (*_SIZES, "mesh"))
        raise place.fault(f"its <{item.tag}> is a <{shown(kind.tag)}>, expected one of {known}")
    placement = pin.SE3.Identity()
    if (given := item.find("origin")) is not None:
        xyz, rpy = (
            np.array(place.numbers(given.get(key, "0 0 0"), 3, f"<origin {key}>"))
            for key in ("xyz", "rpy")
        )
        placement = pin.SE3(pin.rpy.rpyToMatrix(rpy), xyz)
    path = ""
    if kind.tag == "mesh":
        sizes = place.numbers(kind.get("scale", "1 1 1"), 3, "<mesh scale>")
        if not all(sizes):
            raise place.fault("its <mesh scale> must not be zero")
        path = mesh_path(kind.get("filename") or "", folders, place)
    else:
        sizes = ()
        for key in _SIZES[kind.tag]:
            what = f"<{kind.tag} {key}>"
            own = place.numbers(kind.get(key), 3 if key == "size" else 1, f"{what} [m]")
            if min(own) < 0.0:
                raise place.fault(f"its {what} must be 0 m or more, got {min(own):g} m")
            sizes += own
    return UrdfShape(link, placement, kind.tag, sizes, path, _color(item, place, shared))


def _color(item: Element, place: Place, shared: dict[str, Element]) -> tuple[float, ...] | None:
    material = item.find("material")
    if material is None:
        return None
    color = material.find("color")
    if color is None:
        color = shared.get(material.get("name", ""))
    if color is None:
        return None
    rgba = place.numbers(color.get("rgba"), 4, "<color rgba>")
    return tuple(min(max(x, 0.0), 1.0) for x in rgba)


def mesh_path(filename: str, folders: Sequence[str], place: Place) -> str:
    """Return the file of a mesh, which lies below one of the folders.

    "package://name/rest" is looked for as "name/rest" in each folder, a relative path
    likewise; an absolute one has to lie in one of them.

    Raises:
        UrdfError: the file does not exist, or it lies outside, as does what a symbolic link out of
            the folders leads to.
    """
    if not filename:
        raise place.fault('its <mesh> has no filename="..."')
    rest = filename.removeprefix("package://").removeprefix("file://")
    if "\0" in filename or "://" in rest:
        raise place.fault(
            f'its mesh "{shown(filename)}" is no file; give a path, package:// or file://'
        )
    if filename.startswith("package://"):
        rest = rest.lstrip("/")
    outside, led = not folders and os.path.isabs(rest), ""
    real_folders = [os.path.realpath(folder) for folder in folders]
    for folder in folders:
        path = os.path.normpath(os.path.join(folder, rest))
        if not _lies_in(path, map(os.path.normpath, folders)):
            outside = True
        elif os.path.isfile(path):
            real = os.path.realpath(path)
            if _lies_in(real, real_folders):
                return path
            led = led or real
    tried, advice = ", ".join(folders) or "none", "name its folder in package_dirs"
    if led:
        advice = "name the folder it leads to in package_dirs"
        reason = f'is a link to "{shown(led, 200)}", outside the named folders ({tried})'
    elif outside:
        reason = f"lies outside the named folders ({tried})"
    else:
        reason = f"was not found (folders tried: {tried})"
    raise place.fault(f'its mesh "{shown(filename, 200)}" {reason}; {advice}', "mesh")


def _lies_in(path: str, folders: Iterable[str]) -> bool:
    return any(path.startswith(os.path.join(folder, "")) for folder in folders)
