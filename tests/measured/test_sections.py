"""Public recordings from end to end: simulated ones in their files, whose answers are known."""

import sys
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from benchmarks.recorded import elbow, landings
from benchmarks.recorded.__main__ import main
from impulsekit.cli.common import bar_on_terminal
from impulsekit.measured import motions
from tests.measured.test_public_data import biped, zipped_tensor

E, MU, SAMPLES = 0.2, 0.25, 34


@pytest.fixture
def tosses(tmp_path):
    """Ten simulated tosses of the elbow, a sample each 1/148 s, with noise."""
    scene, rng = elbow.elbow_scene(E, MU), np.random.default_rng(0)
    for k in range(10):
        bend, turn = rng.uniform(-1, 1), pin.exp3(rng.normal(size=3))
        q = np.array(
            [0, 0, 0.22, *pin.Quaternion(turn).coeffs(), np.cos(bend), np.sin(bend)], dtype=float
        )
        v = rng.normal(size=7) * [0.3, 0.3, 0.1, 2, 2, 2, 1]
        v[:3] = turn.T @ [*v[:2], -0.7]
        motion = ik.simulate(
            scene, q, v, duration=(SAMPLES - 1) / elbow.RATE, samples=SAMPLES,
            settings=motions.QUICK,
        )  # fmt: skip
        found = np.zeros((SAMPLES, elbow.ELBOW_COLUMNS))
        found[:, :4], found[:, 4:7] = motion.q[:, [6, 3, 4, 5]], motion.q[:, :3]
        found[:, 7] = np.arctan2(motion.q[:, 8], motion.q[:, 7])
        found[:, 4:7] += 2e-4 * rng.normal(size=(SAMPLES, 3))
        found[:, 7] += 2e-3 * rng.normal(size=SAMPLES)
        zipped_tensor(tmp_path / f"{k}.pt", found)
    return tmp_path


@pytest.mark.slow
def test_tosses_of_an_elbow_tell_their_coefficients(tosses, monkeypatch):
    # A smaller search than of 540 tosses, and no inertias nor damping: they are the true ones.
    monkeypatch.setattr(elbow, "HELD_OUT", 0.2)
    monkeypatch.setattr(elbow, "INERTIAS", ())
    monkeypatch.setattr(motions, "STAGES", ((5, 1.0, 8), (4, 1.0, 8)))
    monkeypatch.setattr(elbow, "FORCES", {})
    told = []
    section = elbow.elbow_section(tosses, processes=1, progress=lambda *each: told.append(each))
    assert section.lines[0].startswith("10 tosses, 10 with flight")
    assert told[-1][0] == told[-1][1] == sum(n * 8 for n in (12, 10))
    values = dict(part.split(" = ") for part in section.lines[1][8:].split(", "))
    assert float(values["corner_*: restitution"]) == pytest.approx(E, abs=0.05)
    assert float(values["corner_*: friction"]) == pytest.approx(MU, abs=0.025)
    cube, fitted, none = (line[42:].split("mm") for line in section.lines[-3:])
    # 68 ms after contact: mm, fitted, with the cube's coefficients, and without a floor.
    far = [float(cells[1].split()[-1]) for cells in (fitted, cube, none)]
    assert far[0] < 6.0 and far[0] < 0.7 * far[1] and far[2] > 100.0
    assert [figure[2] for figure in section.figures] == ["nothing published"] * 2


@pytest.fixture
def jumps(tmp_path):
    """A landing of the biped on its leaf springs, simulated, 50 ms at 2 kHz."""
    (tmp_path / "cassie_v2.urdf").write_text(biped())
    robot = ik.Robot.from_urdf(tmp_path / "cassie_v2.urdf", root="freeflyer")
    springs = [
        ik.JointSpring(f"{joint}_{side}", stiffness=stiffness, damping=0.0)
        for joint, stiffness in landings.SPRINGS.items()
        for side in landings.SIDES
    ]
    scene = replace(landings.cassie_scene(robot), forces=springs)
    q, v = robot.neutral().copy(), np.zeros(robot.nv)
    q[2], v[2] = 0.712, -2.0
    motion = ik.simulate(scene, q, v, duration=0.0495, samples=100, settings=landings.SETTINGS)
    x, count = np.zeros((100, landings.COLUMNS)), len(landings.JOINTS)
    x[:, :4], x[:, 4:7] = motion.q[:, [6, 3, 4, 5]], motion.q[:, :3]
    for row, at, speed in zip(x, motion.q, motion.v, strict=True):
        turn = pin.Quaternion(np.array(at[3:7])).matrix()
        row[7 + count : 13 + count] = [*turn @ speed[3:6], *turn @ speed[:3]]
    for k, joint in enumerate(landings.JOINTS):
        own = robot.model.joints[robot.joint_id(joint)]
        x[:, 7 + k], x[:, 13 + count + k] = motion.q[:, own.idx_q], motion.v[:, own.idx_v]
    for kind, array in zip("txu", (motion.t, x, np.zeros((100, 10))), strict=True):
        np.save(tmp_path / f"{kind}_00.npy", array)
    return tmp_path


@pytest.mark.slow
def test_landings_are_followed_from_end_to_end(jumps, capsys):
    assert main([str(jumps)]) == 0
    said = capsys.readouterr()
    assert said.err == f"landings: {jumps}\n"
    lines = said.out.splitlines()
    assert lines[0] == "1 landings"
    rows = {line[:40].strip(): [float(x.split()[0]) for x in (line[40:58], line[58:])]
            for line in lines[4:]}  # fmt: skip
    # The motion is the one that was recorded; an impact alone knows nothing of the leaf springs.
    assert max(rows["motion, springs and torques"]) < 0.01
    assert 0.01 < min(rows["one impact, joints free"]) < rows["one impact, motors locked"][0] < 0.5
    assert min(rows["motion, without contact"]) > 1.0


def test_a_bar_shows_each_part_on_a_terminal(monkeypatch, capsys):
    assert bar_on_terminal("steps") is None
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    tell = bar_on_terminal("steps")
    for done, total in ((1, 2), (2, 2), (3, 9)):
        tell(done, total)
    told = capsys.readouterr().err
    assert "1/2" in told or "0/2" in told
    assert "/9" in told and "steps" in told
