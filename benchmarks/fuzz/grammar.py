"""Broken files: URDFs and scene files that are nearly right, and files with bytes changed."""

from __future__ import annotations

import json
from collections.abc import Callable
from random import Random
from typing import Any

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


_ODD: tuple[Any, ...] = (
    0, 1, -1, 0.5, 1e308, -1e308, 1e100, 1e101, 4.9e-324, 10**30, -(10**400), True, False, "", " ",
    "x", "world", "link_1", "joint_2", "kept", "local", [], [1], [1, 2, 3], [1, 2, 3, 4], [[1]],
    ["x"], {}, {"x": 1}, {"value": 0.5}, "\x1b[31m", "<script>alert(1)</script>", "[red]",
    "a" * 3000, "名", "../../canary.txt", "/etc/passwd", "nan", [float("nan")] * 3, float("inf"),
    [1e200, 1e200, 1e200], [1e-320, 0, 0], "/dev/zero", "{0}", "%s", "$\\frac$", "\0", "\u202e",
)  # fmt: skip
_ENTRIES: dict[str, tuple[dict[str, Any], ...]] = {
    "impulses": (
        {"frame": "link_1", "linear": [0, 0, 1], "at": [0.1, 0, 0], "axes": "local"},
        {"frame": "link_3", "angular": [0, 0, 1]},
        {"joint": "joint_2", "impulse": 0.3},
        {"joint": "root_joint", "impulse": [1, 0, 0]},
    ),
    "constraints": (
        {"kind": "point_anchor", "frame": "link_3", "at": [1, 0, 0]},
        {"kind": "point_anchor", "frame": "link_1", "other": "link_3", "velocity": "kept"},
        {"kind": "frame_anchor", "frame": "link_2", "directions": ["x", "rz"], "axes": "local"},
        {"kind": "joint_lock", "joint": "joint_3", "velocity": 0.5},
        {"kind": "joint_coupling", "joint": "joint_2", "other": "joint_3", "ratio": -1},
    ),
    "contacts": (
        {"kind": "contact", "frame": "link_3", "normal": [0, 1, 0], "restitution": 0.5},
        {"kind": "contact", "frame": "link_1", "at": [1, 0, 0], "friction": 0.3},
        {"kind": "contact", "frame": "link_3", "against": "link_1", "friction": 1.5},
        {"kind": "joint_stop", "joint": "joint_2", "lower": 0, "restitution": 0.2},
        {"kind": "collision", "first": "link_1", "other": "link_3"},
    ),
    "forces": (
        {"kind": "joint_spring", "joint": "joint_2", "stiffness": 3},
        {"kind": "spring", "frame": "link_3", "stiffness": 3, "other_at": [0, 1, 0]},
        {"kind": "actuator", "joint": "joint_2", "torque": {"stiffness": 1}},
        {"kind": "applied_force", "frame": "link_1", "linear": [0, 0, 1]},
    ),
}
_TABLES: dict[str, dict[str, Any]] = {
    "law": {"restitution": "poisson", "slip": "end", "order": "simultaneous"},
    "motion": {"duration": 0.01, "samples": 5, "method": "dop853", "rtol": 1e-6},
    "state": {"q": {"joint_2": 0.3}, "v": {"joint_3": -1, "root_joint": [1, 0, 0]}},
    "report": {"points": [{"frame": "link_3", "at": [1, 0, 0], "label": "end"}]},
    "design": {"points": [{"frame": "link_3", "direction": [0, 1, 0]}]},
}


def random_scene(rng: Random) -> str:
    """The text of a scene file on a chain of three links; at some rate its parts are odd."""
    rate = rng.choice((0.0, 0.01, 0.03, 0.1, 0.3))

    def odd() -> bool:
        return rate > 0.0 and rng.random() < rate

    scene: dict[str, Any] = {}
    if odd():
        scene["gravity"] = rng.choice(_ODD)
    scene["robot"] = _disturbed(rng, {"urdf": "chain.urdf", "root": "planar"}, odd)
    if rng.random() < 0.1:
        alone = scene.pop("robot")
        alone.pop("root", None)
        placed = {**alone, "placement": _disturbed(rng, {"xyz": [0, 0, 2]}, odd)}
        names = ["a", rng.choice(("b", "", "a/b", "world", "\x1b[2J")) if odd() else "b"]
        scene["robots"] = {names[0]: alone, names[1]: _disturbed(rng, placed, odd)}
    for name, kinds in _ENTRIES.items():
        chosen = [dict(rng.choice(kinds)) for _ in range(rng.choice((0, 0, 1, 1, 2)))]
        if chosen and not (name == "constraints" and rng.random() < 0.5):
            scene[name] = [_disturbed(rng, entry, odd) for entry in chosen]
    for name, table in _TABLES.items():
        if rng.random() < 0.3:
            scene[name] = _disturbed(rng, dict(table), odd)
    scene = _disturbed(rng, scene, odd)
    text = "".join(_assignment(key, value) for key, value in scene.items() if not _is_table(value))
    text += "".join(_blocks(key, value, odd) for key, value in scene.items() if _is_table(value))
    if odd():
        text = (
            rng.choice(("\ufeff", "\0", "= 1\n", "x = [" * 400, "a.b.c = 1\n", "[[a.b]]\n")) + text
        )
    if odd():
        text += rng.choice(("[robot]\n", "x = " + "[" * 3000, "t = 1979-05-27\n", "x = 1e999", '"'))
    return text


