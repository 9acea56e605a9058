"""``impulsekit solve``: from a scene file to the velocity jump."""

from __future__ import annotations

import json
import math
import pathlib
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from ..impact import Impact
    from ..scenefile import SceneFile

__all__ = ["solve"]


@click.command()
@click.argument("file", type=click.Path())
@click.option(
    "--json", "json_to", type=click.Path(), help='Write all results as JSON; "-": stdout.'
)
@click.option("--check", "checked", is_flag=True, help="Hold it against Kane's equations, too.")
@click.pass_context
def solve(ctx: click.Context, file: str, json_to: str | None, checked: bool) -> None:
    """Solve the scene in FILE (TOML) and print what happens, an instant later."""
    from ..impact import solve as solve_impact
    from ..scenefile import load_scene

    scene_file = load_scene(file)
    impact = solve_impact(scene_file.scene, scene_file.q, scene_file.v)
    if json_to is not None:
        text = json.dumps(_as_dict(scene_file, impact), indent=2, allow_nan=False)
        if json_to == "-":
            click.echo(text)
        else:
            pathlib.Path(json_to).write_text(text + "\n", encoding="utf-8")
    if json_to != "-":
        from ..view.report import report

        click.echo(report(impact, scene_file.points), nl=False)
    agrees = True
    if checked:
        from ..checking import check

        verdict = check(impact)
        agrees = verdict.agrees
        # JSON on stdout stays JSON alone.
        click.echo(f"\n{verdict.report()}", nl=False, err=json_to == "-")
    if not impact.is_valid():
        click.echo(f"not valid: {impact.status.value}", err=True)
    if not (agrees and impact.is_valid()):
        ctx.exit(1)


def _as_dict(scene_file: SceneFile, impact: Impact) -> dict[str, Any]:
    points = []
    for point in scene_file.points:
        velocity = impact.velocity_at(point.frame, point.at)
        points.append(
            {
                "label": point.title,
                "frame": point.frame,
                "at": list(point.at),
                "before": velocity.before.tolist(),
                "after": velocity.after.tolist(),
            }
        )
    return _finite({"scene_file": scene_file.path, **impact.to_dict(), "points": points})


def _finite(value: Any) -> Any:
    """JSON has no NaN and no infinity: they become null."""
    if isinstance(value, dict):
        return {key: _finite(entry) for key, entry in value.items()}
    if isinstance(value, list):
        return [_finite(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
