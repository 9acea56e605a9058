"""Moments of inertia that no body has are told, and taken as written."""

import pytest

import impulsekit as ik


def urdf(*moments):
    """Links in a row, each with such ixx, iyy, izz and ixy."""
    links = "".join(
        f'<link name="link_{k}"><inertial><mass value="1"/><inertia ixx="{xx}" ixy="{xy}" ixz="0" '
        f'iyy="{yy}" iyz="0" izz="{zz}"/></inertial></link>'
        for k, (xx, yy, zz, xy) in enumerate(moments)
    )
    joints = "".join(
        f'<joint name="joint_{k}" type="revolute"><parent link="link_{k - 1}"/>'
        f'<child link="link_{k}"/><axis xyz="1 0 0"/>'
        '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
        for k in range(1, len(moments))
    )
    return f'<robot name="row">{links}{joints}</robot>'


def told(*moments):
    return [line for line in read(*moments).assumptions if "principal moments" in line]


def read(*moments):
    return ik.Robot.from_urdf(urdf(*moments))


@pytest.mark.filterwarnings("ignore::impulsekit.errors.AssumptionWarning")
def test_more_than_the_sum_of_the_others_is_told_and_taken():
    (line,) = told((1, 1, 1, 0), (1, 1, 5, 0))
    assert '"link_1" (1, 1, 5 kg m²)' in line and "link_0" not in line
    assert ik.Robot.from_urdf(urdf((1, 1, 1, 0), (1, 1, 5, 0))).model.inertias[1].inertia[2, 2] == 5


@pytest.mark.filterwarnings("ignore::impulsekit.errors.AssumptionWarning")
def test_a_principal_moment_below_zero_is_told_where_the_diagonal_does_not_show_it():
    (line,) = told((1, 1, 1, 0), (1, 1, 1.5, 1.2))
    assert '"link_1" (-0.2, 1.5, 2.2 kg m²)' in line


@pytest.mark.parametrize(
    "moments",
    [(1, 1, 2, 0), (1, 1, 2.01, 0), (0, 1, 1, 0), (0, 0, 0, 0), (1e-6, 1e-6, 1e-5, 0)],
    ids=["plate", "rounded plate", "rod", "point", "marker beside a robot"],
)
def test_what_bodies_have_is_not_told(moments):
    assert told((1, 1, 1, 0), moments) == []
