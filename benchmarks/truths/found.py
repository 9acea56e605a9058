"""What a method answered, and what it is held against."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from impulsekit.reference.arithmetic import Array


@dataclass(frozen=True, eq=False)
class Found:
    """An answer in doubles.

    Attributes:
        dv: (n,) the velocity jump; None where an error was raised instead.
        rows: (r,) the impulses of the bilateral rows, NaN where they are not determined;
            None where not asked for.
        contacts: for each contact (3,) in world axes, or (1,) of a joint stop; None likewise.
        contacts_unique: for each contact, whether its impulse is determined.
        places: (3,) of each of ``contacts`` in the world [m], where these are the points of
            collisions; None otherwise.
        status: the name of the status or of the error.
        valid: whether it says that the numbers may be used.
        seconds: how long it took.
    """

    dv: np.ndarray | None
    status: str
    valid: bool
    seconds: float
    rows: np.ndarray | None = None
    contacts: tuple[np.ndarray, ...] | None = None
    contacts_unique: tuple[bool, ...] | None = None
    places: tuple[np.ndarray, ...] | None = None


@dataclass(frozen=True, eq=False)
class Exact:
    """The answer in 50 digits, and how far a change of the data moves it.

    Attributes:
        dv: (n,) the velocity jump.
        slack: (n,) by how much relative changes of the data, of size 1, move dv to first
            order: the condition of each component, times it.
        weights: (n,) the fastest that a unit of each speed moves matter: velocities in m/s.
        impulses, impulses_slack: (m,) of rows and contacts, in the truth's own order and
            axes; None where there are none.
        impulses_weights: (m,) which make impulses of any unit comparable.
        determined: whether the impulses are the only ones.
        violation: what is left of the law's inequalities, in units of eps times what rounding
            may do; 0 but where modes of redundant contacts had to be kept.
        before: (n,) the velocity before where v⁺ is what was asked for: then errors are
            relative to it, too.
        only: False where the law has other answers too; then a status has to say so.
    """

    dv: Array
    slack: Array
    weights: Array
    impulses: Array | None = None
    impulses_slack: Array | None = None
    impulses_weights: Array | None = None
    determined: bool = True
    violation: float = 0.0
    before: Array | None = None
    only: bool = True

    @property
    def scale(self) -> Any:
        """The largest speed at hand, as a velocity of matter [m/s]."""
        largest = np.max(self.weights * np.abs(self.dv))
        if self.before is None:
            return largest
        return max(largest, np.max(self.weights * np.abs(self.before)))

    @property
    def condition(self) -> float:
        """Relative change of the answer for a relative change of the data."""
        scale = self.scale
        return max(1.0, float(np.max(self.weights * self.slack) / scale)) if scale > 0 else 1.0
