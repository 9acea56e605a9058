"""Scene files that are nearly right, and wrong in ways that hurt readers."""

from __future__ import annotations

import json
from random import Random
from typing import Any

__all__ = ["random_scene"]

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
