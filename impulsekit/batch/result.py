"""``ImpactBatch``: the answers of many states."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InputError
from ..errors.calls import public
from ..formatting import Displayed, one_line
from ..impact.status import Status
from ..rows.entries import rows_of_entry
from ..scene import Scene

if TYPE_CHECKING:
    from .program import BatchPlan

__all__ = ["OUTPUTS", "VERDICTS", "ImpactBatch", "shape_of"]

# What ``ImpactBatch.uniqueness`` counts, in order.
VERDICTS = ("proven", "not proven", "several")
OUTPUTS = (
    "v_after",
    "dv",
    "generalized_impulse",
    "energy_change",
    "contact_impulses",
    "constraint_impulses",
    "reactions",
    "bodies",
    "normal_components",
    "gaps",
    "uniqueness",
    "outcome_bounds",
)


def shape_of(scene: Scene, name: str) -> tuple[int, ...]:
    """The shape of an output for one row, by its name."""
    if name in ("energy_change", "uniqueness"):
        return ()
    if name in ("contact_impulses", "normal_components"):
        return (len(scene.contacts), 3)
    if name == "gaps":
        return (len(scene.contacts),)
    if name == "constraint_impulses":
        held = (rows_of_entry(scene.robot, entry) for entry in scene.held)
        return (sum(len(rows.labels) for rows in held),)
    if name == "reactions":
        return (scene.robot.model.njoints - 1, 6)
    if name == "outcome_bounds":
        return (2, scene.robot.nv)
    if name == "bodies":
        return (len(scene.robot.links), 6)
    return (scene.robot.nv,)


@public
@dataclass(frozen=True, eq=False, repr=False)
class ImpactBatch(Displayed):
    """The results of an impact at B states. Arrays are read-only; rows that failed hold NaN.

    Attributes:
        status: (B,) the ``Status`` of each row, as an integer code.
        plan: how the rows were solved.
        arrays: the requested outputs, by name.
        doubts: what of the scene and the states is likely not meant, a sentence for each contact
            that is open, or overlaps, by more than ``Scene.gap_bound``, with the number of rows.
        scene: the scene, for the names in ``to_xarray``.

    Example:
        >>> import numpy as np
        >>> ImpactBatch(np.zeros(2, dtype=np.int8), None, {"dv": np.ones((2, 3))}).dv.shape
        (2, 3)
    """

    status: np.ndarray
    plan: BatchPlan | None
    arrays: dict[str, np.ndarray] = field(repr=False)
    doubts: tuple[str, ...] = ()
    scene: Scene | None = field(default=None, repr=False)

    def __repr__(self) -> str:
        outputs = f"outputs {', '.join(self.arrays)}"
        # On Dask nothing is computed to be shown.
        if not isinstance(self.status, np.ndarray):
            return one_line("ImpactBatch", "not computed yet", outputs)
        counts = [f"{n} {status.name}" for status, n in self.count().items()]
        return one_line("ImpactBatch", *(counts or ["no rows"]), f"{len(self)} rows", outputs)

    @property
    def v_after(self) -> np.ndarray:
        """(B, nv) the velocities after the impact."""
        return self._asked("v_after")

    @property
    def dv(self) -> np.ndarray:
        """(B, nv) the jumps Δv."""
        return self._asked("dv")

    @property
    def generalized_impulse(self) -> np.ndarray:
        """(B, nv) I = M Δv."""
        return self._asked("generalized_impulse")

    @property
    def energy_change(self) -> np.ndarray:
        """(B,) the change of kinetic energy [J]."""
        return self._asked("energy_change")

    @property
    def contact_impulses(self) -> np.ndarray:
        """(B, contacts, 3) in world axes [N s]; of a joint stop, along its coordinate, in [0]."""
        return self._asked("contact_impulses")

    @property
    def normal_components(self) -> np.ndarray:
        """(B, contacts, 3) u_n⁻, u_n⁺ [m/s] and P_n [N s] along each contact's normal.

        Velocities are positive where the contact opens. Of a joint stop [rad/s, N m s]. A contact
        without impulse has zeros; one of several points the mean velocity of the points that
        carry one, and the sum of their impulses.
        """
        return self._asked("normal_components")

    @property
    def gaps(self) -> np.ndarray:
        """(B, contacts) the gap of each contact [m, rad], of several points the lowest.

        Negative where bodies overlap; NaN of a contact that does not touch.
        """
        return self._asked("gaps")

    @property
    def constraint_impulses(self) -> np.ndarray:
        """(B, rows) of the bilateral constraints, row after row as in ``Impact``."""
        return self._asked("constraint_impulses")

    @property
    def reactions(self) -> np.ndarray:
        """(B, joints, 6) what the parent gives the child at each joint's origin, world axes.

        Force impulse [N s] before moment impulse [N m s]; the moving joints in the order of
        ``robot.joint_names``.
        """
        return self._asked("reactions")

    @property
    def bodies(self) -> np.ndarray:
        """(B, links, 6) Δ of each link's mass centre [m/s] and angular velocity [rad/s].

        World axes, the links in the order of ``robot.links``.
        """
        return self._asked("bodies")

    @property
    def uniqueness(self) -> np.ndarray:
        """(B,) the index of each row's verdict in ``VERDICTS``.

        0 if it is proven that no other v⁺ obeys the law and gains no energy, 1 if it is not
        proven, 2 if others were found: ``solve`` of the row gives them, in ``impact.uniqueness``.
        """
        return self._asked("uniqueness")

    @property
    def outcome_bounds(self) -> np.ndarray:
        """(B, 2, nv) the least and the largest v⁺ in any order and shares of the contacts.

        Inner bounds, as ``Outcomes.bounds`` of 512 samples and a short search; NaN where no process
        comes to its end.
        """
        return self._asked("outcome_bounds")

    @property
    def valid(self) -> np.ndarray:
        """(B,) whether each row may be used."""
        good = [code.code for code in Status if code.valid]
        return np.isin(self.status, good)

    def to_xarray(self) -> Any:
        """Return an ``xarray.Dataset`` of the status and the outputs along "row".

        Further axes are "speed", "contact", "joint" and "link", by name, "axis" and "row of a
        constraint"; impulses, velocities and gaps as the properties of this class have them.

        Raises:
            MissingExtraError: xarray is not installed.

        Example:
            >>> from impulsekit import Contact, Robot, Scene, solve_batch
            >>> ball = Robot.from_urdf("models/ball.urdf", root="freeflyer")
            >>> scene = Scene(ball, contacts=[Contact("ball", name="floor")])
            >>> found = solve_batch(scene, ball.neutral(), [[0, 0, -1, 0, 0, 0]] * 3)
            >>> found.to_xarray().v_after.sel(speed="root_joint[2]").shape
            (3,)
        """
        from .tables import batch_table

        return batch_table({"status": self.status, **self.arrays}, self.scene)

    def count(self) -> dict[Status, int]:
        """Return the number of rows by status."""
        return {Status(k): n for k, n in sorted(Counter(self.status.tolist()).items())}

    def _asked(self, name: str) -> np.ndarray:
        if name not in self.arrays:
            asked = ", ".join(f'"{one}"' for one in self.arrays)
            raise InputError(f'"{name}" was not requested; outputs were {asked}')
        return self.arrays[name]

    def __len__(self) -> int:
        return len(self.status)
