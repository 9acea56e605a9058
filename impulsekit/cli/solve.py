"""``impulsekit solve``: from a scene file to the velocity jump."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from .common import check_outputs, json_option, write_json

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ..impact import Impact
    from ..scene.points import ReportPoint
    from ..scenefile import SceneFile


@click.command()
@click.argument("file", type=click.Path())
@json_option
@click.option(
    "--form",
    type=click.Choice(["text", "markdown", "json"]),
    default="text",
    show_default=True,
    help="Report format.",
)
@click.option("--plot", type=click.Path(), help="Draw the results on one sheet (PNG, SVG, PDF).")
@click.option("--html", type=click.Path(), help="Write an interactive replay, one page.")
@click.option("--check", "checked", is_flag=True, help="Also check against Kane's equations.")
@click.pass_context
def solve(
    ctx: click.Context,
    file: str,
    json_to: str | None,
    form: str,
    plot: str | None,
    html: str | None,
    checked: bool,
) -> None:
    """Solve the scene in FILE (TOML) and print velocities, impulses and energies."""
    from ..impact import solve as solve_impact
    from ..scenefile import load_scene

    check_outputs(json_to, page=html, picture=plot)
    scene_file = load_scene(file)
    impact = solve_impact(scene_file.scene, scene_file.q, scene_file.v)
    if json_to is None or write_json(_as_dict(scene_file, impact), json_to):
        show_report(impact, scene_file.points, form)
    if plot is not None:
        from ..view.plots import overview

        overview(impact, plot)
    if html is not None:
        from .simulate import write_page

        write_page(impact, html, points=scene_file.points)
    agrees = True
    if checked:
        from ..checking import check

        verdict = check(impact)
        agrees = verdict.agrees
        # JSON on stdout stays JSON alone.
        click.echo(f"\n{verdict.report()}", nl=False, err=json_to == "-")
    if not impact.is_valid():
        # The report has the sentence; where JSON alone is on stdout it stands here.
        reason = impact.status.value if json_to == "-" else impact.status.name.lower()
        click.echo(f"not valid: {reason}", err=True)
    if not (agrees and impact.is_valid()):
        ctx.exit(1)


def show_report(impact: Impact, points: Sequence[ReportPoint], form: str = "text") -> None:
    """Print a report: tables by rich in a terminal, and the plain form everywhere else."""
    import sys

    from ..view.report import report, report_blocks
    from .common import is_terminal

    if form == "text" and is_terminal(sys.stdout):
        from rich.console import Console

        from ..view.forms import as_rich

        Console().print(as_rich(report_blocks(impact, points)))
    else:
        click.echo(report(impact, points, form=form), nl=False)


def _as_dict(scene_file: SceneFile, impact: Impact) -> dict[str, Any]:
    points = [
        {"label": point.title, "frame": point.frame, "at": list(point.at), "before": v.before,
         "after": v.after}
        for point in scene_file.points
        for v in (impact.velocity_at(point.frame, point.at),)
    ]  # fmt: skip
    return {"scene_file": scene_file.path, **impact.to_dict(), "points": points}
