"""Impacts along the path by very many small steps: slow, and with nothing of the solver in it."""

import math


def fine_path(W, u, mu, e, steps=1_000_000):
    """{restitution: u⁺} of one contact, the last to end in about so many steps.

    Midpoint rule in the normal impulse p while it slips; where a step would reverse the
    slip, it has stopped on the way. Only where friction can hold it then.
    """
    rough = 1e-3 * -u[2] / W[2][2]
    _, length = stepped(W, u, mu, e, rough)
    return stepped(W, u, mu, e, length / steps)[0]


def stepped(W, u, mu, e, h):
    """({restitution: u⁺}, p at the end) with steps of h."""
    (t11, t12, n1), (_, t22, n2), (_, _, nn) = [[float(x) for x in row] for row in W]
    u1, u2, un = (float(x) for x in u)
    start = un
    det = t11 * t22 - t12 * t12
    k1, k2 = (t12 * n2 - t22 * n1) / det, (t12 * n1 - t11 * n2) / det
    if math.hypot(k1, k2) > mu:
        raise ValueError("slip that starts again is not followed here")
    held = nn + n1 * k1 + n2 * k2
    found = {}
    p, work, pressed, spent = 0.0, 0.0, math.inf, -math.inf
    slips = True
    whole, slow = h, 1e-3 * math.hypot(u1, u2)
    while len(found) < 3:
        h = whole
        if slips:
            r = math.hypot(u1, u2)
            # Where slip is slow it turns fast.
            h = whole if r > slow else 0.01 * whole
            s1, s2 = u1 / r, u2 / r
            m1 = u1 + 0.5 * h * (n1 - mu * (t11 * s1 + t12 * s2))
            m2 = u2 + 0.5 * h * (n2 - mu * (t12 * s1 + t22 * s2))
            r = math.hypot(m1, m2)
            s1, s2 = m1 / r, m2 / r
            v1 = u1 + h * (n1 - mu * (t11 * s1 + t12 * s2))
            v2 = u2 + h * (n2 - mu * (t12 * s1 + t22 * s2))
            vn = un + h * (nn - mu * (n1 * s1 + n2 * s2))
            if v1 * u1 + v2 * u2 <= 0.0:
                slips = False
                share = math.hypot(u1, u2) / (math.hypot(u1, u2) + math.hypot(v1, v2))
                v1, v2, vn = 0.0, 0.0, un + share * (vn - un) + (1 - share) * h * held
        else:
            v1, v2, vn = 0.0, 0.0, un + h * held
        gained = 0.5 * h * (un + vn)
        # Shares of this step at which compression or one of the laws ends.
        ends = {}
        if pressed == math.inf and vn >= 0.0:
            share = -un / (vn - un)
            pressed, spent = p + share * h, work + 0.5 * share * h * un
        if pressed < math.inf:
            if vn >= -e * start:
                ends["newton"] = (-e * start - un) / (vn - un)
            if p + h >= (1 + e) * pressed:
                ends["poisson"] = ((1 + e) * pressed - p) / h
            if work + gained >= (1 - e * e) * spent:
                ends["stronge"] = ((1 - e * e) * spent - work) / gained
            for name, share in ends.items():
                if name not in found:
                    found[name] = tuple(
                        a + share * (b - a) for a, b in zip((u1, u2, un), (v1, v2, vn), strict=True)
                    )
        u1, u2, un, p, work = v1, v2, vn, p + h, work + gained
    return found, p
