"""The damper beside a contact's spring that gives a coefficient of restitution."""

from __future__ import annotations

import math

__all__ = ["damping_ratio", "restitution_of"]

# The largest damping ratio, where e is 1e-16, and what it is found to: rounding.
MOST_DAMPED, EXACT = 1e8, 1e-15


def restitution_of(ratio: float) -> float:
    """e of a spring with a damper that parts where its force ends, so that it never pulls.

    With ζ the damping ratio, ω = √(1 − ζ²) and the force ending at phase φ, e = exp(−ζ φ/ω),
    φ = atan2(2 ζ ω, 2 ζ² − 1); beyond critical damping the same with hyperbolic functions
    (Schwager & Pöschel 2007, "Coefficient of restitution and linear-dashpot model
    revisited"). It falls from 1 at ζ = 0 towards 0, which it never reaches.

    Example:
        >>> restitution_of(0.0)
        1.0
    """
    if ratio < 1.0:
        swing = math.sqrt(1.0 - ratio * ratio)
        phase = math.atan2(2.0 * ratio * swing, 2.0 * ratio * ratio - 1.0)
        return math.exp(-ratio / swing * phase)
    if ratio == 1.0:
        return math.exp(-2.0)
    swing = math.sqrt(ratio * ratio - 1.0)
    return math.exp(-ratio / swing * 2.0 * math.acosh(ratio))


def damping_ratio(restitution: float) -> float:
    """ζ of the damper that gives ``restitution``, in (0, 1].

    Example:
        >>> round(restitution_of(damping_ratio(0.5)), 12)
        0.5
    """
    from scipy.optimize import brentq

    if restitution == 1.0:
        return 0.0
    return float(
        brentq(lambda ratio: restitution_of(ratio) - restitution, 0.0, MOST_DAMPED, xtol=EXACT)
    )
