"""``impulsekit design``, ``fit``, ``identify``: where to strike; coefficients from measurements."""

from __future__ import annotations

import math
import pathlib
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import click

from .common import check_outputs, json_option, write_json

if TYPE_CHECKING:
    from ..design.fit import Fit
    from ..scene import Scene
    from ..scenefile import SceneFile


@click.command()
@click.argument("file", type=click.Path())
@json_option
@click.option("--plot", "plot_to", type=click.Path(), help="Draw the effective masses to a file.")
@click.option(
    "--plane",
    type=click.Choice(["xy", "xz", "yz"]),
    help="Of the drawing; by default where each point moves most easily.",
)
def design(file: str, json_to: str | None, plot_to: str | None, plane: str | None) -> None:
    """Report effective mass and joint loads at the [[design.points]] of FILE (TOML).

    Effective masses and the axes of the impact ellipsoid; the largest and smallest load of a
    joint by a blow there, and the point on a line where the load is least.
    """
    from ..design.summary import design_as_dict, design_as_text
    from ..errors import InputError
    from ..scenefile import load_scene

    check_outputs(json_to, picture=plot_to)
    scene_file = load_scene(file)
    if not scene_file.design:
        raise InputError(f"{file}: there are no [[design.points]] in it")
    report = design_as_dict(scene_file.scene, scene_file.q, scene_file.design)
    if write_json({"scene_file": file, "points": report}, json_to):
        click.echo(design_as_text(report), nl=False)
    if plot_to is not None:
        _draw(scene_file, plane, plot_to)


def _draw(scene_file: SceneFile, plane: str | None, path: str) -> None:
    from ..design.response import impact_ellipsoid
    from ..design.summary import plot_effective_mass
    from ..view.plots.canvas import new_figure, plain, save_figure

    points = scene_file.design
    figure = new_figure(4.5 * len(points), 4.5)
    for ax, point in zip(figure.subplots(1, len(points), squeeze=False)[0], points, strict=True):
        found = impact_ellipsoid(scene_file.scene, scene_file.q, point.frame, point.at)
        plot_effective_mass(found, plane, ax).set_title(plain(point.title))
    save_figure(figure, path)


@click.command()
@click.argument("file", type=click.Path())
@click.option(
    "--measured",
    type=click.Path(),
    help="The measured impacts, CSV or JSON.  [default: beside FILE, by its name]",
)
@click.option("--restitution", multiple=True, metavar="CONTACT", help="Find its restitution.")
@click.option("--friction", multiple=True, metavar="CONTACT", help="Find its friction.")
@click.option(
    "--inertia",
    multiple=True,
    metavar="JOINT:PARAMETERS",
    help="Find inertias of the body behind a joint, such as elbow:mass,mz,iyy.",
)
@click.option("--level", default=0.95, show_default=True, help="Of the confidence intervals.")
@json_option
@click.pass_context
def fit(ctx: click.Context, file: str, measured: str | None, level: float, **options: Any) -> None:
    """Fit the coefficients of the scene in FILE (TOML) to measured impacts.

    The fit starts from the values in FILE. Without --restitution, --friction and
    --inertia, fit all contact coefficients that are numbers above zero.
    """
    from ..design.fit import fit_impacts
    from ..errors import RangeError
    from ..measured.measurement_files import load_measurements
    from ..scenefile import load_scene

    check_outputs(options["json_to"])
    scene_file = load_scene(file)
    if not 0.0 < level < 1.0:
        raise RangeError.of("--level", level, "between 0 and 1")
    path = measured if measured is not None else _beside(file)
    seen = load_measurements(path, scene_file.scene, scene_file.q, scene_file.v)
    wanted: dict[str, Any] = {name: options[name] for name in ("restitution", "friction")}
    wanted["inertias"] = dict(_inertia(item) for item in options["inertia"])
    if not any(wanted.values()):
        wanted |= _every_coefficient(scene_file.scene)
    found = fit_impacts(seen, **wanted)
    if write_json(_as_dict(file, found, len(seen), level), options["json_to"]):
        click.echo(_as_text(found, len(seen), level), nl=False)
    if not found.converged:
        reason = found.notes[0] if found.notes else found.message
        click.echo(f"not valid: {reason}", err=True)
        ctx.exit(1)


