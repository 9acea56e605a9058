"""Redundant contacts that slip share their load as equally stiff springs would."""

from __future__ import annotations

import itertools

import numpy as np
import pinocchio as pin
import pytest
from scipy.optimize import root

import impulsekit as ik
from impulsekit.impact.contact_law import ContactProblem, solve_contacts

CORNERS = [(x, y, -0.05) for x in (-0.15, 0.15) for y in (-0.1, 0.1)]
# No normal of a face moves for loads along it.
SHIFT = np.array([1.0, -1.0, -1.0, 1.0])
MU = 0.4


def box():
    return ik.Robot.from_urdf("models/box.urdf", root="freeflyer")


def corner_contacts(order=range(4), link="box", e=0.0, prefix="corner"):
    return [
        ik.Contact(
            link,
            at=CORNERS[i],
            normal=[0, 0, 1],
            origin=[0, 0, -0.05],
            restitution=e,
            friction=MU,
            name=f"{prefix} {i}",
        )
        for i in order
    ]


def falls(count, seed=0):
    """Velocities of flat bodies that slide, turn and come down."""
    v = 0.3 * np.random.default_rng(seed).normal(size=(count, 6))
    v[:, 2] = -0.1 - abs(v[:, 2])
    return v


def loads_of(impact):
    return np.array([impact.contacts[f"corner {i}"].impulse[2] for i in range(4)])


def by_springs(robot, v, e=0.0):
    """v⁺ and loads of four corners that all slide, from the statement of the law alone.

    Unknown are v⁺ (6,) and the loads (4,); given momentum, three normal velocities, and that the
    loads have no part along the shift (all corners are moved alike by their normals).
    """
    inertia = robot.model.inertias[1]
    mass = np.diag([inertia.mass] * 3 + list(inertia.inertia.diagonal()))
    points = np.array(CORNERS)
    target = -e * np.minimum([v[2] + np.cross(v[3:], p)[2] for p in points], 0.0)

    def off(x):
        after, loads = x[:6], x[6:]
        speed = after[:3] + np.cross(after[3:], points)
        slip = speed[:, :2] / np.linalg.norm(speed[:, :2], axis=1)[:, None]
        forces = np.column_stack([-MU * loads[:, None] * slip, loads])
        pull = np.concatenate([forces.sum(0), np.cross(points, forces).sum(0)])
        return np.concatenate(
            [mass @ (after - v) - pull, (speed[:, 2] - target)[:3], [SHIFT @ loads]]
        )

    return root(off, np.concatenate([v * [1, 1, 0, 0, 0, 1], np.full(4, 0.1)]), tol=1e-14).x


def test_four_corners_that_slip_are_as_on_equal_springs():
    robot = box()
    scene = ik.Scene(robot, contacts=corner_contacts(e=0.2))
    judged = 0
    for v in falls(30):
        impact = ik.solve(scene, robot.neutral(), v)
        if any(contact.mode != "sliding" for contact in impact.contacts):
            continue
        # Mobilities of the four normals are equal, the box being even.
        truth = by_springs(robot, v, 0.2)
        if (truth[6:] <= 0.0).any():
            continue
        judged += 1
        assert impact.v_after == pytest.approx(truth[:6], abs=1e-9)
        assert loads_of(impact) == pytest.approx(truth[6:], abs=1e-8)
    assert judged >= 15


def test_other_shares_are_told_with_their_velocities():
    robot = box()
    scene = ik.Scene(robot, contacts=corner_contacts(e=0.2))
    for v in falls(10):
        impact = ik.solve(scene, robot.neutral(), v)
        if any(contact.mode != "sliding" for contact in impact.contacts):
            continue
        told = impact.uniqueness
        assert impact.is_valid() and told.several
        assert not any(contact.unique for contact in impact.contacts)
        assert told.others
        for other in told.others:
            # What the normals ask for is met by all: rise and tilt are theirs.
            change = other - impact.v_after
            assert np.abs(change[[2, 3, 4]]).max() < 1e-13
            assert np.abs(change).max() > 1e-6


def points_of_face(kind, count):
    """(n, 3) points of the lower face of a block, 0.2 m below its centre."""
    if kind == "ring":
        angle = 2.0 * np.pi * (np.arange(count) + 0.5) / count
        flat = 0.3 * np.column_stack([np.cos(angle), np.sin(angle)])
    elif kind == "grid":
        side = int(np.ceil(np.sqrt(count)))
        flat = np.array(list(itertools.product(range(side), repeat=2))[:count], dtype=float)
        flat = 0.1 * (flat - flat.mean(0))
    else:
        flat = np.random.default_rng(count).uniform(-0.3, 0.3, (count, 2))
    return np.column_stack([flat, np.full(count, -0.2)])


