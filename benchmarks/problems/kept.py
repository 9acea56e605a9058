"""Answers that take long to work out, kept beside the code as decimals of 50 digits.

Each is kept with a digest of what it answers. Where that does not fit, because a robot's
URDF or a problem has changed, the answer is worked out again on the spot, so an old one is
never used. ``python -m tests.bench.answers`` works out and writes what is missing or old.
"""

from __future__ import annotations

import dataclasses
import functools
import hashlib
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from impulsekit.scene import Scene

__all__ = ["FOLDER", "digest", "exact_or_kept", "kept", "path_of"]

FOLDER = Path(__file__).parent / "answers"


def exact_or_kept(
    family: str,
    size: int,
    scene: Scene,
    q: np.ndarray,
    v: np.ndarray,
    derive: Callable[[], Any],
    duration: float = 0.0,
) -> Callable[[], np.ndarray]:
    """The ``exact`` of a problem: the kept answer, or ``derive``'s where there is none.

    Args:
        derive: gives the answer as numbers of mpmath.
    """

    def exact() -> np.ndarray:
        entry = kept(family).get(str(size))
        if entry is None or entry["of"] != digest(scene, q, v, duration):
            return np.array([float(number) for number in derive()])
        return np.array([float(text) for text in entry["answer"]])

    exact.derive = derive  # type: ignore[attr-defined]
    return exact


def digest(scene: Scene, q: np.ndarray, v: np.ndarray, duration: float) -> str:
    """What an answer belongs to: the robot as text, all entries, the state bit for bit."""
    parts = [(p.prefix, p.urdf, p.root, p.mimic, p.placement) for p in scene.robot.parts]
    held = (scene.impulses, scene.constraints, scene.contacts)
    entries = [*([_said(entry) for entry in entries] for entries in held), _said(scene.law)]
    state = (q.tolist(), v.tolist())
    whole = repr((parts, entries, state))
    if duration:
        whole += repr((scene.forces, scene.gravity, duration))
    return hashlib.sha256(whole.encode()).hexdigest()[:32]


def _said(entry: Any) -> tuple[str, list[tuple[str, str]]]:
    """An entry by what it says: fields at their defaults are left out, later ones among them."""
    said = [
        (field.name, repr(getattr(entry, field.name)))
        for field in dataclasses.fields(entry)
        if repr(getattr(entry, field.name)) != repr(field.default)
    ]
    return type(entry).__name__, said


@functools.cache
def kept(family: str) -> dict[str, Any]:
    """The kept answers of a family, by size: "of", a digest, and "answer", decimals."""
    path = path_of(family)
    return json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}


def path_of(family: str) -> Path:
    """The file of a family's answers."""
    return FOLDER / f"{family.replace(' ', '_').replace(',', '')}.json"
