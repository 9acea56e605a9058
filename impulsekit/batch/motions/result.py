"""``MotionBatch``: many motions of one scene as arrays."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from ...errors import MissingExtraError, RangeError
from ...errors.calls import public
from ...formatting import Displayed, OneLine, one_line
from ...motion.record.status import MotionStatus

if TYPE_CHECKING:
    from ...motion.record.trajectory import Trajectory

__all__ = ["ImpactTable", "MotionBatch", "RestTable"]


@dataclass(frozen=True, eq=False, repr=False)
class ImpactTable(OneLine):
    """The impacts of all motions, N of them, by row and in order of time. Read-only.

    Attributes:
        contacts: the names of the scene's contacts.
        row: (N,) which motion. time: (N,) [s].
        status: (N,) the ``Status`` of each, as a small whole number.
        touching: (N, contacts) whether each contact took part.
        impulse: (N, contacts, 3) on the first body, world axes [N s]; of a joint stop, in its
            joint, in [0].
        v_before, v_after: (N, nv).
    """

    contacts: tuple[str, ...]
    row: np.ndarray
    time: np.ndarray
    status: np.ndarray
    touching: np.ndarray
    impulse: np.ndarray
    v_before: np.ndarray
    v_after: np.ndarray

    def __len__(self) -> int:
        return len(self.row)


@dataclass(frozen=True, eq=False, repr=False)
class RestTable(OneLine):
    """The rests of contacts, in all motions. Read-only.

    Attributes:
        row: (N,) which motion. contact: (N,) the name.
        start, end: (N,) [s]; infinite where it still rested at the end of its motion.
    """

    row: np.ndarray
    contact: np.ndarray
    start: np.ndarray
    end: np.ndarray

    def __len__(self) -> int:
        return len(self.row)


@public
@dataclass(frozen=True, eq=False, repr=False)
class MotionBatch(Displayed):
    """B motions of one scene. Arrays are read-only.

    Attributes:
        t: (T,) the sample times of all [s].
        q: (B, T, nq), v: (B, T, nv): each row what ``simulate`` gives, bit for bit;
            NaN after a motion has ended, and where one was refused.
        status: (B,) the ``MotionStatus`` of each row by its ``code``.
        detail: (B,) what else there is to say of the end, "" where there is nothing.
        end: (B,) up to when each was followed [s]. q_end: (B, nq), v_end: (B, nv) there.
        impacts, rests: tables over all rows.
        evaluations: (B,) how many times the accelerations were worked out.
        again: gives the motion of a row once more.

    Example:
        >>> from impulsekit import Robot, Scene, simulate_batch
        >>> from impulsekit.models import pendulum_urdf
        >>> scene = Scene(Robot.from_urdf(pendulum_urdf(1)))
        >>> motions = simulate_batch(scene, [[0.1], [0.2]], [0.0], 0.5)
        >>> len(motions), bool(motions.finished.all())
        (2, True)
    """

    t: np.ndarray
    q: np.ndarray
    v: np.ndarray
    status: np.ndarray
    detail: tuple[str, ...]
    end: np.ndarray
    q_end: np.ndarray
    v_end: np.ndarray
    impacts: ImpactTable
    rests: RestTable
    evaluations: np.ndarray
    again: Callable[[int], Trajectory] = field(repr=False)

    def __len__(self) -> int:
        return len(self.status)

    @property
    def finished(self) -> np.ndarray:
        """(B,) whether each was followed to its end."""
        return self.status == MotionStatus.FINISHED.code

    def count(self) -> dict[MotionStatus, int]:
        """Return the number of rows by status."""
        statuses = list(MotionStatus)
        return {statuses[k]: n for k, n in sorted(Counter(self.status.tolist()).items())}

    def motion(self, row: int) -> Trajectory:
        """The motion of a row in full, followed once more by ``simulate`` in this process.

        Raises:
            RangeError: no such row.
            ImpulsekitError: why it was refused.
        """
        if not 0 <= row < len(self):
            raise RangeError.of("row", row, f"0 to {len(self) - 1}")
        return self.again(int(row))

    def to_xarray(self) -> Any:
        """An ``xarray.Dataset``: samples along "row" and "time", impacts along "impact".

        Raises:
            MissingExtraError: xarray is not installed.
        """
        with MissingExtraError.unless("xarray", "study", "MotionBatch.to_xarray"):
            import xarray
        by_impact = ("impact", "contact")
        hits = self.impacts
        names = [status.name for status in MotionStatus]
        return xarray.Dataset(
            {
                "q": (("row", "time", "coordinate"), self.q),
                "v": (("row", "time", "speed"), self.v),
                "status": ("row", [names[code] for code in self.status]),
                "end": ("row", self.end, {"units": "s"}),
                "q_end": (("row", "coordinate"), self.q_end),
                "v_end": (("row", "speed"), self.v_end),
                "impact_row": ("impact", hits.row),
                "impact_time": ("impact", hits.time, {"units": "s"}),
                "impulse": ((*by_impact, "axis"), hits.impulse, {"units": "N s"}),
                "touching": (by_impact, hits.touching),
            },
            coords={
                "time": ("time", self.t, {"units": "s"}),
                "contact": list(hits.contacts),
                "axis": ["x", "y", "z"],
            },
        )

    def __repr__(self) -> str:
        counts = [f"{n} {status.name}" for status, n in self.count().items()]
        size = f"{len(self)} rows, {len(self.t)} samples, {len(self.impacts)} impacts"
        return one_line("MotionBatch", *counts, size)
