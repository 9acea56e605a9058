"""Where things stand in the flat arrays of the kernels.

A value is what ``lanes`` calls one: as many numbers as states go side by side. The work
array holds, in values, one row per body (the world is row 0), then one row per degree
of freedom, then what ``places`` says. What belongs to a body is in the body's own axes, in
which a single axis of its joint is z: there the inertia about the joint, however small
beside others, keeps its digits. Spatial vectors are linear before angular, about the origin
of the body's joint.
"""

from __future__ import annotations

from typing import NamedTuple

__all__ = [
    "ABOUT_X",
    "ABOUT_Z",
    "ACCUMULATED",
    "ALONG_DOF",
    "ANGLE",
    "BALL",
    "BALL_FLOATS",
    "BALL_INTS",
    "BLOW_FLOATS",
    "BLOW_INTS",
    "BODY",
    "BODY_FLOATS",
    "BODY_INTS",
    "BOX",
    "CAPSULE",
    "CIRCLE",
    "CONTACT_FLOATS",
    "CONTACT_INTS",
    "COUPLE",
    "CYLINDER",
    "DOF",
    "DOF_INTS",
    "EXPONENT",
    "FAINTEST",
    "FORCE",
    "FORCE_AT",
    "FREE",
    "GEARED_ANGLE",
    "GEARED_CIRCLE",
    "INVERSE",
    "JUMP",
    "LOAD_FLOATS",
    "LOAD_INTS",
    "MEETING",
    "MEETING_FLOATS",
    "MEETING_INTS",
    "OFFSET",
    "PLANAR",
    "QUATERNION",
    "ROTATION",
    "SHIFT",
    "SLIDE",
    "STIFFNESS",
    "TARGET",
    "TERM",
    "TERM_FLOATS",
    "TERM_INTS",
    "TRANSLATION",
    "TURN",
    "TWIST",
    "Places",
    "places",
]

# One body: to its parent's axes, cosine and sine of its own turn, or where that is not about
# z alone a rotation (9) and the offset from the parent's joint (3); where the world's axes are
# asked for, rotation to them (9) and that offset in them (3); articulated inertia gathered
# from its children (M 6, H 9, I 6), which is used up before what shares its place: bias
# impulse (6), jump of its twist (6), twist (6).
TURN, SHIFT, ROTATION, OFFSET, ACCUMULATED, BODY = 0, 9, 12, 21, 24, 45
FORCE, JUMP, TWIST = 24, 30, 36
# One degree of freedom: U = A s (6), 1/(s·U + armature), u.
INVERSE, TARGET, DOF = 6, 7, 8

# Tables of a tree. Integers of a body: parent, kind of joint, first entry of q, first
# degree of freedom, how many, whether it has children, whether it is the first child
# that its parent hears from, which of the inertias that vary is its own or -1, which turns
# are not nothing (``ABOUT_X``, ``ABOUT_Z``).
BODY_INTS = 9
ABOUT_X, ABOUT_Z = 1, 2
# Of a degree of freedom: 0 linear or 1 angular, and along which of the body's axes.
DOF_INTS = 2
# Floats of a body: rotation (9) and offset (3) of its joint in the parent's frame,
# mass, first moment (3), inertia about the joint (xx, xy, xz, yy, yz, zz). The rotation of a
# joint that turns about z alone is Rz(β) Rx(α) Rz(γ), and in its place stand cosine and sine
# of β, of α and of γ.
BODY_FLOATS = 22

# Kinds of joints. A geared joint turns about z alone and has an armature: what its freeing
# leaves of the articulated inertia has entries about z, so that it takes the general way.
ANGLE, CIRCLE, SLIDE, QUATERNION, FREE, PLANAR, TRANSLATION = 0, 1, 2, 3, 4, 5, 6
GEARED_ANGLE, GEARED_CIRCLE = 7, 8

