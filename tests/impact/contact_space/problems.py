"""Contact problems with known answers, and random ones."""

import numpy as np

from impulsekit.impact.contact_law import ContactProblem, ContactSolution, solve_contacts
from impulsekit.scene.law import Law
from tests.truths.planar import planar_impulses


def problem(W, before, e=0.0, mu=0.0, e_t=0.0, free=None) -> ContactProblem:
    """A problem; coefficients are one for all contacts, or one each."""
    before = np.array(before, dtype=float)
    n = len(before) // 3
    e, mu, e_t = (np.broadcast_to(np.asarray(c, float), n).copy() for c in (e, mu, e_t))
    free = before if free is None else np.array(free, dtype=float)
    return ContactProblem(np.array(W, dtype=float), before, free, e, mu, e_t)


def solved(W, before, e=0.0, mu=0.0, e_t=0.0, free=None, law=None) -> ContactSolution:
    return solve_contacts(problem(W, before, e, mu, e_t, free), law or Law())


def rod(theta, m=1.3, length=0.8):
    """W of the lower end of a uniform rod at ``theta`` from the horizontal; rows t, none, n.

    The end lies at L/2 (−cos θ, −sin θ) from the centre; inertia m L²/12.
    """
    x, y = -0.5 * length * np.cos(theta), -0.5 * length * np.sin(theta)
    J = np.array([[1.0, 0.0, -y], [0.0, 0.0, 0.0], [0.0, 1.0, x]])
    return J @ np.diag([1 / m, 1 / m, 12 / (m * length**2)]) @ J.T


def planar_velocity(W, u, e, mu, law):
    """(2,) u⁺ of the tangent and the normal after an impact along its path, by Routh's diagram."""
    data = (W[0, 0], W[0, 2], W[2, 2], u[0], u[2])
    (impulse,) = planar_impulses(data, e, mu, law, "path")
    plane = [0, 2]
    return u[plane] + W[np.ix_(plane, plane)] @ np.array(impulse, dtype=float)


def sphere(m=1.0):
    """W of a solid sphere on a plane."""
    return np.diag([3.5, 3.5, 1.0]) / m


def box(half=(0.3, 0.2, 0.1), m=2.0):
    """(J, M⁻¹) of a box on the four corners of its lower face: 12 rows of rank 6."""
    a, b, c = half
    inertia = m / 3 * np.array([b * b + c * c, a * a + c * c, a * a + b * b])
    rows = []
    for x in (-a, a):
        for y in (-b, b):
            r = np.array([x, y, -c])
            skew = np.array([[0, -r[2], r[1]], [r[2], 0, -r[0]], [-r[1], r[0], 0]])
            rows.append(np.hstack([np.eye(3), -skew]))
    return np.vstack(rows), np.diag(1 / np.r_[m, m, m, inertia])


def normals(Wn, un):
    """(W, u) with the given normal parts and no tangents."""
    n = len(un)
    W, u = np.zeros((3 * n, 3 * n)), np.zeros(3 * n)
    W[2::3, 2::3], u[2::3] = Wn, un
    return W, u


def block(rng, dof=None):
    """W of one contact of random inertia, its rank at most ``dof``."""
    rows = rng.normal(size=(3, dof or rng.integers(3, 7))) * np.exp(0.5 * rng.normal(size=(3, 1)))
    return rows @ rows.T
