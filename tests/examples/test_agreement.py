"""Every scene file against Kane's equations, and its own books."""

import pytest

import impulsekit as ik

from . import EXAMPLES, solved

NAMES = sorted(path.stem for path in EXAMPLES.glob("*.toml"))
every_scene = pytest.mark.parametrize("name", NAMES)


@pytest.mark.slow
@every_scene
def test_kane_agrees(name):
    verdict = ik.check(solved(name))
    assert verdict.agrees, verdict.report()
