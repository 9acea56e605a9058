"""The <visual> and <collision> elements of a URDF, checked, with meshes in named folders only."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING
from xml.sax.saxutils import quoteattr

from ..errors import UrdfError, shown
from .urdf_numbers import checked_name, fault, number, numbers

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

    from .urdf import UrdfText

_KINDS = ("box", "cylinder", "sphere", "mesh")
_SIZES = {"sphere": ("radius",), "cylinder": ("radius", "length")}


def checked_shapes(urdf: UrdfText, tag: str, folders: Sequence[str]) -> dict[str, list[str]]:
    """By link, the XML of its elements with this ``tag``, written anew.

    Args:
        urdf: the URDF.
        tag: "visual" or "collision".
        folders: where meshes may be, the URDF's own first.

    Raises:
        UrdfError: it names the link and the fault.
    """
    source = urdf.path or "URDF text"
    materials = {
        material.get("name", ""): material
        for material in urdf.root.findall("material")
        if material.find("color") is not None
    }
    shapes: dict[str, list[str]] = {}
    for link in urdf.root.findall("link"):
        name = link.get("name", "")
        for item in link.findall(tag):
            element = f'link "{shown(name)}"'
            shape = _shape(item, element, source, folders, materials)
            shapes.setdefault(name, []).append(shape)
    return shapes


def _shape(
    item: Element,
    element: str,
    source: str,
    folders: Sequence[str],
    materials: dict[str, Element],
) -> str:
    tag, name = item.tag, item.get("name")
    own_name = "" if not name else f" name={quoteattr(checked_name(name, source, element))}"
    geometry = item.find("geometry")
    kind = None if geometry is None else next(iter(geometry), None)
    if kind is None:
        raise fault(source, element, f"its <{tag}> has no <geometry> with a shape in it")
    if kind.tag not in _KINDS:
        known = ", ".join(f"<{one}>" for one in _KINDS)
        raise fault(
            source, element, f"its <{tag}> is a <{shown(kind.tag)}>, expected one of {known}"
        )
    origin = ""
    if (given := item.find("origin")) is not None:
        xyz, rpy = (
            " ".join(
                map(repr, numbers(given.get(key, "0 0 0"), 3, source, element, f"<origin {key}>"))
            )
            for key in ("xyz", "rpy")
        )
        origin = f'<origin xyz="{xyz}" rpy="{rpy}"/>'
    shape = _geometry(kind, element, source, folders)
    color = _material(item, element, source, materials)
    return f"<{tag}{own_name}>{origin}<geometry>{shape}</geometry>{color}</{tag}>"


def _geometry(kind: Element, element: str, source: str, folders: Sequence[str]) -> str:
    if kind.tag == "mesh":
        scale = numbers(kind.get("scale", "1 1 1"), 3, source, element, "<mesh scale>")
        if not all(scale):
            raise fault(source, element, "its <mesh scale> must not be zero")
        path = mesh_path(kind.get("filename") or "", folders, source, element)
        return f'<mesh filename={quoteattr(path)} scale="{" ".join(map(repr, scale))}"/>'
    if kind.tag == "box":
        sizes = {"size": numbers(kind.get("size"), 3, source, element, "<box size> [m]")}
    else:
        sizes = {
            key: (number(kind.get(key), source, element, f"<{kind.tag} {key}> [m]"),)
            for key in _SIZES[kind.tag]
        }
    for key, size in sizes.items():
        if min(size) < 0.0:
            raise fault(
                source, element, f"its <{kind.tag} {key}> must be 0 m or more, got {min(size):g} m"
            )
    written = " ".join(f'{key}="{" ".join(map(repr, size))}"' for key, size in sizes.items())
    return f"<{kind.tag} {written}/>"


def _material(item: Element, element: str, source: str, materials: dict[str, Element]) -> str:
    material = item.find("material")
    if material is None:
        return ""
    given = material.find("color")
    if given is None:
        shared = materials.get(material.get("name", ""))
        given = None if shared is None else shared.find("color")
    if given is None:
        return ""
    rgba = numbers(given.get("rgba"), 4, source, element, "<color rgba>")
    # The name only ties a material to its colour, and that stands here.
    color = " ".join(repr(min(max(x, 0.0), 1.0)) for x in rgba)
    return f'<material name="{color}"><color rgba="{color}"/></material>'


def mesh_path(filename: str, folders: Sequence[str], source: str, element: str) -> str:
    """The file of a mesh, which lies below one of the folders.

    "package://name/rest" is looked for as "name/rest" in each folder, a relative path
    likewise; an absolute one has to lie in one of them.

    Raises:
        UrdfError: there is no such file, or it lies outside, as does what a symbolic link out of
            the folders leads to.
    """
    if not filename:
        raise fault(source, element, 'its <mesh> has no filename="..."')
    if "\0" in filename or "://" in filename.removeprefix("package://").removeprefix("file://"):
        raise fault(
            source,
            element,
            f'its mesh "{shown(filename)}" is no file; give a path, package:// or file://',
        )
    rest = filename.removeprefix("package://").removeprefix("file://")
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
    tried = ", ".join(folders) or "none"
    if led:
        reason = (
            f'is a link to "{shown(led, 200)}", outside the named folders ({tried}); '
            "name the folder it leads to in package_dirs"
        )
    elif outside:
        reason = f"lies outside the named folders ({tried}); name its folder in package_dirs"
    else:
        reason = f"was not found (folders tried: {tried}); name its folder in package_dirs"
    raise UrdfError(
        f'{source}: {element}: its mesh "{shown(filename, 200)}" {reason}',
        source=source,
        element="mesh",
    )


def _lies_in(path: str, folders: Iterable[str]) -> bool:
    return any(path.startswith(os.path.join(folder, "")) for folder in folders)
