"""Where things stand in the flat arrays of the kernels.

A value is what ``lanes`` calls one: as many doubles as states go side by side. The work
array holds, in values, one row per body (the world is row 0), then one row per degree
of freedom, then the vectors q, v and dv, then room for contacts. All vectors in it are in
world axes; spatial ones are linear before angular, about the origin of the body's joint.
"""

from __future__ import annotations

__all__ = [
    "ACCUMULATED",
    "ALONG_DOF",
    "ANGLE",
    "BLOW_FLOATS",
    "BLOW_INTS",
    "BODY",
    "BODY_FLOATS",
    "BODY_INTS",
    "CIRCLE",
    "CONTACT_FLOATS",
    "CONTACT_INTS",
    "COUPLE",
    "DOF",
    "DOF_INTS",
    "FORCE",
    "FORCE_AT",
    "FREE",
    "INVERSE",
    "JUMP",
    "OFFSET",
    "PLANAR",
    "QUATERNION",
    "ROTATION",
    "SLIDE",
    "TARGET",
    "TERM_FLOATS",
    "TERM_INTS",
    "TRANSLATION",
    "TWIST",
]

# One body: rotation (9), offset from its parent's joint (3), articulated inertia gathered
# from its children (M 6, H 9, I 6), bias impulse (6), jump of its twist (6), twist (6).
ROTATION, OFFSET, ACCUMULATED, FORCE, JUMP, TWIST, BODY = 0, 9, 12, 33, 39, 45, 51
# One degree of freedom: U = A s (6), 1/(s·U), u.
INVERSE, TARGET, DOF = 6, 7, 8

# Tables of a tree. Integers of a body: parent, kind of joint, first entry of q, first
# degree of freedom, how many, whether it has children, whether it is the first child
# that its parent hears from.
BODY_INTS = 7
# Of a degree of freedom: 0 linear or 1 angular, and along which column of the rotation.
DOF_INTS = 2
# Floats of a body: rotation (9) and offset (3) of its joint in the parent's frame,
# mass, first moment (3), inertia about the joint (xx, xy, xz, yy, yz, zz).
BODY_FLOATS = 22

# Kinds of joints.
ANGLE, CIRCLE, SLIDE, QUATERNION, FREE, PLANAR, TRANSLATION = 0, 1, 2, 3, 4, 5, 6

# Terms of rows. Integers: kind, body, the body in whose axes the direction is given (0: the
# world), degree of freedom. Floats: the point in the body's axes (3) and the direction (3),
# or a factor in place of its first entry.
FORCE_AT, COUPLE, ALONG_DOF = 0, 1, 2
TERM_INTS, TERM_FLOATS = 4, 6

# Known impulses on bodies. Integers: body, whether in the axes of its frame, first of six
# columns. Floats: the point in the body's axes (3), the axes of the frame in the body's (9).
BLOW_INTS, BLOW_FLOATS = 3, 12

# Contacts. Integers: first row, how many rows (1 without friction), entry of q of a joint
# stop or -1. Floats: the contact's axes in the world (9), limits of a stop (2), tangential
# restitution, speed below which restitution is 0.
CONTACT_INTS, CONTACT_FLOATS = 3, 13
