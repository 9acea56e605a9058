"""Compiles what motions call, beforehand."""

from __future__ import annotations

from ..laws.compiled import Entry
from ..scene import Collision, Scene

__all__ = ["compile_motion", "load_motion", "load_shared"]


def compile_motion(scene: Scene | None = None) -> None:
    """Compile what ``simulate`` calls beside the laws of impacts, or load it from disk.

    Args:
        scene: what moves; None for all that any scene needs.
    """
    for entry in _entries(scene):
        entry.compile()


def load_motion(scene: Scene) -> None:
    """Load what ``simulate`` calls for a scene, if any process has compiled it by now."""
    for entry in _entries(scene):
        entry.load(again=True)


def _entries(scene: Scene | None) -> list[Entry]:
    """What motions of a scene call; None: of any scene."""
    from ..laws.resting import find_forces
    from .events.corners import crossings_of
    from .events.look import look
    from .events.touch import first_touch_of, touch_pairs
    from .rest.settle import settle_points
    from .steps.compiled import attempt, begin_steps, rates_at
    from .travel.advance import advance, until_closing
    from .travel.journey import travel
    from .tree.chart import unrolled
    from .tree.pressed import pressed

    of_points, of_bodies = _through_python()
    entries: list[Entry] = [unrolled, attempt, begin_steps, rates_at, advance, travel]
    if scene is None or scene.contacts:
        entries += [look, settle_points, find_forces, pressed, until_closing]
        entries += of_points
    if scene is None or any(isinstance(entry, Collision) for entry in scene.contacts):
        entries += [touch_pairs, first_touch_of, crossings_of, *of_bodies]
    return entries


def _through_python() -> tuple[list[Entry], list[Entry]]:
    """What motions call through Python: of points that touch, and of colliding bodies."""
    from ..geometry.features import touch
    from ..geometry.held_points import write_gaps_and_ends, write_spots
    from ..geometry.polyhedron import separate
    from ..rows.point_rows import gaps_and_rates
    from .gaps.pairs import write_gaps
    from .tree.pressed import rows_and_bias

    of_bodies: list[Entry] = [separate, touch, write_gaps, write_gaps_and_ends, write_spots]
    return [gaps_and_rates, rows_and_bias], of_bodies


def load_shared() -> None:
    """Load what motions call through Python, where it was compiled before.

    Else a number of calls that depends on the time they take would run as Python first, which
    rounds otherwise in the last place: no two motions would be the same to the last bit.
    """
    of_points, of_bodies = _through_python()
    for entry in (*of_points, *of_bodies):
        entry.load()
