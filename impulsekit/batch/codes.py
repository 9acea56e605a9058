"""How single rows of a batch are to be taken, as small numbers in an array."""

from __future__ import annotations

import enum

from ..impact.status import Status

__all__ = ["AGAIN", "RowStatus"]

# In a kernel: the row is left to the solver of single states.
AGAIN = -1


class RowStatus(enum.IntEnum):
    """The state of one row. Those that ``Status`` has are the same, by name.

    Example:
        >>> RowStatus(0).valid, RowStatus.NOT_FINITE.valid
        (True, False)
    """

    SOLVED = 0
    INACCURATE = 1
    NOT_UNIQUE = 2
    PAINLEVE_JAM = 3
    ENERGY_GAIN = 4
    MANY_SOLUTIONS = 5
    NO_SOLUTION = 6
    NOT_CONVERGED = 7
    SEQUENCE_TOO_LONG = 8
    NOT_FINITE = 9
    OFF_MANIFOLD = 10
    OUT_OF_RANGE = 11
    SINGULAR_MASS = 12
    CONTRADICTION = 13
    REFUSED = 14
    NEARLY_DEPENDENT = 15

    @classmethod
    def of(cls, status: Status) -> RowStatus:
        """The row's status for that of an ``Impact``."""
        return cls[status.name]

    @property
    def valid(self) -> bool:
        """Whether the numbers of the row may be used."""
        return self.name in Status.__members__ and Status[self.name].valid

    @property
    def sentence(self) -> str:
        """What it means, with advice."""
        return _SENTENCES.get(self.name) or Status[self.name].value


_SENTENCES = {
    "NOT_FINITE": "The row holds a NaN or an infinity; nothing was solved.",
    "OFF_MANIFOLD": "A quaternion or (cosine, sine) pair of the row is off unit length by more "
    "than 1e-6; nothing was solved. Normalize the configuration.",
    "OUT_OF_RANGE": "A coefficient of the row is out of range: restitution is 0 to 1, friction "
    "0 or more; nothing was solved.",
    "SINGULAR_MASS": "The mass matrix is singular at this state: a joint moves nothing that has "
    "mass or inertia.",
    "CONTRADICTION": "Bilateral rows are dependent at this state and demand different things.",
    "REFUSED": "The contact law refuses this state; solve it alone to read why.",
}
