"""Impacts along the path by very many small steps: slow, and with nothing of the solver in it."""

import math


def fine_path(W, u, mu, e, steps=1_000_000):
    """{law: u⁺} of one contact.

    Midpoint rule in the normal impulse p while it slips; where a step would reverse the
    slip, it has stopped on the way.
    """
    (t11, t12, n1), (_, t22, n2), (_, _, nn) = [[float(x) for x in row] for row in W]
    u1, u2, un = (float(x) for x in u)
    start, speed0 = un, math.hypot(u1, u2)
    det = t11 * t22 - t12 * t12
    k1, k2 = (t12 * n2 - t22 * n1) / det, (t12 * n1 - t11 * n2) / det
    holds = math.hypot(k1, k2) <= mu
    assert holds, "slip that starts again is not followed here"
    # Some three times what it takes without friction.
    h = 3.0 * (1 + e) * -un / (nn - (n1 * n1 * t22 - 2 * n1 * n2 * t12 + n2 * n2 * t11) / det)
    h /= steps
    found = {}
    p, work, pressed, spent = 0.0, 0.0, math.inf, -math.inf
    slips = speed0 > 0
    while len(found) < 3:
        if slips:
            r = math.hypot(u1, u2)
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
                v1, v2, vn = 0.0, 0.0, un + share * (vn - un)
                vn += (1.0 - share) * h * (nn + n1 * k1 + n2 * k2)
        else:
            v1, v2, vn = 0.0, 0.0, un + h * (nn + n1 * k1 + n2 * k2)
        gained = 0.5 * h * (un + vn)

        def at(share, v1=v1, v2=v2, vn=vn):
            return (u1 + share * (v1 - u1), u2 + share * (v2 - u2), un + share * (vn - un))

        if pressed == math.inf and vn >= 0.0:
            share = -un / (vn - un)
            pressed, spent = p + share * h, work + 0.5 * share * h * un
        if pressed < math.inf:
            if "newton" not in found and vn >= -e * start:
                found["newton"] = at((-e * start - un) / (vn - un))
            if "poisson" not in found and p + h >= (1 + e) * pressed:
                found["poisson"] = at(((1 + e) * pressed - p) / h)
            if "stronge" not in found and work + gained >= (1 - e * e) * spent:
                found["stronge"] = at(((1 - e * e) * spent - work) / gained)
        u1, u2, un, p, work = v1, v2, vn, p + h, work + gained
    return found
