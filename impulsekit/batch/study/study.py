"""``Study``: a scene, a state, and what varies around them."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from ...errors import InputError, RangeError, UnknownNameError
from ...errors.calls import public
from ...formatting import OneLine
from ...scene import AppliedImpulse, Scene
from ...scene.motion import MotionSettings
from ...scene.numbers import keep, number, optional, text, whole
from ..masses import heavy_links, link_inertia
from ..result import OUTPUTS
from .fingerprint import described, geometry_digest, robot_digest, versions

# By what varies, the array of the rows that holds what was drawn, and what it is drawn for.
VARIED = {
    "configuration": ("q", "joint"),
    "velocity": ("v", "joint"),
    "impulse": ("impulses", "impulse"),
    "direction": ("impulses", "impulse"),
    "restitution": ("restitution", "contact"),
    "friction": ("friction", "contact"),
    "mass": ("masses", "link"),
}
DISTRIBUTIONS = ("uniform", "normal")


@public
@dataclass(frozen=True)
class Variation:
    """A random quantity, drawn for every row.

    Attributes:
        what: the quantity.

            - "configuration": a step from the file's q along each degree of freedom
              [rad, m], independent of each other.
            - "velocity": an addition to the file's v [rad/s, m/s], in the same way.
            - "impulse": a factor on a known impulse.
            - "direction": an angle [rad] by which a known impulse is rotated about a normal axis,
              whose direction is uniform.
            - "restitution", "friction": the coefficient of a contact itself.
            - "mass": a factor on the mass of a link, and on its inertia with it.
        of: the joint, known impulse, contact or link by name; all of them by default,
            independent of each other.
        distribution: "uniform" from ``low`` to ``high``, or "normal" with ``mean`` and
            ``deviation``.
        low, high: bounds; samples of a normal distribution are clipped to them.

    Raises:
        RangeError, NotFiniteError, UnknownNameError, InputError.

    Example:
        >>> Variation("friction", low=0.3, high=0.9).distribution
        'uniform'
    """

    what: str
    of: str | None = None
    distribution: str = "uniform"
    low: float | None = None
    high: float | None = None
    mean: float = 0.0
    deviation: float | None = None

    def __post_init__(self) -> None:
        for name, known in (("what", VARIED), ("distribution", DISTRIBUTIONS)):
            if getattr(self, name) not in known:
                kind = {"what": "quantity to vary"}.get(name, name)
                raise UnknownNameError.among(kind, str(getattr(self, name)), known, "Variation")
        where = f"Variation of {self.what}"
        if self.of is not None:
            text(self.of, f"{where}: of")
        keep(self, where, optional(number), "low", "high", "mean", "deviation")
        if self.distribution == "uniform" and (self.low is None or self.high is None):
            raise InputError(f"{where}: a uniform distribution needs low and high")
        if self.distribution == "normal":
            if self.deviation is None:
                raise InputError(f"{where}: a normal distribution needs a deviation")
            if self.deviation < 0.0:
                raise RangeError.of(f"{where}: deviation", self.deviation, "0 or more")
        if self.low is not None and self.high is not None and self.low > self.high:
            raise RangeError.of(f"{where}: low", self.low, f"at most high, {self.high:g}")
        self._check_coefficient(where)

    def _check_coefficient(self, where: str) -> None:
        """Check that a coefficient that is drawn stays in its range."""
        if self.what == "mass" and (self.low is None or self.low <= 0.0):
            raise RangeError.of(f"{where}: low", self.low, "above 0")
        if self.what not in ("restitution", "friction"):
            return
        if self.low is None or self.low < 0.0:
            raise RangeError.of(f"{where}: low", self.low, "0 or more")
        if self.what == "restitution" and (self.high is None or self.high > 1.0):
            raise RangeError.of(f"{where}: high", self.high, "at most 1")

    def draw(self, rng: np.random.Generator, shape: tuple[int, ...]) -> np.ndarray:
        """Draw numbers of this distribution."""
        if self.distribution == "uniform":
            low, high = float(self.low or 0.0), float(self.high or 0.0)
            return rng.uniform(low, high, shape)
        drawn = self.mean + float(self.deviation or 0.0) * rng.standard_normal(shape)
        if self.low is not None or self.high is not None:
            np.clip(drawn, self.low, self.high, out=drawn)
        return drawn


MOTION_OUTPUTS = (
    "end",
    "q_end",
    "v_end",
    "impact_count",
    "contact_impulses",
    "q_samples",
    "v_samples",
)
# Rows of a chunk: some 0.1 s of impacts, some tens of seconds of motions.
IMPACTS, MOTIONS = 16384, 64


@public
@dataclass(frozen=True, eq=False, repr=False)
class Study(OneLine):
    """A scene at many random states and coefficients, the same on every machine.

    The rows are impacts, or motions.

    Rows come in chunks. Each chunk has its own random stream (Philox, a counter-based
    generator, keyed by seed and chunk), so that any chunk can be drawn alone.

    Attributes:
        scene: the robot, what acts on it, and the law of contact.
        q, v: (nq,), (nv,) the state around which poses and velocities vary.
        samples: number of rows.
        seed: seed of the random numbers.
        vary: the variations, drawn in this order.
        outputs: as for ``solve_batch``; of motions "end", "q_end", "v_end", "impact_count",
            "contact_impulses" (all impacts of a motion together), "q_samples", "v_samples".
            None for "v_after", of motions for the first four.
        chunk: rows per chunk; None for 16384, of motions for 64.
        motion: the settings of motions; None for impacts alone.

    Raises:
        RangeError, UnknownNameError, InputError, ShapeError, NotFiniteError, StateError.

    Example:
        >>> from impulsekit import AppliedImpulse, Robot, Scene
        >>> from impulsekit.models import pendulum_urdf
        >>> from impulsekit.study import Variation
        >>> rod = Robot.from_urdf(pendulum_urdf(1))
        >>> scene = Scene(rod, [AppliedImpulse("link_1", linear=[1, 0, 0])])
        >>> pushed = Variation("velocity", low=0.0, high=0.1)
        >>> study = Study(scene, [0.0], [0.0], samples=100, vary=[pushed])
        >>> study.rows(0)
        (0, 100)
    """

    scene: Scene
    q: np.ndarray
    v: np.ndarray
    samples: int
    seed: int = 0
    vary: Sequence[Variation] = ()
    outputs: Sequence[str] | None = None
    chunk: int | None = None
    motion: MotionSettings | None = None

    def __post_init__(self) -> None:
        from ...robot import state

        model = self.scene.robot.model
        set_field = object.__setattr__
        set_field(self, "q", state.checked_configuration(model, self.q))
        set_field(self, "v", state.checked_velocity(model, self.v))
        set_field(self, "vary", tuple(self.vary))
        moves = self.motion is not None
        if self.outputs is None:
            set_field(self, "outputs", MOTION_OUTPUTS[:4] if moves else ("v_after",))
        if self.chunk is None:
            set_field(self, "chunk", MOTIONS if moves else IMPACTS)
        set_field(self, "outputs", tuple(self.outputs or ()))
        for name, least in (("samples", 1), ("seed", 0), ("chunk", 8)):
            set_field(self, name, whole(getattr(self, name), f"study: {name}", least))
        if self.seed >= 2**64:
            raise RangeError.of("study: seed", self.seed, "less than 2**64")
        for name in self.names:
            known = MOTION_OUTPUTS if moves else OUTPUTS
            if name not in known:
                raise UnknownNameError.among("output", str(name), known)
        for one in self.vary:
            self._check(one)

    @property
    def rows_of_chunk(self) -> int:
        """The number of rows of a chunk."""
        return self.chunk or IMPACTS

    @property
    def names(self) -> tuple[str, ...]:
        """The outputs by name."""
        return tuple(self.outputs or ())

    @property
    def chunks(self) -> int:
        """The number of chunks."""
        return -(-self.samples // self.rows_of_chunk)

    def rows(self, index: int) -> tuple[int, int]:
        """Return the first row of a chunk, and the one after its last."""
        return index * self.rows_of_chunk, min((index + 1) * self.rows_of_chunk, self.samples)

    def drawn(self, index: int) -> dict[str, Any]:
        """Return the arguments of ``solve_batch`` for a chunk: q, v, and what varies besides."""
        begin, end = self.rows(index)
        rows, scene = end - begin, self.scene
        key = np.array([self.seed, index], dtype=np.uint64)
        rng = np.random.Generator(np.random.Philox(key=key))
        steps = {what: np.zeros((rows, scene.robot.nv)) for what in ("configuration", "velocity")}
        impulses = {
            name: np.tile(np.array(entry.values), (rows, 1))
            for name, entry in zip(scene.entry_names("impulses"), scene.impulses, strict=True)
        }
        factors: dict[str, np.ndarray] = {}
        coefficients: dict[str, dict[str, np.ndarray]] = {"restitution": {}, "friction": {}}
        for one in self.vary:
            if one.what in steps:
                columns = self._columns(one.of)
                steps[one.what][:, columns] += one.draw(rng, (rows, len(columns)))
                continue
            for name in self._names(one):
                drawn = one.draw(rng, (rows,))
                if one.what == "impulse":
                    impulses[name] *= drawn[:, None]
                elif one.what == "direction":
                    _turn(impulses[name], drawn, rng.uniform(0.0, 2.0 * np.pi, rows))
                elif one.what == "mass":
                    factors[name] = factors.get(name, 1.0) * drawn
                else:
                    coefficients[one.what][name] = drawn
        whats = {one.what for one in self.vary}
        found: dict[str, Any] = {"q": self.q, "v": self.v}
        if "configuration" in whats:
            found["q"] = self._stepped(steps["configuration"])
        if "velocity" in whats:
            found["v"] = self.v + steps["velocity"]
        if whats & {"impulse", "direction"}:
            found["impulses"] = impulses
        found.update({name: own for name, own in coefficients.items() if own})
        if factors:
            found["masses"] = {name: factors[name] for name in self.scaled_links}
        return found

    @property
    def varied(self) -> tuple[str, ...]:
        """The arrays of the rows that hold what was drawn."""
        return tuple(dict.fromkeys(VARIED[one.what][0] for one in self.vary))

    def stored(self, name: str, given: dict[str, Any], rows: int) -> np.ndarray:
        """Return an array of ``varied``, of the arguments of a chunk that ``drawn`` gave."""
        if name in ("q", "v"):
            return given[name]
        if name in ("impulses", "masses"):
            return np.column_stack(list(given[name].values()))
        table = np.empty((rows, len(self.scene.contacts)))
        for i, entry in enumerate(self.scene.contacts):
            own = getattr(entry, name, 0.0)
            table[:, i] = np.nan if callable(own) else own
        for label, drawn in given[name].items():
            table[:, self.scene.entry_names("contacts").index(label)] = drawn
        return table

    @property
    def scaled_links(self) -> tuple[str, ...]:
        """The links whose masses vary, in the order of the robot's."""
        named = {name for one in self.vary if one.what == "mass" for name in self._names(one)}
        return tuple(name for name in heavy_links(self.scene.robot) if name in named)

    def _stepped(self, steps: np.ndarray) -> np.ndarray:
        """Return the (rows, nq) study's q, stepped along the degrees of freedom."""
        model = self.scene.robot.model
        if model.nq == model.nv:
            return self.q + steps
        import pinocchio as pin

        return np.array([pin.integrate(model, self.q, step) for step in steps])

    def _columns(self, joint: str | None) -> np.ndarray:
        robot = self.scene.robot
        if joint is None:
            return np.arange(robot.nv)
        item = robot.model.joints[robot.joint_id(joint)]
        return np.arange(item.idx_v, item.idx_v + item.nv)

    def _names(self, one: Variation) -> tuple[str, ...]:
        """Return the impulses, contacts or links for which something is drawn."""
        if one.of is not None:
            return (one.of,)
        if one.what == "mass":
            return heavy_links(self.scene.robot)
        return self.scene.entry_names(f"{VARIED[one.what][1]}s")

    def _check(self, one: Variation) -> None:
        robot, where, kind = self.scene.robot, f"Variation of {one.what}", VARIED[one.what][1]
        if kind == "joint":
            if one.of is not None:
                robot.joint_id(one.of, where)
        elif kind == "link":
            if one.of is not None:
                link_inertia(robot, one.of)
            elif not heavy_links(robot):
                raise InputError(f"{where}: no link that moves has a mass")
        else:
            names = self.scene.entry_names(f"{kind}s")
            if not names:
                raise InputError(f"{where}: the scene has no {kind}s")
            if one.of is not None and one.of not in names:
                raise UnknownNameError.among(kind, one.of, names, where)
        if one.what == "direction":
            entries = dict(zip(names, self.scene.impulses, strict=True))
            for name in self._names(one):
                if not isinstance(entries[name], AppliedImpulse):
                    raise InputError(f'{where}: "{name}" is inside a joint')

    def describe(self) -> dict[str, Any]:
        """Return all that a row depends on, ready for JSON: two studies differ in it."""
        return self._described

    def __getstate__(self) -> dict[str, Any]:
        # Another process finds anew what its rows depend on, from its own files and packages.
        return {name: value for name, value in self.__dict__.items() if name != "_described"}

    @cached_property
    def _described(self) -> dict[str, Any]:
        scene = self.scene
        return {
            "samples": self.samples,
            "seed": self.seed,
            "chunk": self.chunk,
            "outputs": list(self.names),
            "vary": described(self.vary, "vary"),
            "q": self.q.tolist(),
            "v": self.v.tolist(),
            "robot": robot_digest(scene.robot),
            "geometry": geometry_digest(scene),
            **{
                field.name: described(getattr(scene, field.name), field.name)
                for field in fields(scene)
                if field.name != "robot"
            },
            "versions": versions(),
            **({} if self.motion is None else {"motion": described(self.motion, "motion")}),
        }

    @property
    def fingerprint(self) -> str:
        """A short text that two studies share only if they are the same."""
        whole = json.dumps(self.describe(), sort_keys=True)
        return hashlib.sha256(whole.encode()).hexdigest()[:32]


def _turn(wrenches: np.ndarray, angles: np.ndarray, around: np.ndarray) -> None:
    """Turn force and couple of each row by an angle about an axis across its force."""
    along = wrenches[:, :3]
    first = np.cross(along, np.eye(3)[np.abs(along).argmin(axis=1)])
    second = np.cross(along, first)
    axes = [
        np.divide(axis, size, out=np.zeros_like(axis), where=size > 0.0)
        for axis in (first, second)
        for size in (np.linalg.norm(axis, axis=1, keepdims=True),)
    ]
    axis = np.cos(around)[:, None] * axes[0] + np.sin(around)[:, None] * axes[1]
    turn = Rotation.from_rotvec(angles[:, None] * axis)
    for part in (slice(0, 3), slice(3, 6)):
        wrenches[:, part] = turn.apply(wrenches[:, part])
