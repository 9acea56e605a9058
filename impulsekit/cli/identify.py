"""``impulsekit identify``: coefficients out of recorded motions."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import click

from .common import check_outputs, json_option, write_json


@click.command()
@click.argument("recording", type=click.Path())
@click.argument("scene", type=click.Path())
@click.option("--restitution", multiple=True, metavar="CONTACT", help='Such as "corner_*".')
@click.option("--friction", multiple=True, metavar="CONTACT", help="Likewise.")
@click.option("--held-out", default=0.25, show_default=True, help="Share left out of the fit.")
@click.option("--calibrate/--no-calibrate", default=True, help="Calibrate the recordings first.")
@click.option("--motions/--no-motions", default=True, help="Fit whole motions, too.")
@click.option("--compare", is_flag=True, help="Compare laws on the single impacts, held out.")
@click.option("--quaternion", type=click.Choice(["xyzw", "wxyz"]), help="Order of a quaternion.")
@click.option("--length", default="m", type=click.Choice(["m", "cm", "mm"]))
@click.option("--angle", default="rad", type=click.Choice(["rad", "deg"]))
@click.option("--time", default="s", type=click.Choice(["s", "ms", "us", "ns"]))
@click.option("--repair", multiple=True, type=click.Choice(["gaps", "time", "norm"]))
@click.option("--level", default=0.95, show_default=True, help="Of the intervals.")
@click.option("--threads", type=int, help="How many.  [default: all cores]")
@click.option("--seed", default=0, show_default=True)
@click.option(
    "--scene-out", type=click.Path(), help="Write the scene with the fitted coefficients."
)
@json_option
@click.option("--plot", type=click.Path(), help="Draw what was found (PNG, SVG, PDF).")
@click.option("--quiet", is_flag=True, help="No progress, even on a terminal.")
@click.pass_context
def identify(ctx: click.Context, recording: str, scene: str, **options: Any) -> None:
    """Fit the coefficients of a SCENE (TOML) to the motions in RECORDING.

    RECORDING is an npz, CSV or Parquet file with columns t, position, quaternion_xyzw or
    quaternion_wxyz, q.JOINT, or the folder of a ROS 2 bag. It is calibrated against gravity
    and the floor; impacts are found and fitted; then whole motions are followed.
    """
    from .common import one_thread_each

    one_thread_each()
    from ..errors import RangeError
    from ..measured.columns import RecordingFormat
    from ..measured.identification import identify as identify_scene
    from ..measured.reading import load_recordings
    from ..scenefile import load_scene
    from .common import bar_on_terminal

    check_outputs(options["json_to"], options["scene_out"], picture=options["plot"])
    if not 0.0 < options["level"] < 1.0:
        raise RangeError.of("--level", options["level"], "between 0 and 1")
    file = load_scene(scene)
    format = RecordingFormat(
        options["quaternion"], options["time"], options["length"], options["angle"]
    )
    recordings = load_recordings(recording, file.scene.robot, format, repair=options["repair"])
    found = identify_scene(
        recordings,
        file.scene,
        restitution=options["restitution"] or None,
        friction=options["friction"] or None,
        calibration=options["calibrate"],
        motions=options["motions"],
        compare=options["compare"],
        held_out=options["held_out"],
        threads=options["threads"],
        progress=None if options["quiet"] else bar_on_terminal("motions"),
        seed=options["seed"],
    )
    _write(found, file.scene, options)
    if found.by_impact is None and found.by_motion is None:
        reason = found.notes[-1] if found.notes else "nothing could be fitted"
        click.echo(f"not valid: {reason}", err=True)
        ctx.exit(1)


def _write(found: Any, scene: Any, options: dict[str, Any]) -> None:
    as_text = write_json(found.to_dict(options["level"]), options["json_to"])
    if options["scene_out"] is not None:
        from ..scenefile import save_scene

        # The robot stays the file's own: what was moved in it stands in the report.
        save_scene(options["scene_out"], replace(scene, contacts=found.scene.contacts))
    if options["plot"] is not None:
        from ..view.plots.canvas import save_figure
        from ..view.plots.results import identified_figure

        save_figure(identified_figure(found), options["plot"])
    if as_text:
        click.echo(found.report(options["level"]), nl=False)
