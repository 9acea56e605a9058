"""Examples inside MuJoCo say the same as impulsekit alone."""

import pytest

from . import printed

pytest.importorskip("mujoco")


@pytest.mark.parametrize("name", ["ball_on_arm", "box_in_mujoco"])
def test_velocities_are_those_of_a_scene(name):
    assert float(printed(name)[-1][-1]) < 1e-10


def test_the_paddle_keeps_the_ball_at_its_height():
    rows = printed("juggling_paddle")[1:-1]
    assert len(rows) == 8
    assert all(float(row[4]) == pytest.approx(1.0, abs=0.01) for row in rows)


def test_solo12_loses_less_where_it_rebounds():
    *_, soft, hard, alone = printed("solo12_in_mujoco")
    assert float(soft[3]) > float(hard[3]) == float(alone[-2])
