"""Poisson's law gives back e times each share: where shares are open and e differs, so is v⁺."""

import itertools

import numpy as np
import pytest

import impulsekit as ik

from ...motion.models import MODELS

POISSON = ik.Law("poisson")
BOX = ik.Robot.from_urdf(MODELS / "box.urdf", root="freeflyer")
PLACES = [(x, y) for x in (-0.15, 0.15) for y in (-0.1, 0.1)]


def struck(restitution, friction=0.0, law=POISSON):
    """A box that lands flat on its four corners, each with its e."""
    contacts = [
        ik.Contact("box", at=[x, y, -0.05], restitution=e, friction=friction)
        for (x, y), e in zip(PLACES, restitution, strict=True)
    ]
    q = BOX.configuration(root_joint=[0, 0, 0.05, 0, 0, 0, 1])
    v = BOX.velocity(root_joint=[0.1, 0, -1, 0, 0, 0])
    return ik.solve(ik.Scene(BOX, contacts=contacts, law=law), q, v)


def released(share, e):
    """v of the box after its corners gave back e times their shares [N s], all sets tried."""
    body, places = BOX.model.inertias[1], np.array(PLACES)
    rows = np.c_[np.ones(4), places[:, 1], -places[:, 0]]
    W = rows / np.r_[body.mass, body.inertia.diagonal()[:2]] @ rows.T
    back = W @ (share * e)
    for closed in itertools.product([False, True], repeat=4):
        more, on = np.zeros(4), np.array(closed)
        more[on] = np.linalg.lstsq(W[np.ix_(on, on)], -back[on], rcond=None)[0]
        if more.min() >= -1e-12 and (back + W @ more).min() >= -1e-12:
            P = share * e + more
            z, *turns = rows.T @ P / np.r_[body.mass, body.inertia.diagonal()[:2]]
            return np.array([0.1, 0, z, *turns, 0])
    raise AssertionError("no set of closed corners obeys the law")


@pytest.mark.parametrize(("e", "law"), [([0.5] * 4, POISSON), ([0.2, 0.5, 0.5, 0.8], ik.Law())])
def test_one_e_or_newtons_law_leaves_one_velocity(e, law):
    assert struck(e, law=law).uniqueness.proven


def test_weak_friction_alone_proves_nothing_where_shares_come_back():
    impact = struck([0.2, 0.5, 0.5, 0.8], friction=1e-3)
    assert not impact.uniqueness.proven
