"""Where two bodies meet: the arm to the point on each, and the axes of a plane that moves."""

from __future__ import annotations

from .algebra import cross, dot, minus, plus, put_triple, triple
from .jit import inlined
from .lanes import absolute, root, where_less, width
from .layout import BODY, MEETING, MEETING_FLOATS, MEETING_INTS, OFFSET, ROTATION
from .memory import same
from .rows import turned

__all__ = ["place_meetings"]


@inlined
def place_meetings(ints, floats, ways, work, meeting_at, witness):
    """Write axes and arm of every meeting.

    Args:
        ints, floats: see ``layout``.
        ways: bodies on the ways from common bodies to those that meet.
    """
    w = width(witness)
    zero = same(0.0, witness)
    for meeting in range(len(ints) // MEETING_INTS):
        i, f = meeting * MEETING_INTS, meeting * MEETING_FLOATS
        x, y, z = floats[f], floats[f + 1], floats[f + 2]
        arm = turned(work, (ints[i] * BODY + ROTATION) * w, w, x, y, z, witness)
        for k in range(ints[i + 2], ints[i + 3]):
            arm = plus(arm, triple(work, (ways[k] * BODY + OFFSET) * w, w, witness))
        for k in range(ints[i + 3], ints[i + 4]):
            arm = minus(arm, 1.0, triple(work, (ways[k] * BODY + OFFSET) * w, w, witness))
        to = (meeting_at + meeting * MEETING) * w
        put_triple(work, to + 9 * w, w, arm)
        if ints[i + 5] == 0:
            continue
        x, y, z = floats[f + 3], floats[f + 4], floats[f + 5]
        n = turned(work, (ints[i + 1] * BODY + ROTATION) * w, w, x, y, z, witness)
        # As ``geometry.axes.contact_axes``: the world axis most across it comes first.
        a, b, c = absolute(n[0]), absolute(n[1]), absolute(n[2])
        one = zero + 1.0
        e0 = where_less(b, a, zero, where_less(c, a, zero, one))
        e1 = where_less(0.5, e0, zero, where_less(c, b, zero, one))
        e2 = 1.0 - e0 - e1
        first = minus((e0, e1, e2), dot((e0, e1, e2), n), n)
        scale = 1.0 / root(dot(first, first))
        first = (scale * first[0], scale * first[1], scale * first[2])
        second = cross(n, first)
        put_triple(work, to, 3 * w, first)
        put_triple(work, to + w, 3 * w, second)
        put_triple(work, to + 2 * w, 3 * w, n)
