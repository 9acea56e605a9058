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


@every_scene
def test_the_books_close(name):
    impact = solved(name)
    assert impact.energy.imbalance < 1e-12
    assert impact.residuals.largest < 1e-12
    given = [impact.energy.work[name] for name in impact.scene.entry_names("impulses")]
    if name != "rough_floor":
        # What holds and what touches takes energy, or leaves it as it is.
        assert impact.energy.change <= sum(given) + 1e-12 * (
            impact.energy.before + impact.energy.after
        )


@every_scene
def test_contacts_push_within_the_cone_and_let_nothing_in(name):
    impact = solved(name)
    for entry, result in zip(impact.scene.contacts, impact.contacts, strict=True):
        assert result.touching
        for point in result.points:
            pushed = point.impulse @ point.normal
            across = point.impulse - pushed * point.normal
            size = max(abs(pushed), 1e-300)
            assert pushed >= 0
            assert (across @ across) ** 0.5 <= entry.friction * pushed + 1e-12 * size
            assert point.velocity_after @ point.normal >= -1e-12
