"""What contacts of these laws are in scene files."""

import math

import pytest

import impulsekit as ik
from impulsekit.scenefile import dump_scene

BALL = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")


def read_back(scene, tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(dump_scene(scene))
    return ik.load_scene(path).scene


def test_stiffness_adhesion_and_exponent_come_back_bit_for_bit(tmp_path):
    contacts = [
        ik.Contact("ball", stiffness=2.5e5, restitution=0.3),
        ik.Contact("ball", at=[0.1, 0, 0], stiffness=math.inf),
    ]
    scene = ik.Scene(BALL, contacts=contacts, law=ik.Law("lzb", exponent=1.25))
    again = read_back(scene, tmp_path)
    assert again.law == scene.law and again.contacts == scene.contacts
    pads = ik.Scene(BALL, contacts=[ik.Contact("ball", adhesion=1 / 3)])
    assert read_back(pads, tmp_path).contacts == pads.contacts


@pytest.mark.parametrize(
    ("line", "word"),
    [
        ("stiffness = nan", "stiffness must be a finite number, got nan"),
        ("stiffness = -2.0", "stiffness must be above 0, got -2"),
        ("adhesion = inf", "adhesion must be a finite number"),
        ('[law]\nrestitution = "lzb"', "needs the stiffness of every contact"),
        ('adhesion = 1.0\n[law]\nrestitution = "poisson"', r"adhesion belongs to Law\(\)"),
    ],
)
def test_faults_are_told_with_their_place(tmp_path, line, word):
    path = tmp_path / "scene.toml"
    head = dump_scene(ik.Scene(BALL)) + '\n[[contacts]]\nkind = "contact"\nframe = "ball"\n'
    path.write_text(head + line + "\n")
    with pytest.raises(ik.errors.ImpulsekitError, match=word):
        ik.load_scene(path)
