"""URDFs that are nearly right, and wrong in ways that hurt readers."""

from __future__ import annotations

from collections.abc import Callable
from random import Random

__all__ = ["NAMES", "NUMBERS", "random_urdf"]

NUMBERS = (
    "0", "1", "-1", "0.5", "1e-3", "-0.0", "1e999", "-1e999", "nan", "inf", "-inf", "1e308",
    "-1e308", "1e154", "1e100", "1e-310", "4.9e-324", "1e-200", "", " ", "1,5", "1_000", "0x10",
    "١", "1 2", "1e", "--1", "+1", "${pi}", "one", "9" * 400, "1\t", "\n1", "&#49;",
)  # fmt: skip
NAMES = (
    "world", "universe", "root_joint", "base", "", " ", "a/b", "../x", "<b>", "&lt;script&gt;",
    "]]&gt;", "[red]x[/red]", "$x$", "\\frac", "%s%n", "名前", "\u202egnp", "é", "e\u0301", "a b",
    "&#10;", "&#9;", "\x9b31m", "&#27;[31m", "&amp;", "&quot;", "'", "None", "0", "-", "a" * 5000,
    "&xxe;", "\ud7ff", "{}", "{0.__class__}", "package://x",
)  # fmt: skip
_TYPES = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")
_ODD_TYPES = (*_TYPES, "hinge", "", "Revolute", "spherical", "nan")
_MESHES = (
    "a.stl", "../../canary.txt", "/etc/passwd", "file:///etc/passwd", "package://p/a.stl",
    "package://../canary.txt", "http://127.0.0.1:9/a.stl", "", "\\\\host\\a.stl", "/dev/zero",
    "canary.txt", ".", "//etc/passwd", "package://", "~/a.stl", "a.stl\0.png", "%2e%2e/canary.txt",
)  # fmt: skip
_HEADS = (
    "", "<?xml version='1.0'?>", "<?xml version='1.0' encoding='utf-16'?>", "\ufeff", "\n\n",
    "<?xml version='1.0' encoding='latin-1'?>", "<!-- x -->", "<?pi x?>", "<?xml version='9'?>",
    "<!DOCTYPE robot [<!ENTITY xxe SYSTEM 'file:canary.txt'>]>",
    "<!DOCTYPE robot SYSTEM 'http://127.0.0.1:9/x.dtd'>",
    "<!DOCTYPE l [<!ENTITY a 'aaaaaaaaaa'><!ENTITY b '&a;&a;&a;&a;&a;&a;&a;&a;'>]>",
    "<?xml-stylesheet href='file:canary.txt'?>",
)  # fmt: skip
_STRANGERS = (
    "<xi:include xmlns:xi='http://www.w3.org/2001/XInclude' href='canary.txt' parse='text'/>",
    "<gazebo><plugin filename='x.so'/></gazebo>", "<transmission name='t'/>", "text", "<link/>",
    "<joint/>", "<![CDATA[<link name='z'/>]]>", "<!-- <link name='z'/> -->", "&xxe;", "&#0;",
    "<material name='m'><color rgba='1 0 0'/></material>", "<robot name='r2'/>", "<", "</robot>",
    "<xacro:macro/>", "<material name='m'><texture filename='../canary.txt'/></material>",
)  # fmt: skip


def random_urdf(rng: Random) -> str:
    """A URDF; at some rate each part of it is odd."""
    # Some files are hardly odd at all, so that what is deep inside is reached too.
    rate = rng.choice((0.0, 0.003, 0.01, 0.03, 0.1, 0.3))

    def odd() -> bool:
        return rate > 0.0 and rng.random() < rate

    shape = rng.random()
    count = rng.randint(1, 8) if shape < 0.97 else rng.choice((60, 150, 1200, 4000))
    chain = count > 8
    names = [f"l{i}" if not odd() else rng.choice(NAMES) for i in range(count)]
    links = [_link(rng, name, odd, bare=chain) for name in names]
    joints = [
        _joint(rng, i, names[i - 1 if chain or rng.random() < 0.5 else rng.randrange(i)], name, odd)
        for i, name in enumerate(names)
        if i > 0
    ]
    body = links + joints
    _disturb(rng, body, odd)
    head = rng.choice(_HEADS) if odd() else ""
    tag = rng.choice(("model", "Robot", "robot xmlns='urn:x'", "sdf")) if odd() else "robot"
    name = rng.choice(NAMES) if odd() else "r"
    return f'{head}<{tag} name="{name}">{"".join(body)}</{tag.split()[0]}>'


