"""Materials on links, and coefficients by pair."""

import pickle
from dataclasses import replace

import pytest

import impulsekit as ik

BALLS = ik.combine(
    a=ik.Robot.from_urdf("models/ball.urdf", root="freeflyer"),
    b=ik.Robot.from_urdf("models/ball.urdf", root="freeflyer"),
)
TABLE = [
    ik.Material("rubber", links=["a/ball"]),
    ik.Material("steel", links=["b/ball", "world"]),
    ik.MaterialPair("steel", "rubber", restitution=0.5, friction=0.25, stiffness=2e5),
    ik.MaterialPair("steel", "steel", restitution=0.9, friction=(0.2, 0.1)),
]
ASKS = {"restitution": "material", "friction": "material"}


def test_contacts_get_the_coefficients_of_their_pair():
    contacts = [
        ik.Contact("a/ball", **ASKS),
        ik.Contact("b/ball", **ASKS),
        ik.Collision("a/ball", "b/ball", **ASKS, stiffness=7.0),
        ik.Contact("b/ball", restitution="material", friction=0.7),
        ik.Contact("b/ball", restitution=0.1, friction=0.3),
    ]
    scene = ik.Scene(BALLS, contacts=contacts, materials=TABLE)
    found = [(c.restitution, c.friction, c.stiffness) for c in scene.contacts]
    assert found == [
        (0.5, 0.25, 2e5),
        (0.9, ik.StaticKinetic(0.2, 0.1), None),
        (0.5, 0.25, 7.0),
        (0.9, 0.7, None),
        (0.1, 0.3, None),
    ]
    v = BALLS.velocity({"a/root_joint": [0, 0, -1.0, 0, 0, 0]})
    floor = ik.Scene(BALLS, contacts=contacts[:1], materials=TABLE)
    assert ik.solve(floor, BALLS.neutral(), v).v_after[2] == pytest.approx(0.5, abs=1e-15)


def test_another_table_gives_its_own_coefficients():
    contacts = [ik.Contact("b/ball", **ASKS), ik.Contact("b/ball", restitution=0.1, name="own")]
    scene = ik.Scene(BALLS, contacts=contacts, materials=TABLE)
    soft = ik.MaterialPair("steel", "steel", restitution=0.2, friction=0.4, stiffness=9.0)
    other = replace(pickle.loads(pickle.dumps(scene)), materials=[*TABLE[:3], soft])
    found = [(c.restitution, c.friction, c.stiffness) for c in other.contacts]
    assert found == [(0.2, 0.4, 9.0), (0.1, 0.0, None)]
    fresh = ik.Scene(BALLS, contacts=contacts, materials=[*TABLE[:3], soft])
    assert other.contacts == fresh.contacts
    # What is not of the table stays.
    assert replace(scene, gap_bound=1.0).contacts == scene.contacts
    harder = replace(scene.contacts[0], restitution=1.0)
    assert replace(other, contacts=[harder]).contacts[0].restitution == 1.0
    with pytest.raises(ik.errors.InputError, match="materials without a pair"):
        replace(scene, materials=TABLE[:3])


def test_frames_on_a_link_are_made_of_it():
    panda = ik.Robot.from_example("panda")
    table = [
        ik.Material("steel", links=["panda_link8", "world"]),
        ik.MaterialPair("steel", "steel", restitution=0.3),
    ]
    tip = ik.Contact("panda_hand", restitution="material")
    assert ik.Scene(panda, contacts=[tip], materials=table).contacts[0].restitution == 0.3


def test_scene_files_hold_them(tmp_path):
    text = """
[robot]
urdf = "{urdf}"
root = "freeflyer"
[[contacts]]
kind = "contact"
frame = "ball"
restitution = "material"
friction = "material"
[[materials]]
name = "rubber"
links = ["ball"]
[[materials]]
name = "stone"
links = ["world"]
[[materials]]
first = "rubber"
other = "stone"
restitution = 0.7
friction = [0.8, 0.6]
"""
    path = tmp_path / "scene.toml"
    import pathlib

    path.write_text(text.format(urdf=pathlib.Path("models/ball.urdf").resolve()))
    scene = ik.load_scene(path).scene
    assert scene.contacts[0].restitution == 0.7
    assert scene.contacts[0].friction == ik.StaticKinetic(0.8, 0.6)
    ik.save_scene(tmp_path / "again.toml", scene)
    again = ik.load_scene(tmp_path / "again.toml").scene
    assert again.materials == scene.materials and again.contacts == scene.contacts
    # The words stay, so that a change of the table in the file counts.
    changed = (tmp_path / "again.toml").read_text().replace("0.7", "0.6")
    path.write_text(changed)
    assert ik.load_scene(path).scene.contacts[0].restitution == 0.6
    path.write_text(text.format(urdf=pathlib.Path("models/ball.urdf").resolve()))
    path.write_text(path.read_text().replace('other = "stone"', 'other = "rubber"'))
    with pytest.raises(ik.errors.ImpulsekitError, match="materials without a pair"):
        ik.load_scene(path)


def test_geometry_of_the_world_is_made_of_what_is_fixed():
    ball = ik.Robot.from_mjcf(
        """<mujoco><worldbody><geom name="floor" type="plane" size="1 1 1"/>
        <body name="ball"><freejoint/><geom name="skin" size="0.1"/></body></worldbody></mujoco>"""
    )
    table = [
        ik.Material("rubber", links=["ball"]),
        ik.Material("stone", links=["world"]),
        ik.MaterialPair("stone", "rubber", restitution=0.4),
    ]
    meets = ik.Collision("skin", "floor", restitution="material")
    assert ik.Scene(ball, contacts=[meets], materials=table).contacts[0].restitution == 0.4


def test_a_contact_that_is_replaced_keeps_its_materials():
    """But for what is replaced itself; in files, too."""
    given = ik.Contact("b/ball", at=[0, 0, -0.05], **ASKS)
    scene = ik.Scene(BALLS, contacts=[given], materials=TABLE)
    own = scene.contacts[0]
    moved = replace(own, at=[0, 0, -0.07], name="pad")
    assert moved.restitution == own.restitution and "_by_table" not in repr(moved)
    hand = replace(own, friction=0.123)
    soft = replace(TABLE[-1], restitution=0.31, friction=0.47)
    other = replace(scene, contacts=[moved, hand], materials=[*TABLE[:-1], soft])
    fresh = ik.Scene(
        BALLS, contacts=[replace(given, at=[0, 0, -0.07], name="pad")], materials=other.materials
    )
    assert other.contacts[0] == fresh.contacts[0]
    assert other.contacts[1].friction == 0.123
    assert other.contacts[1].restitution == fresh.contacts[0].restitution