def _disturbed(rng: Random, table: dict[str, Any], odd: Any) -> dict[str, Any]:
    """A table with values that are odd, missing, misspelt or too many."""
    found: dict[str, Any] = {}
    for key, value in table.items():
        if odd():
            continue
        if odd():
            key = rng.choice((key + "s", key.upper(), key[:-1], "", "kind", "name", "\x1b"))
        found[key] = rng.choice(_ODD) if odd() else value
    if odd():
        found[
            rng.choice(("name", "restitution", "friction", "velocity", "at", "axes", "x", "margin"))
        ] = rng.choice(_ODD)
    return found


def _is_table(value: Any) -> bool:
    return isinstance(value, dict) or (
        isinstance(value, list) and bool(value) and all(isinstance(x, dict) for x in value)
    )


def _blocks(key: str, value: Any, odd: Any) -> str:
    head = json.dumps(key, ensure_ascii=True)
    tables = value if isinstance(value, list) else [value]
    brackets = ("[[", "]]") if isinstance(value, list) else ("[", "]")
    if odd():
        brackets = ("[", "]")
    return "".join(
        f"{brackets[0]}{head}{brackets[1]}\n"
        + "".join(_assignment(name, entry) for name, entry in table.items())
        for table in tables
    )


def _assignment(key: str, value: Any) -> str:
    return f"{json.dumps(key, ensure_ascii=True)} = {_literal(value)}\n"


def _literal(value: Any) -> str:
    if isinstance(value, dict):
        inside = ", ".join(f"{json.dumps(k)} = {_literal(v)}" for k, v in value.items())
        return "{" + inside + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_literal, value)) + "]"
    if isinstance(value, float):
        return repr(value)
    # JSON's text and numbers are TOML's, but for the other half of the Unicode planes.
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")


_WORDS = (
    b"nan", b"inf", b"1e999", b"-1", b"0", b"1e308", b"\0", b"\xff\xfe", b"\xef\xbb\xbf", b"<",
    b"\"", b"'", b"&", b"]]>", b"<!DOCTYPE x>", b"<!--", b"[", b"]]", b"=", b"\n", b"\r", b"{}",
    b"\x1b[31m", b"#", b">", b"../", b"link_1", b"world", b"\xc3\x28", b"\xed\xa0\x80", b"name",
    b"999999999999999999999",
)  # fmt: skip


def mutated(rng: Random, whole: bytes) -> bytes:
    """A file with one to six changes."""
    data = bytearray(whole)
    for _ in range(rng.choice((1, 1, 1, 2, 3, 6))):
        begin = rng.randrange(len(data) + 1)
        end = min(len(data), begin + rng.choice((1, 1, 2, 4, 8, 40, 200)))
        change = rng.randrange(8)
        if change == 0 and begin < len(data):
            data[begin] ^= 1 << rng.randrange(8)
        elif change == 1 and begin < len(data):
            data[begin] = rng.randrange(256)
        elif change == 2:
            del data[begin:end]
        elif change == 3:
            data[begin:begin] = data[begin:end]
        elif change == 4:
            data[begin:begin] = rng.choice(_WORDS)
        elif change == 5:
            data[begin:end] = rng.choice(_WORDS)
        elif change == 6:
            other = rng.randrange(len(data) + 1)
            data[begin:end] = data[other : other + end - begin]
        else:
            data = _number_changed(rng, data)
    return bytes(data)


def _number_changed(rng: Random, data: bytearray) -> bytearray:
    """One of the numbers of the file becomes another."""
    import re

    found = list(re.finditer(rb"-?\d+\.?\d*(e-?\d+)?", data))
    if not found:
        return data
    match = rng.choice(found)
    number = rng.choice(
        (b"0", b"-1", b"1e-300", b"1e300", b"nan", b"inf", b"1e99", b"-" + match[0])
    )
    return data[: match.start()] + number + data[match.end() :]
