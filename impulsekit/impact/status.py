"""The status of a result: one enum, for single states and for rows of batches."""

from __future__ import annotations

import enum
from typing import Any

from .._core import Status as Code

__all__ = ["BY_CODE", "Status"]


class Status(int, enum.Enum):
    """The status of a result: a sentence with advice as its value, and an integer code.

    Where an integer is expected it acts as its code: it compares with the ``status`` of a
    batch, and ``Status(code)`` returns the member.

    Example:
        >>> int(Status.ENERGY_GAIN), Status(4).name, Status.NOT_FINITE.valid
        (4, 'ENERGY_GAIN', False)
    """

    def __new__(cls, code: int, sentence: str = "") -> Status:
        """A member of this code, whose value is the sentence."""
        member = int.__new__(cls, code)
        member._value_ = sentence
        return member

    def __repr__(self) -> str:
        """As an enum has it; an integer's own would not take the sentence."""
        return f"<{type(self).__name__}.{self.name}: {self.value!r}>"

    SOLVED = (
        Code.solved,
        "Residuals are at machine precision.",
    )
    INACCURATE = (
        Code.inaccurate,
        "Residuals are above machine precision: masses or lengths in this scene span too many "
        "orders of magnitude for double precision. See impact.residuals and rescale the model.",
    )
    ENERGY_GAIN = (
        Code.energy_gain,
        "Contacts and constraints increase the kinetic energy, as Newton's and Poisson's laws can "
        "with friction (Kane & Levinson 1985), and Newton's where constraints change velocities "
        'at the same instant. Use Law(restitution="stronge", slip="path"), or lower e.',
    )
    NO_SOLUTION = (
        Code.no_solution,
        "No impulse satisfies the contact law at this state: friction jams the contact (Painlevé), "
        "or the restitutions of opposing contacts contradict each other. Lower friction or "
        'restitution, or use Law(restitution="poisson").',
    )
    NOT_CONVERGED = (
        Code.not_converged,
        "The contact solver did not converge to the residual limit; the numbers shown are its last "
        "iterate, do not use them. Lower the friction, or leave out redundant contacts.",
    )
    NOT_FINITE = (
        Code.not_finite,
        "The row contains NaN or infinity; it was not solved.",
    )
    OFF_MANIFOLD = (
        Code.off_manifold,
        "A quaternion or (cosine, sine) pair of the row is off unit length by more "
        "than 1e-6; it was not solved. Normalize the configuration.",
    )
    OUT_OF_RANGE = (
        Code.out_of_range,
        "A number of the row is out of range: restitution must be 0 to 1, friction >= 0, "
        "velocities at contacts and constraints below 1e153; it was not solved.",
    )
    SINGULAR_MASS = (
        Code.singular_mass,
        "The mass matrix is singular at this state: a joint moves no mass and no inertia.",
    )
    CONTRADICTION = (
        Code.contradiction,
        "Contradictory constraints: their rows are linearly dependent at this state, with "
        "different target velocities.",
    )
    REFUSED = (
        Code.refused,
        "The contact law does not accept this state; solve it alone for the error message.",
    )
    NEARLY_DEPENDENT = (
        Code.nearly_dependent,
        "Valid if these rows are meant to be dependent. Some rows of constraints or contacts are "
        "linearly dependent within 1e-7; the difference is treated as an inaccuracy of the model "
        "and not imposed. Do not use this result near a singular pose, such as an almost straight "
        "arm: move away from it, or leave rows out.",
    )

    @classmethod
    def _missing_(cls, value: object) -> Any:
        # numpy's integers are none of Python's.
        return next((status for status in cls if int(status) == value), None)

    def __bool__(self) -> bool:
        """Always true, the first code too."""
        return True

    @property
    def code(self) -> int:
        """The integer that stands for it in arrays."""
        return int(self)

    @property
    def sentence(self) -> str:
        """The status as a sentence with advice."""
        return str(self.value)

    @property
    def valid(self) -> bool:
        """True if the numbers may be used."""
        return self in _VALID

    @property
    def obeys_law(self) -> bool:
        """True if the numbers satisfy the law of contact, valid or not."""
        return self in _VALID or self is Status.ENERGY_GAIN


# A status by its code, where that is looked up often.
BY_CODE = {int(status): status for status in Status}
_VALID = frozenset({Status.SOLVED, Status.NEARLY_DEPENDENT})
