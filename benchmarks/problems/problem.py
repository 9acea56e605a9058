"""A question with a known answer, kept answers, and states drawn the same everywhere."""

from __future__ import annotations

import dataclasses
import functools
import hashlib
import json
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from impulsekit.robot import Robot
from impulsekit.robot.arrays import read_only
from impulsekit.scene import Scene


@dataclass(frozen=True)
class Problem:
    """An impact, or a motion after one, whose outcome is known beyond double precision.

    Attributes:
        family: what is asked, "struck chain" for one.
        size: what grows within the family: links, contacts, bodies.
        scene: what strikes, holds and touches.
        q: (nq,) configuration.
        v: (nv,) velocity before.
        exact: works out the answer, rounded once to double: ``v_after`` (nv,), or where
            ``duration`` is given, q and v at its end, one after the other (nq + nv,).
            Ask for ``answer``, which calls it once.
        source: where the answer comes from, in a few words.
        tolerance: relative error up to which a method counts as having solved it.
        duration: seconds of motion after the impact; 0 asks for the velocities alone.
    """

    family: str
    size: int
    scene: Scene
    q: np.ndarray
    v: np.ndarray
    exact: Callable[[], np.ndarray] = field(repr=False)
    source: str
    tolerance: float = 1e-9
    duration: float = 0.0

    @property
    def name(self) -> str:
        """Family and size: "struck chain 60"."""
        return f"{self.family} {self.size}"

    @cached_property
    def answer(self) -> np.ndarray:
        """What ``exact`` gives, kept; read-only."""
        answer = np.array(self.exact(), dtype=float)
        return read_only(answer)

    def error(self, found: np.ndarray) -> float:
        """Largest deviation from the exact answer, relative to the exact answer's largest."""
        exact = self.answer
        if np.shape(found) != exact.shape or not np.isfinite(found).all():
            return float("inf")
        scale = float(np.abs(exact).max()) or 1.0
        return float(np.abs(found - exact).max()) / scale


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


def drawn_state(robot: Robot, seed: int, spread: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """(nq,) configuration and (nv,) velocity.

    Joint coordinates are uniform within ``spread`` [rad, m] of neutral, about as much for
    what lies on a circle or sphere; velocities are uniform within 1.
    """
    rng = np.random.default_rng(seed)
    model, q = robot.model, robot.neutral()
    for joint in list(model.joints)[1:]:
        at = slice(joint.idx_q, joint.idx_q + joint.nq)
        draws = rng.uniform(-spread, spread, joint.nq)
        if joint.nq == joint.nv:
            q[at] = draws
        elif joint.nq == 2:
            q[at] = _on_circle(draws[0])
        elif joint.nq == 4 and joint.nv == 3 and joint.shortname() == "JointModelPlanar":
            q[at] = [draws[0], draws[1], *_on_circle(draws[2])]
        else:
            # The last four are a quaternion x, y, z, w.
            quaternion = np.array([*(0.5 * draws[-4:-1]), 1.0])
            quaternion /= np.sqrt(quaternion.dot(quaternion))
            q[at] = [*draws[:-4], *quaternion]
    return q, rng.uniform(-1.0, 1.0, robot.nv)


def _on_circle(turn: float) -> tuple[float, float]:
    """Cosine and sine of about ``turn``: t = tan(α/2) and the two rational functions of it."""
    t = 0.5 * turn
    return (1.0 - t * t) / (1.0 + t * t), 2.0 * t / (1.0 + t * t)
