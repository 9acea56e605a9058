"""A saved motion: everything comes back, and nothing in the file is run."""

from __future__ import annotations

import io
import os
import pickle
import zipfile

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from impulsekit import errors

from ..models import MODELS, sliders


def moving(scene, q=None, v=None):
    robot = scene.robot
    q = robot.neutral() if q is None else q
    v = robot.velocity() if v is None else v
    return ik.simulate(scene, q, v, duration=0.3, samples=7)


@pytest.fixture(scope="module")
def motion():
    ball = ik.Robot.from_urdf(MODELS / "ball.urdf", root="freeflyer")
    floor = ik.Contact("ball", restitution=0.5, friction=0.2, at=[0, 0, -0.05], name="floor")
    scene = ik.Scene(ball, [ik.AppliedImpulse("ball", linear=[0, 0.1, -1])], contacts=[floor])
    return moving(scene, ball.configuration(root_joint=[0, 0, 0.06, 0, 0, 0, 1]))


def rewritten(path, **changes):
    with np.load(path) as file:
        arrays = {name: file[name] for name in file.files}
    arrays |= changes
    np.savez(path, **{name: array for name, array in arrays.items() if array is not None})
    return path


def test_impacts_come_back_bit_for_bit(motion, tmp_path):
    motion.save(tmp_path / "m.npz")
    again = ik.Trajectory.load(tmp_path / "m.npz")
    assert len(again.impacts) == len(motion.impacts) >= 2
    for (time, impact), (time_again, impact_again) in zip(
        motion.impacts, again.impacts, strict=True
    ):
        assert time == time_again
        assert impact.to_dict() == impact_again.to_dict()


def test_a_file_needs_no_other_file(tmp_path):
    path = tmp_path / "robot.urdf"
    path.write_text(ik.models.chain_urdf(2))
    robot = ik.Robot.from_urdf(path, root="planar")
    moving(ik.Scene(robot)).save(tmp_path / "m.npz")
    path.unlink()
    again = ik.Trajectory.load(tmp_path / "m.npz")
    assert again.scene.robot.model == robot.model


def test_several_robots_constraints_and_laws_come_back(tmp_path):
    ball = ik.Robot.from_urdf(MODELS / "ball.urdf", root="freeflyer")
    chain = ik.Robot.from_urdf(ik.models.chain_urdf(3))
    both = ik.combine(ball=ball, chain=chain, placements={"ball": [0, 0, 5]})
    scene = ik.Scene(
        both,
        [ik.JointImpulse("chain/joint_2", 0.1)],
        [ik.JointLock("chain/joint_3")],
        law=ik.Law(restitution="poisson"),
        gravity=[0, 0, -1],
    )
    motion = moving(scene)
    motion.save(tmp_path / "m.npz")
    again = ik.Trajectory.load(tmp_path / "m.npz")
    assert again.scene.robot.model == both.model
    assert again.scene.constraints == scene.constraints
    assert (again.scene.law, again.scene.gravity) == (scene.law, scene.gravity)
    np.testing.assert_array_equal(again.q, motion.q)


@pytest.mark.parametrize(
    "scene",
    [
        ik.Scene(sliders(1), forces=[ik.Actuator("z00", lambda t, q, v: 1.0)]),
        ik.Scene(ik.Robot.from_model(pin.buildSampleModelManipulator())),
        ik.Scene(ik.Robot.from_urdf(MODELS / "ball.urdf", root=pin.JointModelTranslation())),
    ],
    ids=["function", "model", "root"],
)
def test_what_no_file_can_hold_is_given_to_load(scene, tmp_path):
    motion = moving(scene)
    motion.save(tmp_path / "m.npz")
    with pytest.raises(errors.InputError, match=r"comes without its scene .* scene=") as caught:
        ik.Trajectory.load(tmp_path / "m.npz")
    assert "0x" not in str(caught.value)
    again = ik.Trajectory.load(tmp_path / "m.npz", scene=scene)
    np.testing.assert_allclose(again.q, motion.q, atol=1e-13)


class _Bomb:
    def __reduce__(self):
        return os.mkdir, (os.environ["BOMB"],)


def test_no_pickle_is_opened(motion, tmp_path, monkeypatch):
    monkeypatch.setenv("BOMB", str(tmp_path / "exploded"))
    # An array of objects is a pickle by another name.
    np.savez(tmp_path / "o.npz", t=np.array([_Bomb()], dtype=object))
    with pytest.raises(errors.InputError, match="no trajectory"):
        ik.Trajectory.load(tmp_path / "o.npz")
    (tmp_path / "p.npz").write_bytes(pickle.dumps(_Bomb()))
    with pytest.raises(errors.InputError, match="it is no npz file"):
        ik.Trajectory.load(tmp_path / "p.npz")
    assert not (tmp_path / "exploded").exists()


def test_any_byte_may_be_wrong(motion, tmp_path):
    path = tmp_path / "m.npz"
    motion.save(path)
    whole = path.read_bytes()
    rng = np.random.default_rng(0)
    for _ in range(60):
        broken = bytearray(whole)
        for place in rng.integers(0, len(whole), 3):
            broken[place] = rng.integers(256)
        path.write_bytes(bytes(broken[: rng.integers(len(whole) // 2, len(whole) + 1)]))
        try:
            ik.Trajectory.load(path)
        except errors.InputError as error:
            assert str(error).startswith(str(path)) or "the file" in str(error)


def test_a_file_that_would_swell_beyond_memory_is_refused(motion, tmp_path):
    path = tmp_path / "m.npz"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("t.npy", b"\0" * 10_000_000)
    swollen = bytearray(path.read_bytes())
    size = (10_000_000).to_bytes(4, "little")
    for place in range(len(swollen) - 3):
        if swollen[place : place + 4] == size:
            swollen[place : place + 4] = b"\xff\xff\xff\xfe"
    path.write_bytes(bytes(swollen))
    assert zipfile.is_zipfile(io.BytesIO(swollen))
    with pytest.raises(errors.InputError):
        ik.Trajectory.load(path)
