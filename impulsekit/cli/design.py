"""``impulsekit design``: what the points of a scene file are like to a blow."""

from __future__ import annotations

import click

from .common import check_outputs, json_option, write_json


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
    told = design_as_dict(scene_file.scene, scene_file.q, scene_file.design)
    if write_json({"scene_file": file, "points": told}, json_to):
        click.echo(design_as_text(told), nl=False)
    if plot_to is not None:
        _draw(scene_file, plane, plot_to)


def _draw(scene_file: object, plane: str | None, path: str) -> None:
    from ..design.response import impact_ellipsoid
    from ..design.summary import plot_effective_mass
    from ..scenefile import SceneFile

    if not isinstance(scene_file, SceneFile):
        raise TypeError(type(scene_file).__name__)
    from ..view.plots.canvas import new_figure, plain, save_figure

    points = scene_file.design
    figure = new_figure(4.5 * len(points), 4.5)
    for ax, point in zip(figure.subplots(1, len(points), squeeze=False)[0], points, strict=True):
        found = impact_ellipsoid(scene_file.scene, scene_file.q, point.frame, point.at)
        plot_effective_mass(found, plane, ax).set_title(plain(point.title))
    save_figure(figure, path)
