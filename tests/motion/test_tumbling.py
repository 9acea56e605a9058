"""Bodies that tumble on a floor come to rest under every law that takes several contacts."""

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik

from .models import GRAVITY, MODELS

LAWS = {
    "newton": ik.Law(),
    "poisson": ik.Law("poisson"),
    "newton in sequence": ik.Law(order="sequential"),
    "poisson in sequence": ik.Law("poisson", order="sequential"),
    "stronge along the path, in sequence": ik.Law("stronge", "path", "sequential"),
    "lzb": ik.Law("lzb"),
}
CORNERS = np.array([(x, y, z) for x in (-0.15, 0.15) for y in (-0.1, 0.1) for z in (-0.05, 0.05)])


def dropped(law, seed, place):
    """The motion of a box that is dropped, and the heights of its corners at the end [m].

    ``place``: where the floor lies; its third axis is up.
    """
    rng = np.random.default_rng(seed)
    up = place.rotation[:, 2]
    given = {"restitution": rng.uniform(0, 0.6), "friction": rng.uniform(0.05, 0.9)}
    given |= {"stiffness": 1.0} if law == "lzb" else {}
    box = ik.Robot.from_urdf(MODELS / "box.urdf", root="freeflyer")
    contacts = [
        ik.Contact("box", at=corner, normal=up, origin=place.translation, **given)
        for corner in CORNERS
    ]
    scene = ik.Scene(box, contacts=contacts, law=LAWS[law], gravity=-GRAVITY * up)
    turn = rng.normal(size=4)
    here = place * pin.XYZQUATToSE3(np.r_[0, 0, 0.25, turn / np.linalg.norm(turn)])
    v = np.r_[rng.uniform(-1, 1, 3), rng.uniform(-6, 6, 3)]
    motion = ik.simulate(scene, pin.SE3ToXYZQUAT(here), v, duration=3.0, samples=3)
    there = place.actInv(pin.XYZQUATToSE3(motion.q[-1]))
    return motion, np.array([there.act(corner)[2] for corner in CORNERS])


@pytest.mark.slow
@pytest.mark.parametrize("law", ["newton in sequence", "poisson", "lzb"])
def test_a_box_that_tumbles_on_a_floor_somewhere_comes_to_lie_on_a_face(law):
    rng = np.random.default_rng(102)
    turned = pin.rpy.rpyToMatrix(*rng.uniform(-3, 3, 3))
    motion, heights = dropped(law, 102, pin.SE3(turned, rng.uniform(-100, 100, 3)))
    assert motion.status.finished, motion.detail
    assert all(impact.status.obeys_law for _, impact in motion.impacts)
    assert np.abs(motion.v[-1]).max() < 1e-8
    # It lies on one of its faces.
    lowest = np.sort(heights)[:4]
    assert np.abs(lowest).max() < 1e-7


ROUND = """<robot name="b"><link name="b"><inertial><mass value="1"/><inertia ixx="{across}"
iyy="{across}" izz="{along}" ixy="0" ixz="0" iyz="0"/></inertial>{pieces}</link></robot>"""
PIECE = '<collision><origin xyz="0 0 {z}"/><geometry><{shape}/></geometry></collision>'
RADIUS, LENGTH = 0.06, 0.2


def round_body(shape):
    """A cylinder, or one with a ball at both ends: a capsule."""
    pieces = PIECE.format(z=0, shape=f'cylinder radius="{RADIUS}" length="{LENGTH}"')
    if shape == "capsule":
        for z in (-0.5 * LENGTH, 0.5 * LENGTH):
            pieces += PIECE.format(z=z, shape=f'sphere radius="{RADIUS}"')
    across, along = (3 * RADIUS**2 + LENGTH**2) / 12, RADIUS**2 / 2
    return ik.Robot.from_urdf(
        ROUND.format(across=across, along=along, pieces=pieces), root="freeflyer"
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("law", "shape", "seed"),
    [("newton", "capsule", 1), ("stronge along the path, in sequence", "cylinder", 0),
     ("lzb", "cylinder", 0)],
)  # fmt: skip
def test_round_bodies_that_tumble_are_followed_to_the_end(law, shape, seed):
    rng = np.random.default_rng(seed)
    given = {"restitution": rng.uniform(0, 0.6), "friction": rng.uniform(0.05, 0.9)}
    given |= {"stiffness": 1.0} if law == "lzb" else {}
    floor = ik.Robot.from_urdf(MODELS / "floor.urdf")
    world = ik.combine(b=round_body(shape), f=floor)
    scene = ik.Scene(
        world,
        contacts=[ik.Collision("b/b", "f/floor", **given)],
        law=LAWS[law],
        gravity=[0, 0, -GRAVITY],
    )
    turn = rng.normal(size=4)
    q = world.configuration({"b/root_joint": [0, 0, 0.3, *turn / np.linalg.norm(turn)]})
    v = world.velocity({"b/root_joint": [*rng.uniform(-1, 1, 3), *rng.uniform(-6, 6, 3)]})
    motion = ik.simulate(scene, q, v, duration=1.5, samples=3)
    assert motion.status.finished, motion.detail
    assert all(impact.status.obeys_law for _, impact in motion.impacts)
    energy = motion.energy().total
    assert energy[-1] <= energy[0] * (1 + 1e-9)
