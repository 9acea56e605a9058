"""On the edge of sticking and slipping no law has derivatives; a little off it all have."""

from __future__ import annotations

import pytest

import impulsekit as ik

BALL = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
E, MU, RADIUS = 0.5, 0.3, 0.1
# The laws whose friction acts phase by phase have an edge at the end of compression, too.
BOTH, END = (1.0, 1.0 + E), (1.0 + E,)
LAWS = {
    "newton, end": (ik.Law(), END),
    "newton, end, in sequence": (ik.Law(order="sequential"), END),
    "poisson, end": (ik.Law("poisson"), BOTH),
    "poisson, end, in sequence": (ik.Law("poisson", order="sequential"), BOTH),
    "newton, path": (ik.Law("newton", "path"), BOTH),
    "poisson, path": (ik.Law("poisson", "path"), BOTH),
    "stronge, path": (ik.Law("stronge", "path"), BOTH),
    "stronge, path, in sequence": (ik.Law("stronge", "path", "sequential"), BOTH),
}


def derivatives_status(law, phases, off):
    """Of a ball whose slip would stop when P_n is `phases` times that of compression, nearly."""
    inertia = BALL.model.inertias[1]
    sideways = 1.0 / inertia.mass + RADIUS**2 / inertia.inertia[0, 0]
    slip = sideways * MU * phases * inertia.mass * (1.0 + off)
    floor = ik.Contact("ball", at=[0, 0, -RADIUS], restitution=E, friction=MU)
    scene = ik.Scene(BALL, contacts=[floor], law=law)
    return ik.derivatives(ik.solve(scene, BALL.neutral(), [slip, 0, -1, 0, 0, 0])).status


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("off", [0.0, 1e-15, -1e-15, 1e-13, -1e-13, 1e-11, -1e-11, 1e-9, -1e-9])
def test_every_law_tells_the_edge_from_both_sides(name, off):
    law, edges = LAWS[name]
    for phases in edges:
        assert derivatives_status(law, phases, off).name == "MODE_EDGE"


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("off", [1e-5, -1e-5, 1e-2, -1e-2])
def test_off_the_edge_derivatives_exist(name, off):
    law, edges = LAWS[name]
    for phases in edges:
        assert derivatives_status(law, phases, off).exists
