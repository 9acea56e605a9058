"""Meshes: read from named folders only, with finite corners, and solid where they collide."""

from __future__ import annotations

import os
import struct

import numpy as np
import pytest

import impulsekit as ik
from impulsekit import errors

CORNERS = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
FACES = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
BODY = """<robot name="r"><link name="a"><inertial><mass value="1"/>
<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
<collision><geometry><mesh filename="{}"/></geometry></collision></link></robot>"""


def write_stl(path, corners=CORNERS, faces=FACES):
    with open(path, "wb") as file:
        file.write(b"\0" * 80 + struct.pack("<I", len(faces)))
        for face in faces:
            points = [0, 0, 1, *np.ravel([corners[i] for i in face])]
            file.write(struct.pack("<12fH", *points, 0))


@pytest.fixture
def body(tmp_path):
    def make(mesh="m.stl", **options):
        (tmp_path / "r.urdf").write_text(BODY.format(mesh))
        return ik.Robot.from_urdf(tmp_path / "r.urdf", root="freeflyer", **options)

    return make


def meet_the_floor(robot):
    world = ik.combine(body=robot, floor=ik.Robot.from_urdf("models/floor.urdf"))
    fall = world.velocity({"body/root_joint": [0, 0, -1, 0, 0, 0]})
    scene = ik.Scene(world, contacts=[ik.Collision("body/a", "floor/floor")])
    return ik.solve(scene, world.neutral(), fall)


@pytest.mark.parametrize("value", [np.nan, np.inf])
@pytest.mark.parametrize("how_many", [1, 4])
def test_a_corner_that_is_no_number_is_told(body, tmp_path, value, how_many):
    corners = np.array(CORNERS, dtype=float)
    corners[4 - how_many :, 2] = value
    write_stl(tmp_path / "m.stl", corners)
    with pytest.raises(errors.UrdfError, match="mesh"):
        meet_the_floor(body())


@pytest.mark.parametrize("thickness", [0.0, 1e-9])
def test_a_flat_mesh_cannot_collide(body, tmp_path, thickness):
    corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, thickness)]
    write_stl(tmp_path / "m.stl", corners)
    robot = body()
    assert robot.collision_model.ngeoms == 1
    with pytest.raises(errors.InputError, match="flat"):
        meet_the_floor(robot)


def test_a_link_does_not_lead_out_of_the_named_folders(body, tmp_path):
    for folder in ("elsewhere", "meshes"):
        (tmp_path / folder).mkdir()
    write_stl(tmp_path / "elsewhere" / "m.stl")
    os.symlink(tmp_path / "elsewhere" / "m.stl", tmp_path / "meshes" / "m.stl")
    os.symlink(tmp_path / "elsewhere", tmp_path / "meshes" / "more")
    (tmp_path / "robot").mkdir()
    (tmp_path / "robot" / "r.urdf").write_text(BODY.format("m.stl"))
    folders = [tmp_path / "meshes"]
    for mesh in ("m.stl", "more/m.stl", "package://more/m.stl"):
        (tmp_path / "robot" / "r.urdf").write_text(BODY.format(mesh))
        robot = ik.Robot.from_urdf(tmp_path / "robot" / "r.urdf", package_dirs=folders)
        with pytest.raises(errors.UrdfError, match="elsewhere"):
            _ = robot.collision_model
        both = [*folders, tmp_path / "elsewhere"]
        robot = ik.Robot.from_urdf(tmp_path / "robot" / "r.urdf", package_dirs=both)
        assert robot.collision_model.ngeoms == 1


def test_meshes_of_the_package_or_model_that_a_file_is_in_are_found(tmp_path):
    """As ROS and Gazebo lay them out: the name in the URI is that of the marked folder."""
    package, model = tmp_path / "src" / "arm_description", tmp_path / "models" / "cup"
    for folder, mark in ((package, "package.xml"), (model, "model.config")):
        (folder / "meshes").mkdir(parents=True)
        (folder / mark).write_text("<package/>")
        write_stl(folder / "meshes" / "m.stl")
    (package / "urdf").mkdir()
    path = package / "urdf" / "r.urdf"
    path.write_text(BODY.format("package://arm_description/meshes/m.stl"))
    assert ik.Robot.from_urdf(path).collision_model.ngeoms == 1
    shape = "<collision name='c'><geometry><mesh><uri>{}</uri></mesh></geometry></collision>"
    inertial = "<inertial><mass>1</mass></inertial>"
    for uri in ("model://cup/meshes/m.stl", "meshes/m.stl"):
        link = f"<link name='cup'>{inertial}{shape.format(uri)}</link>"
        text = f"<sdf version='1.9'><model name='cup'>{link}</model></sdf>"
        (model / "model.sdf").write_text(text)
        robot = ik.Robot.from_sdf(model / "model.sdf", "freeflyer")
        assert robot.collision_model.ngeoms == 1
    # Outside a marked folder nothing above the file is looked into.
    (package / "package.xml").unlink()
    with pytest.raises(errors.UrdfError, match="was not found"):
        _ = ik.Robot.from_urdf(path).collision_model


BROKEN = {
    "m.off": ("OFF\n1 2\n", "OFF: The number of faces in the header is incorrect"),
    "m.ply": ("ply\nformat ascii 1.0\nfoo\n", "Invalid .ply file: Unable to build DOM"),
    "m.obj": ("v 0 0 0\nf 1 2 3\n", "OBJ: vertex index out of range"),
    "m.xyz": ("hello", "No suitable reader found"),
}


@pytest.mark.parametrize("name", BROKEN)
@pytest.mark.parametrize("language", ["URDF text", "SDF text"])
def test_the_reason_why_a_mesh_is_not_read_is_told_with_its_source(tmp_path, name, language):
    content, reason = BROKEN[name]
    (tmp_path / name).write_text(content)
    if language == "URDF text":
        shape = f'<collision><geometry><mesh filename="{name}"/></geometry></collision>'
        robot = ik.Robot.from_urdf(
            f'<robot name="r"><link name="a">{shape}</link></robot>', package_dirs=[tmp_path]
        )
    else:
        shape = f"<collision><geometry><mesh><uri>{name}</uri></mesh></geometry></collision>"
        text = f'<sdf version="1.9"><model name="r"><link name="a">{shape}</link></model></sdf>'
        with pytest.warns(ik.errors.AssumptionWarning):
            robot = ik.Robot.from_sdf(text, package_dirs=[tmp_path])
    with pytest.raises(ik.errors.UrdfError) as caught:
        _ = robot.collision_model
    assert str(caught.value).startswith(f'{language}: link "a": "{tmp_path / name}" cannot be read')
    assert reason in str(caught.value)