def _disturb(rng: Random, body: list[str], odd: Callable[[], bool]) -> None:
    """Whole elements too many, too few, in another order, or where they do not belong."""
    if odd():
        body.insert(rng.randrange(len(body) + 1), rng.choice(_STRANGERS))
    if odd():
        body.append(rng.choice(body))
    if odd():
        body.pop(rng.randrange(len(body)))
    if odd():
        rng.shuffle(body)
    if odd():
        deep = rng.choice((5, 150, 300, 100_000))
        body.append("<x>" * deep + "</x>" * deep)
    if odd():
        body[:] = [part.replace(f'"l{rng.randrange(8)}"', '"l0"') for part in body]


def _number(rng: Random, odd: Callable[[], bool], usual: str = "1") -> str:
    if odd():
        return rng.choice(NUMBERS)
    return usual if rng.random() < 0.5 else f"{rng.uniform(0.1, 2):.3g}"


def _triple(rng: Random, odd: Callable[[], bool], usual: str) -> str:
    if odd():
        return " ".join(rng.choice(NUMBERS) for _ in range(rng.choice((0, 1, 2, 3, 3, 3, 4))))
    return usual if rng.random() < 0.5 else " ".join(f"{rng.uniform(-1, 1):.3g}" for _ in range(3))


def _origin(rng: Random, odd: Callable[[], bool]) -> str:
    return f'<origin xyz="{_triple(rng, odd, "0 0 1")}" rpy="{_triple(rng, odd, "0 0 0")}"/>'


def _link(rng: Random, name: str, odd: Callable[[], bool], *, bare: bool) -> str:
    moments = "".join(
        f' {key}="{_number(rng, odd, "1" if key[1] == key[2] else "0") if not odd() else "-1"}"'
        if key[1] == key[2]
        else f' {key}="{rng.choice(NUMBERS) if odd() else 0}"'
        for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
        if not odd()
    )
    parts = [_origin(rng, odd), f'<mass value="{_number(rng, odd)}"/>', f"<inertia{moments}/>"]
    inertial = "" if odd() else f"<inertial>{''.join(p for p in parts if not odd())}</inertial>"
    if odd():
        inertial *= 2
    shapes = "" if bare else _shape(rng, odd)
    return f'<link name="{name}">{inertial}{shapes}</link>'


def _shape(rng: Random, odd: Callable[[], bool]) -> str:
    if rng.random() < 0.6:
        return ""
    tag = rng.choice(("visual", "collision"))
    kind = (
        rng.choice(("box", "sphere", "cylinder"))
        if not odd()
        else rng.choice(("mesh", "cone", "mesh"))
    )
    inner = {
        "box": f'<box size="{_triple(rng, odd, "1 1 1").replace("-", "")}"/>',
        "sphere": f'<sphere radius="{_number(rng, odd)}"/>',
        "cylinder": f'<cylinder radius="{_number(rng, odd)}" length="{_number(rng, odd)}"/>',
        "mesh": f'<mesh filename="{rng.choice(_MESHES)}" scale="{_triple(rng, odd, "1 1 1")}"/>',
        "cone": "<cone/>",
    }[kind]
    color = '<material name="m"><color rgba="1 0 0 1"/></material>' if rng.random() < 0.3 else ""
    if odd():
        rgba = f'<color rgba="{rng.choice(NUMBERS)} 0 0 1"/>'
        color = f'<material name="{rng.choice(NAMES)}">{rgba}</material>'
    return f"<{tag}>{_origin(rng, odd)}<geometry>{inner}</geometry>{color}</{tag}>"


def _joint(rng: Random, i: int, parent: str, child: str, odd: Callable[[], bool]) -> str:
    name = f"j{i}" if not odd() else rng.choice(NAMES)
    kind = rng.choice(_TYPES) if not odd() else rng.choice(_ODD_TYPES)
    parent, child = (rng.choice(NAMES) if odd() else end for end in (parent, child))
    lower, upper = _number(rng, odd, "-1"), _number(rng, odd, "2")
    if not odd() and not lower.startswith("-"):
        lower = f"-{lower}"
    parts = [
        f'<parent link="{parent}"/>',
        f'<child link="{child}"/>',
        _origin(rng, odd),
        f'<axis xyz="{_triple(rng, odd, rng.choice(("1 0 0", "0 1 0", "0 0 1")))}"/>',
        f'<limit lower="{lower}" upper="{upper}" effort="{_number(rng, odd)}" '
        f'velocity="{_number(rng, odd)}"/>',
    ]
    if rng.random() < 0.1:
        leader = f"j{rng.randrange(8)}" if not odd() else rng.choice(NAMES)
        multiplier = _number(rng, odd)
        parts.append(f'<mimic joint="{leader}" multiplier="{multiplier}"/>')
    if rng.random() < 0.1:
        parts.append(f'<dynamics damping="{_number(rng, odd)}" friction="{_number(rng, odd)}"/>')
    inside = "".join(part for part in parts if not odd())
    return f'<joint name="{name}" type="{kind}">{inside}</joint>'
