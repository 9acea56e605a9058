"""``impulsekit replay``: a scene file's impact, or a saved motion, as a moving picture."""

from __future__ import annotations

import os
import zipfile
from typing import TYPE_CHECKING, Any

import click

from .outputs import check_outputs

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ..scene.points import ReportPoint
    from ..view.replay import Replay

__all__ = ["replay", "write_page"]


@click.command()
@click.argument("file", type=click.Path())
@click.option("--html", type=click.Path(), help="Where the page goes; without it, a browser opens.")
@click.option("--open", "show", is_flag=True, help="Open the page in the browser.")
@click.option("--reactions", is_flag=True, help="Draw the reaction impulse of every joint.")
@click.option("--traces", is_flag=True, help="Draw the paths of the scene file's report points.")
@click.option("--ghost", multiple=True, type=float, help="A time whose pose stays visible [s].")
@click.option("--fps", type=float, default=60.0, show_default=True, help="Frames a second.")
@click.option("--speed", type=float, help="Motion seconds for each second of playback.")
def replay(
    file: str,
    html: str | None,
    show: bool,
    reactions: bool,
    traces: bool,
    ghost: tuple[float, ...],
    fps: float,
    speed: float | None,
) -> None:
    """Write or open a moving page of the scene in FILE (TOML), or of a saved motion (npz)."""
    check_outputs(html)
    motion, points = _motion(file)
    drawn = write_page(
        motion,
        html,
        open=show or html is None,
        points=points,
        reactions=reactions,
        traces=points if traces else (),
        ghosts=ghost,
        fps=fps,
        speed=speed,
    )
    click.echo(drawn.page)


def write_page(
    motion: Any, html: str | None, *, points: Sequence[ReportPoint] = (), **options: Any
) -> Replay:
    """Write the page of a motion or an impact; what it lacks goes to stderr."""
    import warnings

    from ..view.replay import replay as draw

    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        drawn = draw(motion, html, points=points, **options)
    for note in (*drawn.notes, *(str(w.message) for w in caught if w.category is UserWarning)):
        click.echo(f"note: {note}", err=True)
    return drawn


def _motion(file: str) -> tuple[Any, Sequence[ReportPoint]]:
    """What a file holds, and the points that its scene reports."""
    if os.path.isfile(file) and zipfile.is_zipfile(file):
        from ..motion import Trajectory

        return Trajectory.load(file), ()
    from ..impact import solve
    from ..scenefile import load_scene

    scene_file = load_scene(file)
    return solve(scene_file.scene, scene_file.q, scene_file.v), scene_file.points
