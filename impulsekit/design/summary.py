"""Design measures of points as text, as plain data and in pictures."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InputError, MissingExtraError, check_kind, quoted
from ..errors.calls import public
from ..formatting import plain
from ..robot import Robot
from ..scene import Scene
from ..scene.points import DesignPoint
from .centre_of_percussion import spare_joint, worst_blow
from .response import ImpactEllipsoid, Response, impact_ellipsoid, unit_vector

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import ArrayLike

# Times the least effective mass of the plane: what is drawn of it.
FAR = 5.0
_PLANES = {"xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}


@public
def plot_effective_mass(
    ellipsoid: ImpactEllipsoid, plane: str | None = None, ax: Axes | None = None
) -> Axes:
    """Plot the effective mass of a point over the directions of a plane of the world.

    Directions in which it is more than ``FAR`` times the least, or infinite, are not drawn.

    Args:
        plane: "xy", "xz" or "yz"; by default the plane in which the point moves most easily.

    Raises:
        InputError: no ``ImpactEllipsoid``, or an unknown plane.
        MissingExtraError: matplotlib is not installed.

    Example:
        >>> from impulsekit import Robot
        >>> from impulsekit.design import impact_ellipsoid
        >>> panda = Robot.from_example("panda")
        >>> ax = plot_effective_mass(impact_ellipsoid(panda, panda.neutral(), "panda_hand"), "xz")
        >>> ax.figure.savefig("hand.svg")  # doctest: +SKIP
    """
    check_kind(ellipsoid, ImpactEllipsoid, "plot_effective_mass")
    if plane is None:
        easy = np.argsort(-np.diagonal(ellipsoid.mobility), kind="stable")[:2]
        plane = "".join("xyz"[i] for i in sorted(easy))
    if plane not in _PLANES:
        raise InputError(f'plane must be "xy", "xz" or "yz", got {quoted(plane)}')
    ax = _axes(ax)
    first, second = _PLANES[plane]
    angles = np.linspace(0.0, 2.0 * math.pi, 1441)
    ways = np.zeros((len(angles), 3))
    ways[:, first], ways[:, second] = np.cos(angles), np.sin(angles)
    masses = np.array([ellipsoid.effective_mass(way) for way in ways])
    least = float(masses.min())
    seen = FAR * least if math.isfinite(least) else 1.0
    # Somewhat past the rim, where the axes cut the curve off.
    radius = np.where(masses < 2.0 * seen, masses, np.nan)
    ax.plot(radius * ways[:, first], radius * ways[:, second], color="#1a6bbf")
    ax.plot(0.0, 0.0, "+", color="#22303c")
    ax.set_aspect("equal")
    reach = 1.1 * min(seen, float(np.nanmax(np.append(radius, 0.0)))) or 1.0
    ax.set_xlim(-reach, reach)
    ax.set_ylim(-reach, reach)
    ax.locator_params(nbins=5)
    if not math.isfinite(least):
        ax.text(0.5, 0.4, "infinite", transform=ax.transAxes, ha="center")
    ax.set_xlabel(f"effective mass along {plane[0]} [kg]")
    ax.set_ylabel(f"effective mass along {plane[1]} [kg]")
    ax.set_title(_plain(ellipsoid.frame))
    return ax


@public
def plot_sparing(
    scene: Scene | Robot,
    q: ArrayLike,
    joint: str,
    frame: str,
    start: ArrayLike,
    end: ArrayLike,
    direction: ArrayLike,
    ax: Axes | None = None,
) -> Axes:
    """Plot the load of a joint by a unit blow over the position on a line; see ``spare_joint``.

    Raises:
        As ``spare_joint``; MissingExtraError: matplotlib is not installed.

    Example:
        >>> from impulsekit import Robot
        >>> from impulsekit.models import pendulum_urdf
        >>> rod = Robot.from_urdf(pendulum_urdf(1))
        >>> line = [0, 0, 0], [0, 0, -1], [1, 0, 0]
        >>> ax = plot_sparing(rod, [0.0], "joint_1", "link_1", *line)
        >>> ax.figure.savefig("sparing.svg")  # doctest: +SKIP
    """
    ax = _axes(ax)
    best = spare_joint(scene, q, joint, frame, start, end, direction)
    response = Response(scene, q)
    n = unit_vector(direction, "direction")
    ends = [response.reaction_map(joint, frame, at)[:3, :3] @ n for at in (start, end)]
    length = float(np.linalg.norm(np.array(end, dtype=float) - np.array(start, dtype=float)))
    places = np.linspace(min(0.0, best.along), max(1.0, best.along), 201)
    shares = [np.linalg.norm(ends[0] + s * (ends[1] - ends[0])) for s in places]
    ax.plot(places * length, shares, color="#1a6bbf")
    ax.plot(best.along * length, best.share, "o", color="#c8412b")
    ax.set_xlabel("place of the blow [m]")
    ax.set_ylabel(f"{_plain(joint)}: impulse per unit of the blow")
    ax.set_ylim(bottom=0.0)
    return ax


def _axes(ax: Axes | None) -> Axes:
    if ax is not None:
        return ax
    with MissingExtraError.unless("matplotlib", "plot", "a plot"):
        from matplotlib import pyplot
    _, made = pyplot.subplots(layout="constrained")
    return made


def _plain(name: str) -> str:
    """Return a name as it is: matplotlib would take what stands between dollars for a formula."""
    return name.replace("$", r"\$")


def design_as_dict(scene: Scene, q: Any, points: Iterable[DesignPoint]) -> list[dict[str, Any]]:
    """Return the design measures of each point, ready for JSON; world axes, SI units.

    An infinite effective mass, where nothing moves, is None.

    Raises:
        As ``impact_ellipsoid`` and ``spare_joint``; InputError: ``until`` without ``joint``.
    """
    report: list[dict[str, Any]] = plain([_of(scene, q, point) for point in points])
    return report


def _of(scene: Scene, q: Any, point: DesignPoint) -> dict[str, Any]:
    found = impact_ellipsoid(scene, q, point.frame, point.at)
    report: dict[str, Any] = {
        "point": point.title,
        "frame": point.frame,
        "at": list(point.at),
        "position": found.position.tolist(),
        "axes": [
            {"direction": axis.tolist(), "effective_mass": mass}
            for axis, mass in zip(found.axes.T, found.masses, strict=True)
        ],
    }
    if point.direction is not None:
        report["direction"] = list(point.direction)
        report["effective_mass"] = found.effective_mass(point.direction)
    if point.joint is None:
        if point.until is not None:
            raise InputError(
                f"{point.title}: until is an end of the line on which a joint is "
                "spared; name the joint"
            )
        return report
    report["joint"] = point.joint
    for kind, unit in (("force", "worst_force"), ("couple", "worst_couple")):
        worst = worst_blow(scene, q, point.joint, point.frame, point.at, kind=kind)
        report[unit] = {"direction": worst.direction.tolist(), "share": worst.share}
        report[unit.replace("worst", "kindest")] = {
            "direction": worst.kindest.tolist(),
            "share": worst.kindest_share,
        }
    if point.until is not None:
        spared = spare_joint(
            scene, q, point.joint, point.frame, point.at, point.until, point.direction
        )
        report["spared"] = {
            "at": spared.at.tolist(),
            "along": spared.along,
            "direction": spared.direction.tolist(),
            "share": spared.share,
        }
    return report


def design_as_text(report: list[dict[str, Any]]) -> str:
    """Return the same as text."""
    lines: list[str] = []
    for item in report:
        lines += [f"{item['point']}, at {_vector(item['position'])} m in the world", ""]
        lines.append("  effective mass [kg]   along (world axes)")
        if "effective_mass" in item:
            lines.append(f"  {_mass(item['effective_mass'])}   {_vector(item['direction'])}  given")
        lines += [
            f"  {_mass(axis['effective_mass'])}   {_vector(axis['direction'])}  own axis"
            for axis in item["axes"]
        ]
        if "joint" in item:
            lines += ["", f"  {item['joint']} carries, per unit impulse at this point:"]
            for key, words, unit in (
                ("worst_force", "impulse at most ", ""),
                ("kindest_force", "impulse at least", ""),
                ("worst_couple", "couple at most  ", " m"),
                ("kindest_couple", "couple at least ", " m"),
            ):
                own = item[key]
                lines.append(
                    f"    {words}  {own['share']:10.6f}{unit:2}  along {_vector(own['direction'])}"
                )
        if "spared" in item:
            own = item["spared"]
            lines.append(
                f"    least load by a blow at {_vector(own['at'])} m in the frame, "
                f"{own['along']:.6f} of the line, along {_vector(own['direction'])}: "
                f"{own['share']:.6f}"
            )
        lines.append("")
    return "\n".join(lines)


def _mass(value: float | None) -> str:
    return f"{'infinite' if value is None else format(value, '.6g'):>19}"


def _vector(values: Any) -> str:
    # Without the sign of a zero.
    return "(" + ", ".join(f"{x:.6g}" for x in (np.round(values, 12) + 0.0)) + ")"
