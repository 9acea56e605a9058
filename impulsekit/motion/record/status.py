"""Statuses of a motion's end."""

from __future__ import annotations

import enum

__all__ = ["MotionStatus"]


class MotionStatus(enum.Enum):
    """The status of a motion's end, a sentence with advice. The part computed until then is kept.

    Example:
        >>> MotionStatus.FINISHED.value, MotionStatus.FINISHED.finished
        ('The motion was followed to its end.', True)
    """

    FINISHED = "The motion was followed to its end."
    EVENT_STORM = (
        "The motion was stopped: max_impacts, the largest number of impacts, was reached. Contacts "
        "that keep bouncing (restitution near 1, or growing as speed falls) may never settle: "
        "lower the restitution, raise capture_speed, or raise max_impacts."
    )
    TOO_MANY_STEPS = (
        "The motion was stopped: max_steps, the largest number of steps, was reached, or is far "
        "from enough. Springs that are too stiff, friction that keeps switching, very high speeds, "
        'or a small step or max_step need many: use method="radau", lower the stiffness, or raise '
        "max_steps."
    )
    STEP_TOO_SMALL = (
        "The motion was stopped: no step is short enough for the tolerance. A force jumps or "
        "grows without bound here; look at the forces of the scene, or raise rtol."
    )
    NOT_FINITE = (
        "The motion was stopped: an acceleration is infinite or not a number. A force grows "
        "without bound, or a joint moves no inertia; look at the forces of the scene."
    )
    IMPACT_NOT_VALID = (
        "The motion was stopped: an impact has no valid solution; detail and the last of "
        "trajectory.impacts say why."
    )
    INTERRUPTED = (
        "The motion was interrupted (Ctrl-C); what was computed until then is kept. Call simulate "
        "again from its last state to go on."
    )
    CONTRADICTION = (
        "The motion was stopped: the constraints cannot hold together from here on, or the robot "
        "has come to a configuration at which they lose their rank."
    )
    REST_NOT_SOLVED = (
        "The motion was stopped: no forces at the resting contacts satisfy Coulomb's law. "
        "Friction jams a contact (Painlevé); lower the friction coefficient."
    )

    PENETRATION = (
        "The motion was stopped before a step that presses a contact in deeper than can be true; "
        "detail names it. Round bodies and meshes with very many edges may come to this, whose "
        "distance is known to 1e-7 m only: start a little elsewhere, or give points of one on "
        "planes of the other as Contacts."
    )

    REFUSED = (
        "The motion was refused before it began: its state, coefficients or masses cannot be used; "
        "detail says why. Only rows of a batch have this, simulate raises the error."
    )

    @property
    def code(self) -> int:
        """A small whole number, for arrays: its place among all."""
        return list(type(self)).index(self)

    @property
    def finished(self) -> bool:
        """True if the motion was followed to its end."""
        return self is MotionStatus.FINISHED
