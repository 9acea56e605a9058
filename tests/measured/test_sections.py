"""Public recordings from end to end: simulated ones in their files, whose answers are known."""

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from benchmarks.recorded import elbow
from impulsekit.measured import motions
from tests.measured.test_public_data import zipped_tensor

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
    section = elbow.elbow_section(tosses, threads=1, progress=lambda *each: told.append(each))
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
