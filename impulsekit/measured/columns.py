"""Named columns of a recording: orders, units, gaps, each stated or an error."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin

from ..errors import (
    InputError,
    NotFiniteError,
    RangeError,
    ShapeError,
    StateError,
    UnknownNameError,
    quoted,
)
from ..errors.calls import public
from ..robot import Robot
from .csv_table import hint_for_name
from .recording_checks import (
    ANGLE_UNITS,
    LENGTH_UNITS,
    TIME_UNITS,
    check_joint_limits,
    checked_velocities,
    in_order,
    repeated_poses,
    turns_of,
    without_gaps,
)

ORDERS = ("xyzw", "wxyz")
REPAIRS = {
    "gaps": "leave out samples that hold a NaN",
    "time": "sort samples by time and leave out repeated ones",
    "norm": "scale quaternions to unit length",
}
# A quaternion whose length is off by more than this is no rotation, however it is scaled.
REPAIRABLE_NORM = 0.1
# Rounding of quaternions in files with four digits [relative]; scaled without a word.
ROUNDED_NORM = 2e-4
_FREE = ("JointModelFreeFlyer",)
_BODY = ("position", "quaternion", "quaternion_xyzw", "quaternion_wxyz", "velocity",
         "omega_body", "omega_world")  # fmt: skip
_WHOLE = ("t", "q", "v")
_JOINT = re.compile(r"(q|v|" + "|".join(_BODY) + r")\.(.+)$")


@public
@dataclass(frozen=True)
class RecordingFormat:
    """Units and orders of a recording that its column names do not say.

    Attributes:
        quaternion: "xyzw" or "wxyz", for a column called "quaternion"; None if the name of
            the column says it.
        time: "s", "ms", "us" or "ns".
        length: "m", "cm" or "mm": of positions and linear velocities.
        angle: "rad" or "deg": of joint angles and angular velocities.
        rate: samples per second, if there is no column of times [Hz].
        topics: of a ROS 2 bag, from the topic to the joint or, for joint states, "".

    Raises:
        RangeError: another value.

    Example:
        >>> RecordingFormat(quaternion="wxyz", length="mm").length
        'mm'
    """

    quaternion: str | None = None
    time: str = "s"
    length: str = "m"
    angle: str = "rad"
    rate: float | None = None
    topics: Mapping[str, str] | None = None

    def __post_init__(self) -> None:
        for what, known in (
            ("quaternion", (None, *ORDERS)),
            ("time", TIME_UNITS),
            ("length", LENGTH_UNITS),
            ("angle", ANGLE_UNITS),
        ):
            if getattr(self, what) not in known:
                allowed = ", ".join(quoted(each) for each in known)
                raise RangeError.of(
                    f"RecordingFormat: {what}", quoted(getattr(self, what)), allowed
                )
        if self.rate is not None and not (np.isfinite(self.rate) and self.rate > 0.0):
            raise RangeError.of("RecordingFormat: rate", self.rate, "above 0 Hz")


def read_columns(
    robot: Robot,
    columns: Mapping[str, Any],
    format: RecordingFormat | None = None,
    *,
    repair: str | Sequence[str] = (),
    name: str = "",
) -> tuple[np.ndarray, np.ndarray, np.ndarray | None, tuple[str, ...]]:
    """Return t, q, v where there is one, and notes on repairs; see ``Recording.from_columns``."""
    repair = (repair,) if isinstance(repair, str) else repair
    for each in repair:
        if each not in REPAIRS:
            raise UnknownNameError.among("repair", each, REPAIRS)
    reader = _Reader(robot, columns, format or RecordingFormat(), name or "recording")
    notes: list[str] = []
    samples = without_gaps(reader.read(), reader.where, repair, notes)
    t, q, v = in_order(samples, reader.where, repair, notes)
    q = _of_unit_length(robot.model, q, reader.where, repair, notes)
    v = checked_velocities(robot, t, q, v, reader.where, notes)
    notes += check_joint_limits(robot, q, reader.angles, reader.where)
    notes += repeated_poses(q)
    return t, q, v, tuple(notes)


class _Reader:
    """Columns by name, put into the configurations and velocities of a robot."""

    def __init__(
        self, robot: Robot, columns: Mapping[str, Any], format: RecordingFormat, where: str
    ) -> None:
        self.model, self.where, self.format = robot.model, where, format
        self.columns: dict[str, np.ndarray] = {}
        # Of joints that are kept as cosine and sine [rad].
        self.angles: dict[str, np.ndarray] = {}
        for name, values in columns.items():
            try:
                if np.iscomplexobj(values) or np.asarray(values).dtype.kind in ("M", "m"):
                    raise TypeError
                self.columns[str(name)] = np.array(values, dtype=float)
            except (TypeError, ValueError, OverflowError):
                raise NotFiniteError(
                    f'{where}: column "{name}" must be numbers', what=str(name), where=where
                ) from None
            if self.columns[str(name)].size == 0:
                raise InputError(f'{where}: column "{name}" holds no samples')
        if "time" in self.columns:
            self.columns["t"] = self.columns.pop("time")
        self._check_names()

    def _check_names(self) -> None:
        joints = [name for name in self.model.names if name != "universe"]
        for name in self.columns:
            found = _JOINT.match(name)
            if found and found.group(2) not in joints:
                raise UnknownNameError.among("joint", found.group(2), joints, self.where)
            if not found and name not in (*_WHOLE, *_BODY):
                ours = hint_for_name(name)
                if ours is not None:
                    raise UnknownNameError(
                        f"{self.where}: unknown column {quoted(name)}; call it {quoted(ours)} if "
                        "that is what it holds",
                        kind="column", name=name, nearest=(ours,), known=(*_WHOLE, *_BODY),
                    )  # fmt: skip
                known = (*_WHOLE, *_BODY, "q.JOINT", "v.JOINT")
                raise UnknownNameError.among("column", name, known, self.where)

    def read(self) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
        """Return (T,) times, (T, nq) configurations and (T, nv) velocities, if there are any."""
        count = {len(array) for array in self.columns.values() if array.ndim}
        if len(count) != 1 or any(array.ndim == 0 for array in self.columns.values()):
            lengths = ", ".join(f"{k}: {np.shape(a)}" for k, a in self.columns.items())
            raise ShapeError(
                f"{self.where}: all columns must have one row per sample, got {lengths or 'none'}",
                what=self.where, expected=("T",), got=tuple(sorted(count)),
            )  # fmt: skip
        (rows,) = count
        t = self._times(rows)
        q = np.tile(pin.neutral(self.model), (rows, 1))
        v = np.zeros((rows, self.model.nv))
        seen_q, seen_v = np.zeros(self.model.nq, bool), np.zeros(self.model.nv, bool)
        for name, array, seen, into in (("q", q, seen_q, q), ("v", v, seen_v, v)):
            if name in self.columns:
                if self.columns[name].shape != array.shape:
                    raise ShapeError.of(
                        f"{self.where}: {name}", array.shape, self.columns[name].shape
                    )
                into[:], seen[:] = self.columns[name], True
        for joint in list(self.model.joints)[1:]:
            self._joint(joint, q, v, seen_q, seen_v)
        missing = [
            str(self.model.names[joint.id])
            for joint in list(self.model.joints)[1:]
            if not seen_q[joint.idx_q : joint.idx_q + joint.nq].all()
        ]
        if missing:
            raise InputError(
                f"{self.where}: no position of joint {', '.join(map(quoted, missing[:4]))}; give "
                "q, q.JOINT, or position and quaternion_xyzw or quaternion_wxyz"
            )
        return t, q, v if seen_v.all() else None

    def _times(self, rows: int) -> np.ndarray:
        if "t" in self.columns:
            if self.columns["t"].ndim != 1:
                raise ShapeError.of(f"{self.where}: t", (rows,), self.columns["t"].shape)
            return self.columns["t"] * TIME_UNITS[self.format.time]
        if self.format.rate is None:
            raise InputError(f"{self.where}: there is no column t; give one, or the rate in Hz")
        return np.arange(rows) / self.format.rate

    def _column(self, kind: str, joint: Any, width: int | None = None) -> np.ndarray | None:
        """Return the column of a joint, (T, k); a free root's may stand without its name."""
        found = self.columns.get(f"{kind}.{self.model.names[joint.id]}")
        free = [each.id for each in self.model.joints if each.shortname() in _FREE]
        if found is None and kind in _BODY and free[:1] == [joint.id] and len(free) == 1:
            found = self.columns.get(kind)
        if found is None:
            return None
        found = found.reshape(len(found), -1)
        if width is not None and found.shape[1] != width:
            raise ShapeError.of(f"{self.where}: {kind}", ("T", width), found.shape)
        return found

    def _joint(
        self, joint: Any, q: np.ndarray, v: np.ndarray, seen_q: np.ndarray, seen_v: np.ndarray
    ) -> None:
        in_q, in_v = (
            slice(joint.idx_q, joint.idx_q + joint.nq),
            slice(joint.idx_v, joint.idx_v + joint.nv),
        )
        if joint.shortname() in _FREE:
            self._free_joint(joint, q[:, in_q], v[:, in_v], seen_q[in_q], seen_v[in_v])
        own = self._column("q", joint)
        if own is not None:
            q[:, in_q], seen_q[in_q] = self._coordinates(joint, own), True
        own = self._column("v", joint, joint.nv)
        if own is not None:
            v[:, in_v], seen_v[in_v] = own * self._unit(joint), True

    def _unit(self, joint: Any) -> float:
        """Return the factor of a joint's numbers: that of angles or of lengths."""
        if joint.nv != 1:
            return 1.0
        slides = "P" in joint.shortname().removeprefix("JointModel")[:1]
        return LENGTH_UNITS[self.format.length] if slides else ANGLE_UNITS[self.format.angle]

    def _coordinates(self, joint: Any, own: np.ndarray) -> np.ndarray:
        """Return (T, nq of the joint); angles become cosine and sine where the joint has these."""
        name = self.model.names[joint.id]
        if joint.nq == 2 and joint.nv == 1 and own.shape[1] == 1:
            angle = own[:, 0] * ANGLE_UNITS[self.format.angle]
            self.angles[str(name)] = angle
            return np.stack([np.cos(angle), np.sin(angle)], axis=1)
        if joint.nq == 4 and joint.nv == 3 and own.shape[1] == 3:
            angle = own[:, 2] * ANGLE_UNITS[self.format.angle]
            place = own[:, :2] * LENGTH_UNITS[self.format.length]
            return np.column_stack([place, np.cos(angle), np.sin(angle)])
        if own.shape[1] != joint.nq:
            raise ShapeError.of(f"{self.where}: q.{name}", ("T", joint.nq), own.shape)
        return own * self._unit(joint)

    def _free_joint(
        self, joint: Any, q: np.ndarray, v: np.ndarray, seen_q: np.ndarray, seen_v: np.ndarray
    ) -> None:
        """Read position and quaternion from their columns, velocities in world or body axes."""
        length, angle = LENGTH_UNITS[self.format.length], ANGLE_UNITS[self.format.angle]
        place = self._column("position", joint, 3)
        turn = self._quaternion(joint)
        if place is not None:
            q[:, :3], seen_q[:3] = place * length, True
        if turn is not None:
            q[:, 3:], seen_q[3:] = turn, True
        linear = self._column("velocity", joint, 3)
        body, world = (self._column(f"omega_{axes}", joint, 3) for axes in ("body", "world"))
        if linear is None or (body is None and world is None) or turn is None:
            return
        axes = turns_of(q[:, 3:])
        v[:, :3] = np.einsum("tji,tj->ti", axes, linear * length)
        if body is None and world is not None:
            body = np.einsum("tji,tj->ti", axes, world)
        v[:, 3:] = angle * np.asarray(body)
        seen_v[:] = True

    def _quaternion(self, joint: Any) -> np.ndarray | None:
        found = []
        for kind in ("quaternion", "quaternion_xyzw", "quaternion_wxyz"):
            own = self._column(kind, joint, 4)
            if own is None:
                continue
            order = self.format.quaternion if kind == "quaternion" else kind[-4:]
            if order is None:
                raise InputError(
                    f"{self.where}: the order of the quaternion is not stated; call the column "
                    'quaternion_xyzw or quaternion_wxyz, or give quaternion="xyzw" or '
                    'quaternion="wxyz" in '
                    "the RecordingFormat"
                )
            found.append(own if order == "xyzw" else own[:, [1, 2, 3, 0]])
        if len(found) > 1:
            raise InputError(f"{self.where}: more than one column holds the quaternion")
        return found[0] if found else None


