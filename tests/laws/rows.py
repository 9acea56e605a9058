"""Contacts with a Delassus matrix of one's own, as a scene: unit masses on slides, touched in rows.

W = J Jᵀ and u = J v of a robot of unit masses, with a ``GapContact`` for each three rows of J.
"""

from __future__ import annotations

from functools import cache

import numpy as np

import impulsekit as ik

__all__ = [
    "block", "box_rows", "in_own_rows", "rod", "solved", "solved_rows",
    "sphere", "turned",
]  # fmt: skip


@cache
def slides(count: int) -> ik.Robot:
    """Unit masses, each free along its own line."""
    inertia = '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
    parts = "".join(
        f'<link name="m{i}"><inertial><mass value="1"/>{inertia}</inertial></link>'
        f'<joint name="s{i}" type="prismatic"><parent link="rail"/><child link="m{i}"/>'
        '<axis xyz="1 0 0"/><limit lower="-1e9" upper="1e9" effort="1e9" velocity="1e9"/></joint>'
        for i in range(count)
    )
    return ik.Robot.from_urdf(f'<robot name="slides"><link name="rail"/>{parts}</robot>')


def solved_rows(
    J, v, e=0.0, mu=0.0, e_t=0.0, *, blow=None, law=None, stiffness=1.0, kept=0
) -> ik.Impact:
    """The impact of contacts with rows J (3n, nv), two tangents before each normal.

    Args:
        e, mu, e_t, stiffness: one for all contacts, or one each.
        blow: (nv,) Δv by known impulses at the same instant.
        kept: how many of the last slides keep their speed.
    """
    J, v = np.asarray(J, dtype=float), np.asarray(v, dtype=float)
    n = len(J) // 3
    e, mu, e_t, stiffness = (np.broadcast_to(x, n) for x in (e, mu, e_t, stiffness))
    contacts = [
        ik.GapContact(
            lambda q, row=J[3 * i + 2]: row @ q,
            lambda q, row=J[3 * i + 2]: row,
            lambda q, rows=J[3 * i : 3 * i + 2]: rows,
            restitution=float(e[i]),
            friction=float(mu[i]),
            tangential_restitution=float(e_t[i]),
            stiffness=float(stiffness[i]),
        )
        for i in range(n)
    ]
    robot = slides(len(v))
    given = np.zeros(len(v)) if blow is None else np.asarray(blow, dtype=float)
    kicks = [ik.JointImpulse(f"s{i}", x) for i, x in enumerate(given) if x]
    held = [f"s{i}" for i in range(len(v) - kept, len(v))]
    scene = ik.Scene(robot, kicks, contacts=contacts, law=law or ik.Law(), controlled=held)
    return ik.solve(scene, np.zeros(len(v)), v)


def solved(W, before, e=0.0, mu=0.0, e_t=0.0, free=None, law=None) -> tuple[ik.Impact, np.ndarray]:
    """The impact of contacts with W (3n, 3n) and u⁻ (3n,) in its range, and u⁺."""
    values, axes = np.linalg.eigh(np.asarray(W, dtype=float))
    kept = values > 1e-13 * values.max()
    J, inverse = axes[:, kept] * np.sqrt(values[kept]), axes[:, kept] / np.sqrt(values[kept])
    v = inverse.T @ np.asarray(before, dtype=float)
    blow = None if free is None else inverse.T @ (np.asarray(free) - before)
    impact = solved_rows(J, v, e, mu, e_t, blow=blow, law=law)
    return impact, J @ impact.v_after


def in_own_rows(impact: ik.Impact) -> np.ndarray:
    """(3n,) the impulses, in the rows' own units."""
    return np.concatenate([contact.impulse for contact in impact.contacts])


def rod(theta: float, m: float = 1.3, length: float = 0.8) -> np.ndarray:
    """W of the lower end of a uniform rod at ``theta`` from the horizontal; rows t, none, n.

    The end lies at L/2 (−cos θ, −sin θ) from the centre; inertia m L²/12.
    """
    x, y = -0.5 * length * np.cos(theta), -0.5 * length * np.sin(theta)
    J = np.array([[1.0, 0.0, -y], [0.0, 0.0, 0.0], [0.0, 1.0, x]])
    return J @ np.diag([1 / m, 1 / m, 12 / (m * length**2)]) @ J.T


def sphere(m: float = 1.0) -> np.ndarray:
    """W of a solid sphere on a plane."""
    return np.diag([3.5, 3.5, 1.0]) / m


def box_rows(half=(0.3, 0.2, 0.1), m=2.0) -> np.ndarray:
    """(12, 6) rows of a box on the four corners of its lower face, of unit masses."""
    a, b, c = half
    inertia = m / 3 * np.array([b * b + c * c, a * a + c * c, a * a + b * b])
    rows = []
    for x in (-a, a):
        for y in (-b, b):
            rows.append(np.hstack([np.eye(3), np.cross(np.eye(3), [x, y, -c])]))
    return np.vstack(rows) / np.sqrt(np.r_[m, m, m, inertia])


def block(rng, dof=None) -> np.ndarray:
    """W of one contact of random inertia, its rank at most ``dof``."""
    rows = rng.normal(size=(3, dof or rng.integers(3, 7))) * np.exp(0.5 * rng.normal(size=(3, 1)))
    return rows @ rows.T


def turned(rng, n: int) -> np.ndarray:
    """(3n, 3n) tangents turned and mirrored, contacts in another order."""
    basis = np.zeros((3 * n, 3 * n))
    for place, i in enumerate(rng.permutation(n)):
        c, s = np.cos(angle := rng.uniform(0, 7)), np.sin(angle)
        mirror = np.diag([1, rng.choice([-1, 1])])
        basis[3 * place : 3 * place + 2, 3 * i : 3 * i + 2] = [[c, -s], [s, c]] @ mirror
        basis[3 * place + 2, 3 * i + 2] = 1.0
    return basis
