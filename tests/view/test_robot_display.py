"""A robot is shown as it stands, without a scene."""

import numpy as np
import pytest

import impulsekit as ik
from impulsekit import errors


def test_a_robot_is_shown_at_its_configuration(tmp_path):
    talos = ik.Robot.from_example("panda")
    q = talos.configuration(panda_joint4=-1.5)
    shown = ik.display(talos, q, tmp_path / "panda.html")
    assert shown.duration == 0.0 and (tmp_path / "panda.html").stat().st_size > 100_000
    assert "<iframe" in shown._repr_html_()
    other = ik.display(talos)
    assert shown.commands != other.commands


@pytest.mark.parametrize(
    ("q", "error"), [(np.zeros(3), errors.ShapeError), ("home", errors.InputError)]
)
def test_what_is_no_configuration_is_refused(q, error):
    with pytest.raises(error, match="configuration q"):
        ik.display(ik.Robot.from_example("panda"), q)
    with pytest.raises(errors.InputError, match="display takes a Robot"):
        ik.display("panda")


def test_small_models_come_along():
    ball = ik.Robot.from_file(ik.models.path("ball"), root="freeflyer")
    assert ball.mass == 0.5 and ik.models.path("ball.urdf") == ik.models.path("ball")
    with pytest.raises(errors.UnknownNameError, match='did you mean "ball"'):
        ik.models.path("bal")
