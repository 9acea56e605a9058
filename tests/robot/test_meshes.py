"""Meshes are read once while a robot that shows them is there, and never an old one for a new."""

from __future__ import annotations

import numpy as np
import pytest

import impulsekit as ik
from impulsekit.errors import InputError
from impulsekit.robot.geometry import loader_of

TETRAHEDRON = (
    "v 0 0 0\nv {size} 0 0\nv 0 {size} 0\nv 0 0 {size}\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
)
URDF = """<robot name="m"><link name="b"><inertial><mass value="1"/>
<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
<visual><geometry><mesh filename="{name}"/></geometry></visual></link></robot>"""


@pytest.fixture
def robot_of(tmp_path):
    def make(size, name="m.obj", root="fixed"):
        (tmp_path / name).write_text(TETRAHEDRON.format(size=size))
        (tmp_path / "m.urdf").write_text(URDF.format(name=name.replace("&", "&amp;")))
        return ik.Robot.from_urdf(tmp_path / "m.urdf", root=root)

    return make


def largest(robot):
    (shown,) = robot.visual_model.geometryObjects
    return float(np.max(shown.geometry.vertices()))


def test_a_mesh_is_read_once_for_two_robots_of_one_file(robot_of):
    one, other = robot_of(1.0), robot_of(1.0, root="freeflyer")
    one_model = one.visual_model
    path = one_model.geometryObjects[0].meshPath
    assert loader_of([path]) is one._mesh_loaders[0]
    assert largest(one) == largest(other) == 1.0


def test_a_mesh_written_anew_is_read_anew(robot_of):
    # The second file is of the first one's size, and may be of the same second.
    one = robot_of(1.0)
    assert largest(one) == 1.0
    assert largest(robot_of(2.0)) == 2.0
    assert largest(one) == 1.0


@pytest.mark.parametrize("given", [None, [3], 3, [b"/tmp"]])
def test_what_is_no_folder_is_refused(given):
    with pytest.raises(InputError, match=r"package_dirs: .* is no folder; give paths of folders"):
        ik.Robot.from_urdf(ik.models.pendulum_urdf(2), package_dirs=given)
