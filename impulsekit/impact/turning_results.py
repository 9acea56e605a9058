"""Results of contacts that resist rolling and spin."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..formatting import OneLine
from ..robot.arrays import lock
from .contact_law import NO_SLIP

if TYPE_CHECKING:
    from .answer import Answer

__all__ = ["NO_SLIP", "ON_CONE", "TurningResult", "turning_result"]

# A tangential impulse this near µ P_n has reached the cone.
ON_CONE = 1e-9
# Angular velocities that differ by less than this share of the terms they are sums of are one: some
# hundreds of roundings.
SAME_START = 1e-13


@dataclass(frozen=True, eq=False, repr=False)
class TurningResult(OneLine):
    """The angular impulse of a point against rolling and spin, world axes.

    Attributes:
        impulse: (3,) angular impulse on the first body [N m s].
        velocity_before, velocity_after: (3,) angular, of the first body relative to the other
            [rad/s].
        rolling: "separated", "rolling" (at the limit, rolling·P_n) or "sticking".
        spin: "separated", "spinning" (at the limit, torsion·P_n) or "sticking".
        work: of the angular impulse [J].
    """

    impulse: np.ndarray
    velocity_before: np.ndarray
    velocity_after: np.ndarray
    rolling: str
    spin: str
    work: float

    def to_dict(self) -> dict[str, Any]:
        """Ready for JSON, under the names of a point."""
        return {
            "angular_impulse": self.impulse.tolist(),
            "rolling": self.rolling,
            "spin": self.spin,
            "angular_velocity_before": self.velocity_before.tolist(),
            "angular_velocity_after": self.velocity_after.tolist(),
            "turning_work": self.work,
        }


def turning_result(impact: Answer, k: int) -> TurningResult:
    """Return the result of the k-th touch of an impact, whose rows are of turning."""
    outcome = impact.outcome
    if outcome is None or outcome.contacts is None:
        raise ValueError("no contact touched")
    touch, solution = outcome.touches[k], outcome.contacts
    if touch.axes is None:
        raise ValueError("a joint stop does not turn")
    own = slice(3 * k, 3 * k + 3)
    local, normal = solution.impulse[own], float(solution.impulse[3 * touch.turns + 2])
    before, after = touch.jacobian @ impact.v_before, touch.jacobian @ impact.v_after
    start = solution.velocity_start[own]
    fastest = max(np.abs(before).max(), np.abs(after).max())
    size = np.abs(touch.jacobian).sum() * fastest * SAME_START
    # As for forces: a law that follows the impact knows the work, if nothing else acts.
    work = float(solution.friction_work[k])
    if np.abs(start - before).max() > size:
        work = float(0.5 * local @ (before + after))
    entry = impact.scene.contacts[touch.entry]
    rolling, spin = (getattr(entry, name) * normal for name in ("rolling", "torsion"))
    impulse, before, after = (touch.axes @ vector for vector in (local, before, after))
    lock(impulse, before, after)
    across, about = float(np.hypot(local[0], local[1])), abs(float(local[2]))
    return TurningResult(
        impulse,
        before,
        after,
        rolling=_mode(normal, across, rolling, "rolling"),
        spin=_mode(normal, about, spin, "spinning"),
        work=work,
    )


def _mode(normal: float, moment: float, limit: float, moves: str) -> str:
    if normal <= 0.0:
        return "separated"
    return "sticking" if moment < limit * (1.0 - ON_CONE) else moves