def _beside(file: str) -> pathlib.Path:
    """The file of measurements that belongs to a scene file."""
    from ..errors import InputError

    table = pathlib.Path(file).with_suffix(".csv")
    other = pathlib.Path(file).with_suffix(".json")
    for path in (table, other):
        if path.exists():
            return path
    raise InputError(
        f"{file}: there is neither {table.name} nor {other.name} beside it; name the measured "
        "impacts with --measured"
    )


def _inertia(item: str) -> tuple[str, tuple[str, ...]]:
    from ..errors import InputError, quoted

    joint, colon, parameters = item.rpartition(":")
    if not colon or not joint:
        raise InputError(
            f"--inertia must be JOINT:PARAMETERS, such as elbow:mass,iyy, got {quoted(item)}"
        )
    return joint, tuple(name.strip() for name in parameters.split(","))


def _every_coefficient(scene: Scene) -> dict[str, list[str]]:
    """By kind, contacts whose coefficient is a number above zero."""
    named = list(zip(scene.entry_names("contacts"), scene.contacts, strict=True))
    values = {
        kind: {name: getattr(entry, kind, 0.0) for name, entry in named}
        for kind in ("restitution", "friction")
    }
    return {
        kind: [name for name, value in own.items() if isinstance(value, float) and value > 0.0]
        for kind, own in values.items()
    }


def _as_dict(file: str, found: Fit, count: int, level: float) -> dict[str, Any]:
    own = zip(found.names, found.values, found.sigma, found.intervals(level), strict=True)
    return {
        "scene_file": file,
        "impacts": count,
        "level": level,
        "parameters": {
            name: {
                "value": value if math.isfinite(sigma) else None,
                "sigma": sigma,
                "interval": ends,
            }
            for name, value, sigma, ends in own
        },
        "noise": found.noise,
        "freedom": found.freedom,
        "sigma_given": found.sigma_given,
        "converged": found.converged,
        "message": found.message,
        "notes": list(found.notes),
    }


def _as_text(found: Fit, count: int, level: float) -> str:
    share = f"{100.0 * level:g} %"
    lines = [
        f"{count} impact{'s' if count > 1 else ''}, {found.freedom} degrees of freedom",
        "",
    ]
    width = max(9, *map(len, found.names))
    lines.append(f"{'parameter':{width}}   {'value':>10}   {share + ' interval':>23}")
    for name, value, (low, high) in zip(
        found.names, found.values.tolist(), found.intervals(level).tolist(), strict=True
    ):
        known = math.isfinite(high - low)
        interval = f"{low:.5g} to {high:.5g}" if known else "not determined"
        text = f"{value:.5g}" if known else "-"
        lines.append(f"{name:{width}}   {text:>10}   {interval:>23}")
    lines.append("")
    if not found.sigma_given:
        lines.append(f"noise of a speed, from the residuals: {found.noise:.3g} (m/s, rad/s)")
    else:
        lines.append(f"the residuals are {found.noise:.3g} times the noise that was given")
    lines += [f"note: {note}" for note in found.notes]
    return "\n".join(lines) + "\n"


@click.command()
@click.argument("recording", type=click.Path())
@click.argument("scene", type=click.Path())
@click.option("--restitution", multiple=True, metavar="CONTACT", help='Such as "corner_*".')
@click.option("--friction", multiple=True, metavar="CONTACT", help="Likewise.")
@click.option(
    "--held-out",
    default=0.25,
    show_default=True,
    help="Fraction of the recordings held out of the fit.",
)
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

    check_outputs(options["json_to"], scene=options["scene_out"], picture=options["plot"])
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