@pytest.mark.parametrize("mu", [0.1, 0.4])
@pytest.mark.parametrize("kind", ["ring", "grid", "random"])
@pytest.mark.parametrize("count", [9, 16])
def test_many_points_are_as_a_bed_of_springs_that_cannot_pull(count, kind, mu):
    """By its own mobility each gives way as a plane does, or would have to pull, and has no load.

    Off by up to a tenth of the largest load where some had none, and other in another order.
    """
    robot, points = box(), points_of_face(kind, count)
    mass, inertia = robot.model.inertias[1].mass, robot.model.inertias[1].inertia.diagonal()
    mobility = 1.0 / mass + points[:, 1] ** 2 / inertia[0] + points[:, 0] ** 2 / inertia[1]
    plane = np.column_stack([np.ones(count), points[:, :2]])
    q = robot.configuration(root_joint=[0, 0, 0.2, 0, 0, 0, 1])
    order = np.random.default_rng(1).permutation(count)
    rng, unloaded, judged = np.random.default_rng(count), 0, 0
    for _ in range(6):
        v = rng.normal(size=6) * [1.0, 1.0, 0.3, 0.3, 0.3, 2.0] - [0, 0, 1.5, 0, 0, 0]
        found = []
        for way in (np.arange(count), order):
            contacts = [ik.Contact("box", at=points[i], restitution=0.3, friction=mu) for i in way]
            impact = ik.solve(ik.Scene(robot, contacts=contacts), q, v)
            loads = np.empty(count)
            loads[way] = [contact.impulse[2] for contact in impact.contacts]
            found.append((impact, loads))
        (impact, loads), (again, others) = found
        assert again.v_after == pytest.approx(impact.v_after, abs=1e-8)
        assert others == pytest.approx(loads, abs=1e-7 * loads.max())
        at = [contact.at for contact in impact.scene.contacts]
        slips = [np.hypot(*impact.velocity_at("box", point).after[:2]) for point in at]
        if min(slip for slip, load in zip(slips, loads, strict=True) if load > 0.0) < 1e-3:
            continue
        judged += 1
        pressed = loads > 1e-7 * loads.max()
        unloaded += int((~pressed).sum())
        give, *_ = np.linalg.lstsq(plane[pressed], (mobility * loads)[pressed], rcond=None)
        size = (mobility * loads).max()
        assert plane[pressed] @ give == pytest.approx((mobility * loads)[pressed], abs=1e-7 * size)
        assert (plane[~pressed] @ give < 1e-7 * size).all()
    assert judged >= 2
    assert unloaded or kind == "ring" or mu < 0.2


def test_what_a_contact_shares_does_not_depend_on_its_tangents():
    """A point that two directions of motion alone move, its tangents turned by any angle."""
    rng = np.random.default_rng(3)
    one = np.ones(1)
    for _ in range(20):
        rows, v = rng.normal(size=(3, 2)), rng.normal(size=2)
        v *= -np.sign(rows[2] @ v)
        found = []
        for angle in (0.0, *rng.uniform(0.0, 2.0 * np.pi, 3)):
            c, s = np.cos(angle), np.sin(angle)
            turn = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
            J = turn @ rows
            problem = ContactProblem(J @ J.T, J @ v, J @ v, 0.7 * one, 0.9 * one, 0.0 * one)
            solution = solve_contacts(problem, ik.Law("poisson"))
            assert solution.status.obeys_law
            found.append(turn.T @ solution.impulse)
        assert np.ptp(found, axis=0).max() < 1e-9 * np.abs(found).max()


def two_tilted_feet(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """W (24, 24) of two bodies on four corners each, coupled with each other, and u⁻ of a fall."""
    rows = np.zeros((24, 12))
    for foot in range(2):
        turn = pin.exp3(rng.normal(size=3) * 0.1)
        corners = [turn @ [x, y, -0.1] for x in (-0.1, 0.1) for y in (-0.06, 0.06)]
        for k, at in enumerate(corners):
            own = slice(12 * foot + 3 * k, 12 * foot + 3 * k + 3)
            rows[own, 6 * foot : 6 * foot + 6] = np.hstack([np.eye(3), -pin.skew(at)])
    root = np.eye(12) + 0.2 * rng.normal(size=(12, 12))
    root[:, [3, 4, 5, 9, 10, 11]] *= 8.0
    moved = rows @ root
    v = np.r_[rng.normal(size=12) * 0.2]
    v[[2, 8]] -= 1.0
    return moved @ moved.T, rows @ v


def test_slipping_feet_share_as_springs_in_the_limit_of_rigidity():
    """Their slip is some 1e-4 of their speeds: restitution turns feet that are not level."""
    rng, slid = np.random.default_rng(0), 0
    for _ in range(40):
        W, u = two_tilted_feet(rng)
        e, mu, none = np.full(8, 0.3), np.full(8, 0.5), np.zeros(8)
        exact = solve_contacts(ContactProblem(W, u, u, e, mu, none), ik.Law())
        assert exact.status is ik.Status.SOLVED
        # A compliance of each contact beside its own mobility.
        soft = np.zeros(24)
        for k in range(0, 24, 3):
            soft[k : k + 2] = np.linalg.eigvalsh(W[k : k + 2, k : k + 2])[1]
            soft[k + 2] = W[k + 2, k + 2]
        near = [
            solve_contacts(ContactProblem(W + g * np.diag(soft), u, u, e, mu, none), ik.Law())
            for g in (2e-7, 1e-7)
        ]
        limit = 2.0 * near[1].impulse - near[0].impulse
        np.testing.assert_allclose(exact.impulse, limit, rtol=0, atol=1e-6 * np.abs(limit).max())
        slip = exact.velocity_after.reshape(8, 3)[:, :2]
        slid += int((np.linalg.norm(slip, axis=1) > 1e-9).sum())
    assert slid > 100