# What every link whose mass varies adds to its body. Integers: which of the inertias that
# vary, column of the factors. Floats: as the last ten of a body.
LOAD_INTS, LOAD_FLOATS = 2, 10

# Terms of rows. Integers: kind, body, the body in whose axes the direction is given (0: the
# world), degree of freedom, the meeting whose arm is taken and the one whose axes are (-1:
# none). Floats: the point in the body's axes (3) and the direction (3), or a factor in
# place of its first entry.
FORCE_AT, COUPLE, ALONG_DOF = 0, 1, 2
TERM_INTS, TERM_FLOATS = 6, 6
# In the work array: direction (3) and arm (3), in the body's axes.
TERM = 6

# Meetings of two bodies at a point of the first. Integers: first body, other body, where the
# bodies on their ways from a common one begin and end in a list (first, other, end), whether
# there is a normal. Floats: the point in the first's axes (3), the normal in the other's (3).
MEETING_INTS, MEETING_FLOATS = 6, 6
# In the work array, in the world's axes: t₁, t₂, n as columns (9), the arm from the other's
# joint (3).
MEETING = 12

# Known impulses on bodies. Integers: body, whether in the axes of its frame, first of six
# columns. Floats: the point in the body's axes (3), the axes of the frame in the body's (9).
BLOW_INTS, BLOW_FLOATS = 3, 12

# Contacts. Integers: first row, how many rows (1 without friction), entry of q of a joint
# stop or -1, meeting that knows the axes or -1, where a table of restitution begins among
# the floats and how many points it has (0: none). Floats: the contact's axes in the world
# (9), limits of a stop (2), tangential restitution, speed below which restitution is 0, and
# under the law "lzb" stiffness and exponent; then W_nn up to which the normal's row may be zero but
# for rounding (0 for a stop).
# Behind those of all contacts: of each table the speeds, then the values. At last, which of
# the balls it is or -1; the first limit then is the gap up to which it touches.
CONTACT_INTS, CONTACT_FLOATS = 7, 16
STIFFNESS, EXPONENT, FAINTEST = 13, 14, 15

# Balls and what may touch them. Integers: the ball's body, the shape's, the first of two
# meetings, the shape's kind, 1 or -1 where the normal points away from the ball. The first
# meeting has the axes and the arm on the shape's body, the second that on the ball's. Floats:
# centre in the ball's body (3), radius, axes (9) and origin (3) of the shape in its body, sizes
# (3): half sides; radius and half length.
BALL_INTS, BALL_FLOATS = 5, 19
BALL, CAPSULE, BOX, CYLINDER = 0, 1, 2, 3


class Places(NamedTuple):
    """Where in the work array things begin, in values.

    Attributes:
        dof: degrees of freedom; q, v, dv; sum: the generalized impulse.
        spare: room for three values and two of each row.
        reduced: rows (rows, nv); delassus: W (rows, rows).
        before, free: velocities of the rows before, and without their own impulses.
        p: impulses of the rows, and behind them the gaps of balls.
        loads: inertias that vary; meeting, term: of the rows.
        end: how many values there are in all.
    """

    dof: int
    q: int
    v: int
    dv: int
    sum: int
    spare: int
    reduced: int
    delassus: int
    before: int
    free: int
    p: int
    loads: int
    meeting: int
    term: int
    end: int


def places(
    bodies: int,
    nq: int,
    nv: int,
    rows: int,
    loads: int,
    meetings: int,
    terms: int,
    balls: int = 0,
) -> Places:
    """Where in the work array things begin, in values."""
    sizes = (
        BODY * (bodies + 1), DOF * nv, nq, nv, nv, nv, 3 + 2 * rows, rows * nv, rows * rows,
        rows, rows, rows + balls, LOAD_FLOATS * loads, MEETING * meetings, TERM * terms,
    )  # fmt: skip
    found = [0]
    for size in sizes:
        found.append(found[-1] + size)
    return Places(*found[1:])
