"""``impulsekit design`` and ``fit``: where to strike, and coefficients out of measured jumps."""

from __future__ import annotations

import math
import pathlib
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
        f"{count} impact{'s' if count > 1 else ''}, {found.freedom} numbers more than unknowns",
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
