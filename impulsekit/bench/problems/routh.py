"""Routh's construction in the plane: an impact with friction, followed along its impulse.

While the normal impulse p grows, u' = W (τ, 1) with τ = dP_t/dp: −µ against the slip, or the
value that keeps a point at rest, −W_tn/W_tt, if that is within ±µ; beyond, slip starts again
the other way. Compression ends where u_n = 0, restitution where its work is e² of that of
compression (Stronge 1990). Between such events all is linear in p, and works are quadratic.
"""

from __future__ import annotations

from typing import Any

__all__ = ["end_of_path"]


def end_of_path(w: tuple[Any, Any, Any], u: tuple[Any, Any], mu: Any, e: Any) -> tuple[Any, Any]:
    """(P_t, P_n) at the end, in the numbers that are given.

    Args:
        w: W as (tt, tn, nn).
        u: velocity (t, n) before, with u_n < 0.
        mu, e: friction and restitution.

    Raises:
        ArithmeticError: the normal velocity does not rise: friction jams the contact.
    """
    slip, normal = u
    p_t = p_n = spent = regained = 0 * normal
    pressing = True
    while True:
        ratio = _ratio(w, slip, mu)
        slope_t, slope_n = w[1] + w[0] * ratio, w[2] + w[1] * ratio
        if not slope_n > 0:
            raise ArithmeticError("the contact jams")
        stop = -slip / slope_t if slip * slope_t < 0 else None
        if pressing:
            end = -normal / slope_n
        else:
            # normal · d + slope · d²/2 = what is still to be regained
            missing = e * e * -spent - regained
            end = (-normal + (normal * normal + 2 * slope_n * missing) ** 0.5) / slope_n
        step = end if stop is None or end <= stop else stop
        work = normal * step + slope_n * step * step / 2
        p_n, p_t = p_n + step, p_t + ratio * step
        slip = 0 * slip if step == stop else slip + slope_t * step
        normal = normal + slope_n * step
        if pressing:
            spent = spent + work
        else:
            regained = regained + work
        if step == end:
            if not pressing:
                return p_t, p_n
            pressing, normal = False, 0 * normal


def _ratio(w: tuple[Any, Any, Any], slip: Any, mu: Any) -> Any:
    """dP_t/dP_n."""
    if slip > 0:
        return -mu
    if slip < 0:
        return mu
    rest = -w[1] / w[0]
    return max(-mu, min(mu, rest))
