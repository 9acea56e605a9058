"""Links of SDF, written as URDF."""

from __future__ import annotations

from typing import TYPE_CHECKING
from xml.sax.saxutils import quoteattr

import pinocchio as pin

from ..errors import shown
from .sdf_elements import SdfElements, origin_text

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

__all__ = ["link_text"]

_MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


def link_text(model: SdfElements, name: str) -> str:
    link, element = model.links[name], f'link "{shown(name)}"'
    parts = [f"<link name={quoteattr(name)}>", _inertial(model, link, element)]
    for tag in ("visual", "collision"):
        for item in link.findall(tag):
            parts.append(_shape(model, item, element))
    return "".join([*parts, "</link>"])


def _inertial(model: SdfElements, link: Element, element: str) -> str:
    inertial = link.find("inertial")
    if inertial is None:
        model.assumed.append(f"{element} has no <inertial>; SDF takes 1 kg and 1 kg m² then")
        mass, moments = 1.0, [1.0, 0.0, 0.0, 1.0, 0.0, 1.0]
        place = pin.SE3.Identity()
    else:
        if (inertial.get("auto") or "").strip() in ("1", "true"):
            raise model.error(
                element,
                'its <inertial auto="true"> is worked out from shapes and densities, which is not '
                "supported; give its <mass>, <pose> and <inertia>",
            )
        if inertial.find("fluid_added_mass") is not None:
            model.assumed.append(f"{element}: its <fluid_added_mass> is left out")
        mass = model.number_in(inertial, "mass", 1.0, element)
        table = inertial.find("inertia")
        defaults = [1.0, 0.0, 0.0, 1.0, 0.0, 1.0]
        moments = [
            value if table is None else model.number_in(table, key, value, element)
            for key, value in zip(_MOMENTS, defaults, strict=True)
        ]
        place = model.read_pose(inertial.find("pose"), element)
    written = " ".join(f'{key}="{v!r}"' for key, v in zip(_MOMENTS, moments, strict=True))
    return f'<inertial>{origin_text(place)}<mass value="{mass!r}"/><inertia {written}/></inertial>'


def _shape(model: SdfElements, item: Element, element: str) -> str:
    geometry = item.find("geometry")
    kind = None if geometry is None else next(iter(geometry), None)
    if kind is None or kind.tag not in ("box", "sphere", "cylinder", "mesh", "capsule"):
        what = "nothing" if kind is None else f"<{shown(kind.tag)}>"
        if kind is None or kind.tag != "empty":
            model.assumed.append(f"{element}: a <{item.tag}> of {what} is left out")
        return ""
    own = f" name={quoteattr(item.get('name', ''))}" if item.get("name") else ""
    place = origin_text(model.read_pose(item.find("pose"), element))
    if kind.tag == "mesh":
        uri = kind.find("uri")
        name = "" if uri is None else (uri.text or "").strip()
        scale = kind.find("scale")
        factors = "1 1 1" if scale is None else scale.text
        filename = name.replace("model://", "package://")
        shape = f"<mesh filename={quoteattr(filename)} scale={quoteattr(factors or '')}/>"
    elif kind.tag == "box":
        size = " ".join(map(repr, _sizes(model, kind, "size", 3, element)))
        shape = f'<box size="{size}"/>'
    else:
        (radius,) = _sizes(model, kind, "radius", 1, element)
        length = ""
        if kind.tag != "sphere":
            length = f' length="{_sizes(model, kind, "length", 1, element)[0]!r}"'
        shape = f'<{kind.tag} radius="{radius!r}"{length}/>'
        if kind.tag == "capsule":
            model.assumed.append(f"{element}: a capsule in <{item.tag}> is left out")
            return ""
    return f"<{item.tag}{own}>{place}<geometry>{shape}</geometry></{item.tag}>"


def _sizes(model: SdfElements, kind: Element, tag: str, count: int, element: str) -> list[float]:
    child = kind.find(tag)
    return model.numbers(None if child is None else child.text, count, element, f"<{tag}>")
