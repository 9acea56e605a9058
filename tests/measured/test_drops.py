"""Files of planar drops: read, mended by the momentum check, and held against laws."""

import numpy as np
import pytest
from scipy.io import savemat

from benchmarks.recorded.__main__ import main
from benchmarks.recorded.drops import SQUARED_RADII, load_drops

E, MU = 0.5, 0.15


def frictional_drops(count, rng):
    """Impacts of the ellipse in closed form where it slides all along, v_x with the wrong sign."""
    square = SQUARED_RADII["ellipse"]
    rows = []
    while len(rows) < count:
        x, y = rng.uniform(-0.01, 0.01), -rng.uniform(0.025, 0.035)
        v = np.array([rng.uniform(2.0, 3.0), -rng.uniform(2.0, 3.0), rng.normal()])
        # P = (-µ, 1) P_n; u_n⁺ = -e u_n⁻ with 1/m_n = 1 + x (x + µ y)/k².
        down = v[1] + v[2] * x
        blow = -(1 + E) * down / (1.0 + x * (x + MU * y) / square)
        after = v + blow * np.array([-MU, 1.0, (x + MU * y) / square])
        if after[0] - after[2] * y < 0.1:
            continue
        sign = np.array([-1.0, 1.0, 1.0])
        states = np.concatenate([np.zeros(3), sign * v, np.zeros(3), sign * after])
        rows.append((states, np.array([0.0, 1.0, x]), np.array([1.0, 0.0, -y]), len(rows) == 3))
    kinds = [(key, "O") for key in ("states", "n", "d", "flags")]
    table = np.empty((1, count), dtype=kinds)
    for k, (states, n, d, bad) in enumerate(rows):
        table[0, k] = (states[None], n[None], d[None], np.array([[bad] + [False] * 5]))
    return table


@pytest.fixture(scope="module")
def drops(tmp_path_factory):
    path = tmp_path_factory.mktemp("drops") / "ellipse.mat"
    savemat(path, {"bounce_array": frictional_drops(61, np.random.default_rng(0))})
    return path


def test_the_axes_are_mended_and_flagged_impacts_left_out(drops):
    found = load_drops(drops)
    assert found.body == "ellipse" and found.flagged == 1 and len(found.measurements) == 60
    assert found.mirrored.signs.tolist() == [-1.0, 1.0, 1.0] and found.mirrored.left < 1e-9
    assert (np.array([m.v_before for m in found.measurements])[:, 0] > 0.0).all()


@pytest.mark.slow
def test_the_report_tells_the_coefficients(drops, capsys):
    main([str(drops)])
    text = capsys.readouterr().out
    assert "v_x mirrored" in text and "60 impacts, 1 flagged" in text
    line = next(line for line in text.splitlines() if line.startswith("  Newton, slip at the end"))
    assert "restitution = 0.5 " in line and "friction = 0.15 " in line
