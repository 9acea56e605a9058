"""``impulsekit simulate`` and ``replay``: the motion after the impact, and its replay."""

from __future__ import annotations

import os
import sys
import zipfile
from typing import TYPE_CHECKING, Any

import click

from .common import INTERRUPTED, bar_on_terminal, check_outputs, is_terminal

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ..motion import Trajectory
    from ..scene.points import ReportPoint
    from ..view.replay import Replay


BAR = "{l_bar}{bar}| {n:.3f}/{total:g} s [{elapsed}<{remaining}]"


@click.command()
@click.argument("file", type=click.Path())
@click.option("--html", type=click.Path(), help="Where the page goes; without it, a browser opens.")
@click.option("--open", "show", is_flag=True, help="Open the page in the browser.")
@click.option("--reactions", is_flag=True, help="Draw the reaction impulse of every joint.")
@click.option("--traces", is_flag=True, help="Draw the paths of the scene file's report points.")
@click.option(
    "--ghost", "ghosts", multiple=True, type=float, help="A time whose pose stays visible [s]."
)
@click.option("--fps", type=float, default=60.0, show_default=True, help="Frames a second.")
@click.option("--speed", type=float, help="Motion seconds for each second of playback.")
@click.option("--video", type=click.Path(), help="Write the playback as MP4, by a Chromium.")
def replay(
    file: str, html: str | None, show: bool, traces: bool, video: str | None, **options: Any
) -> None:
    """Write or open an interactive replay of the scene in FILE (TOML), or of a motion (npz).

    A scene with the table [motion] is simulated; one without it is shown at its impact.
    """
    check_outputs(page=html, video=video)
    motion, points = _motion(file)
    drawn = write_page(
        motion,
        html,
        open=show or (html is None and video is None),
        points=points,
        traces=points if traces else (),
        video=video,
        progress=is_terminal(sys.stderr) or None,
        **options,
    )
    click.echo("\n".join(filter(None, (drawn.page, video))))


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
    """The motion or impact of a file, and the points that its scene reports."""
    if os.path.isfile(file) and zipfile.is_zipfile(file):
        from ..motion import Trajectory

        return Trajectory.load(file), ()
    from ..scenefile import load_scene

    scene_file = load_scene(file)
    scene, q, v = scene_file.scene, scene_file.q, scene_file.v
    if scene_file.motion is None:
        from ..impact import solve

        return solve(scene, q, v), scene_file.points
    from ..motion import simulate as simulate_motion

    show = bar_on_terminal("s", delay=0.5, bar_format=BAR)
    duration = scene_file.motion.duration
    progress = None if show is None else lambda t: show(t, duration)
    motion = simulate_motion(scene, q, v, settings=scene_file.motion, progress=progress)
    return motion, scene_file.points


@click.command()
@click.argument("file", type=click.Path())
@click.option("--output", "-o", type=click.Path(), help="Write the motion to an npz file.")
@click.option("--duration", "-t", type=float, help="Duration [s]; overrides the file.")
@click.option("--samples", "-n", type=int, help="Number of samples; overrides the file.")
@click.option("--max-step", type=float, help="Maximum step [s]; overrides the file.")
@click.option(
    "--stop-time",
    "stop_times",
    type=float,
    multiple=True,
    help="A time at which a step ends [s], where a force jumps or begins; may be repeated.",
)
@click.option(
    "--plot", type=click.Path(), help="Draw energy and momentum over time (PNG, SVG, PDF)."
)
@click.option("--html", type=click.Path(), help="Write an interactive replay, one page.")
@click.option("--quiet", is_flag=True, help="No progress bar, even on a terminal.")
@click.pass_context
def simulate(
    ctx: click.Context,
    file: str,
    output: str | None,
    plot: str | None,
    html: str | None,
    quiet: bool,
    **given: Any,
) -> None:
    """Simulate the motion of the scene in FILE (TOML); impacts on the way are solved."""
    from ..motion import simulate as simulate_motion
    from ..motion.record.status import MotionStatus
    from ..scene.motion import MotionSettings
    from ..scenefile import load_scene

    check_outputs(motion=output, page=html, picture=plot)
    scene_file = load_scene(file)
    settings = scene_file.motion or MotionSettings()
    settings = settings.changed(**{k: x for k, x in given.items() if x not in (None, ())})
    show = None if quiet else bar_on_terminal("s", delay=0.5, bar_format=BAR)
    progress = None if show is None else lambda t: show(t, settings.duration)
    motion = simulate_motion(
        scene_file.scene, scene_file.q, scene_file.v, settings=settings, progress=progress
    )
    if output is not None:
        motion.save(output)
    if plot is not None:
        from ..view.plots import overview

        overview(motion, plot)
    if html is not None:
        write_page(motion, html, points=scene_file.points)
    click.echo("\n".join(_lines(motion)))
    if not motion.status.finished:
        detail = f" ({motion.detail})" if motion.detail else ""
        click.echo(f"stopped at {motion.duration:g} s: {motion.status.value}{detail}", err=True)
        ctx.exit(INTERRUPTED if motion.status is MotionStatus.INTERRUPTED else 1)


def _lines(motion: Trajectory) -> list[str]:
    """The motion in a few lines and two tables."""
    from ..formatting import table

    energy = motion.energy()
    names = motion.scene.entry_names("contacts")
    many = len(motion.impacts)
    lines = [
        f"{motion.scene.robot.name}: {motion.duration:g} s, {len(motion.t)} states, "
        f"{motion.steps} steps, {many} impact{'' if many == 1 else 's'}",
        f"energy {energy.total[0]:.9g} J at the start, {energy.total[-1]:.9g} J at the end",
    ]
    if motion.impacts:
        rows = []
        for time, impact in motion.impacts[:20]:
            met = [n for n, result in zip(names, impact.contacts, strict=True) if result.touching]
            what = ", ".join(met) or "impulses"
            rows.append([f"{time:.9f}", what, f"{impact.energy.change:.6g}"])
        lines += ["", *table(["impact [s]", "contacts", "energy change [J]"], rows)]
        more = len(motion.impacts) - len(rows)
        if more:
            lines.append(f"... and {more} more, the last at {motion.impacts[-1][0]:.9f} s")
    at_rest = [rest for rest in motion.rests if rest.end > motion.duration]
    if at_rest:
        rows = [[rest.contact, f"{rest.start:.9f}"] for rest in at_rest]
        lines += ["", *table(["at rest", "since [s]"], rows)]
    return lines