def _of_unit_length(
    model: pin.Model, q: np.ndarray, where: str, repair: Any, notes: list[str]
) -> np.ndarray:
    """Return quaternions of unit length whose signs follow each other."""
    q = q.copy()
    for joint in list(model.joints)[1:]:
        pairs = {(7, 6): slice(3, 7), (4, 3): slice(0, 4), (2, 1): slice(0, 2)}
        own = pairs.get((joint.nq, joint.nv))
        if joint.shortname() == "JointModelPlanar":
            own = slice(2, 4)
        if own is None:
            continue
        part = q[:, joint.idx_q + own.start : joint.idx_q + own.stop]
        length = np.linalg.norm(part, axis=1)
        worst = int(np.abs(length - 1.0).argmax())
        off = abs(length[worst] - 1.0)
        if off > (REPAIRABLE_NORM if "norm" in repair else ROUNDED_NORM):
            hint = 'repair="norm" scales it' if off <= REPAIRABLE_NORM else "that is no rotation"
            joint_name = str(model.names[joint.id])
            raise StateError(
                f'{where}: the quaternion of joint "{joint_name}" at sample {worst} has length '
                f"{length[worst]:.6g} instead of 1; {hint}",
                joint=joint_name, value=part[worst].tolist(),
            )  # fmt: skip
        if off > ROUNDED_NORM:
            notes.append(f"quaternions with lengths off by up to {off:.2g} are scaled to 1")
        part /= length[:, None]
        if part.shape[1] == 4:
            # q and -q are one rotation: each sample takes the sign nearer to the last one's.
            turned = np.cumprod(np.where((part[1:] * part[:-1]).sum(axis=1) < 0.0, -1.0, 1.0))
            part[1:] *= turned[:, None]
    return q
