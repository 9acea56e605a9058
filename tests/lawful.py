"""Newton's and Coulomb's laws as they are written down: what velocities leave of them."""

from __future__ import annotations

import itertools

import mpmath
import numpy as np
import pinocchio as pin

from tests.reference.models import mass_matrix

__all__ = ["all_answers", "enumerated_normals", "left_of_coulomb", "left_of_the_law"]


def left_of_the_law(scene, q, before, after):
    """The most that v⁺ leaves of the law, relative; impulses are worked out from it alone.

    For contacts with level ground, Newton's law, slip at the end.
    """
    robot, model = scene.robot, scene.robot.model
    data = model.createData()
    masses = mass_matrix(model, q)
    pin.computeJointJacobians(model, data, q)
    rows = []
    for contact in scene.contacts:
        frame = model.frames[robot.frame_id(contact.frame)]
        place = frame.placement * pin.SE3(np.eye(3), np.array(contact.at))
        axes = pin.LOCAL_WORLD_ALIGNED
        rows.append(pin.getFrameJacobian(model, data, frame.parentJoint, place, axes)[:3])
    rows, momentum = np.vstack(rows), masses @ (after - before)
    P = np.linalg.lstsq(rows.T, momentum, rcond=None)[0]
    assert np.abs(rows.T @ P - momentum).max() < 1e-10 * np.abs(momentum).max(initial=1e-3)
    start, xi = rows @ before, rows @ after
    xi[2::3] += [c.restitution for c in scene.contacts] * np.minimum(start[2::3], 0.0)
    return left_of_coulomb(xi, P, [c.friction for c in scene.contacts], np.abs(before).max())


def left_of_coulomb(xi, P, friction, speed):
    """The most that is left of 0 ≤ P_n ⊥ ξ_n ≥ 0, |P_t| ≤ µ P_n and P_t |ξ_t| = −µ P_n ξ_t.

    Args:
        xi, P: (3n,) velocities [m/s] and impulses.
        friction: (n,). speed: of all that moves [m/s].
    """
    load, left = np.abs(P).max() or 1.0, []
    for u, p, mu in zip(xi.reshape(-1, 3), P.reshape(-1, 3), friction, strict=True):
        bound, slip = mu * p[2], np.hypot(*u[:2])
        left += [-p[2] / load, -u[2] / speed, abs(p[2] * u[2]) / (load * speed)]
        left += [(np.hypot(*p[:2]) - bound) / load]
        left += [np.abs(p[:2] * slip + bound * u[:2]).max() / (load * speed)]
    return max(left)


@mpmath.workdps(50)
def all_answers(W, b, mu):
    """Every P > 0 of Coulomb's law, in 50 digits: sticking, and slip from Bonnefon's quartic."""
    W, b, mu = mpmath.matrix(W.tolist()), mpmath.matrix(list(b)), mpmath.mpf(mu)
    found = []
    stick = -mpmath.lu_solve(W, b)
    if stick[2] > 0 and mpmath.hypot(stick[0], stick[1]) <= mu * stick[2]:
        found.append([float(p) for p in stick])
    T, w, nn = W[0:2, 0:2], W[0:2, 2], W[2, 2]
    A = mu * (b[2] * T - b[0:2] * w.T)
    c = b[0:2] * nn - b[2] * w
    trace, det = A[0, 0] + A[1, 1], A[0, 0] * A[1, 1] - A[0, 1] * A[1, 0]
    m = mpmath.matrix([A[0, 1] * c[1] - A[1, 1] * c[0], A[1, 0] * c[0] - A[0, 0] * c[1]])
    quartic = [
        1,
        -2 * trace,
        trace**2 + 2 * det - (c.T * c)[0],
        -2 * (trace * det + (c.T * m)[0]),
        det**2 - (m.T * m)[0],
    ]
    for root in mpmath.polyroots(quartic, maxsteps=300, extraprec=200):
        if abs(mpmath.im(root)) > mpmath.mpf(10) ** -30 * abs(root) or mpmath.re(root) * b[2] >= 0:
            continue
        root = mpmath.re(root)
        s = (root * c + m) / ((root - A[0, 0]) * (root - A[1, 1]) - A[0, 1] * A[1, 0])
        left = nn - mu * (w.T * s)[0]
        load = -b[2] / left
        if load > 0:
            found.append([float(-mu * load * s[0]), float(-mu * load * s[1]), float(load)])
    return found


def enumerated_normals(W, b):
    """P with 0 ≤ P ⊥ W P + b ≥ 0, by trying all sets of contacts that push."""
    n = len(b)
    for size in range(n + 1):
        for rows in map(list, itertools.combinations(range(n), size)):
            P = np.zeros(n)
            if rows:
                P[rows] = np.linalg.lstsq(W[np.ix_(rows, rows)], -b[rows], rcond=1e-10)[0]
            xi = W @ P + b
            if P.min() >= -1e-9 and xi.min() >= -1e-9 and abs(P @ xi) < 1e-8:
                return P
    raise AssertionError("no set of contacts obeys the law")
