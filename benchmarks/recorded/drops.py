"""Recorded planar drops: the files of ImpactModeling, and how far laws are from each impact."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.recorded.section import Section
from benchmarks.urdf import link_text, robot_text
from impulsekit.design.parameters import Measurement
from impulsekit.errors import FileError, shown
from impulsekit.files import as_file_error, open_plain_file
from impulsekit.measured.comparison import (
    LawCandidate,
    LawComparison,
    compare_laws,
    usual_candidates,
)
from impulsekit.measured.mirrored_axes import MirroredAxes, find_mirrored
from impulsekit.robot import Robot
from impulsekit.scene import Contact, Law, Scene

# The bodies as published: mass [kg] and inertia about the mass centre over it [m²]; an ellipse with
# axes of 70 and 50 mm (m (a² + b²)/4), a square of 60 mm (m s²/6).
MASSES = {"ellipse": 0.037, "square": 0.0485}
SQUARED_RADII = {"ellipse": (0.035**2 + 0.025**2) / 4.0, "square": 0.06**2 / 6.0}
# How far impacts alike scatter, over the size of v⁻ in the metric of the kinetic energy: where the
# floor is met at another point, the change of velocity is another one in proportion to v⁻.
SCATTER = 0.02
WHERE = (
    "github.com/DAIRLab/ImpactModeling, ellipse_uniform.mat or squareDataPhilUpdated.mat "
    "(BSD-3-Clause)"
)
# [bytes] No list of impacts is that large, and scipy reads files as a whole.
LARGEST = 100_000_000


@dataclass(frozen=True)
class Drops:
    """Impacts of a planar body with a floor.

    Attributes:
        body: "ellipse" or "square".
        measurements: with mended signs of the velocities.
        mirrored: what the momentum check found.
        flagged: how many impacts the authors flagged as bad, which are left out.
    """

    body: str
    measurements: tuple[Measurement, ...]
    mirrored: MirroredAxes
    flagged: int


def load_drops(path: str | os.PathLike[str]) -> Drops:
    """The impacts in a file, with the signs of velocities that the momentum balance asks for.

    Raises:
        FileError: there is none, with where it can be had, or it is another file.
    """
    from scipy.io import loadmat

    label = shown(os.fspath(path), 200)
    if not os.path.exists(path):
        raise FileError(f"{label}: no such file; {WHERE}", path=os.fspath(path))
    with as_file_error(path), open_plain_file(path) as file:
        if os.fstat(file.fileno()).st_size > LARGEST:
            raise FileError(f"{label}: too large for a list of impacts", path=os.fspath(path))
        try:
            found = loadmat(file)
            name = next(key for key in found if not key.startswith("__"))
            table = found[name][0]
            states, n, d = (
                np.array([np.array(row[key], dtype=float)[0] for row in table])
                for key in ("states", "n", "d")
            )
            bad = np.zeros(len(table), dtype=bool)
            if "flags" in table.dtype.names:
                bad = np.array([row["flags"].any() for row in table])
        except Exception as error:  # whatever a file that is none raises
            raise FileError(
                f"{label}: no list of planar impacts ({type(error).__name__}: {error}); {WHERE}",
                path=os.fspath(path),
            ) from None
    if states.shape[1:] != (12,) or n.shape[1:] != (3,) or d.shape[1:] != (3,):
        raise FileError(f"{label}: states, n or d have other shapes; {WHERE}", path=label)
    body = "ellipse" if "flags" in table.dtype.names else "square"
    scene = drop_scene(body)
    ratio = float(np.sqrt(1.0 / SQUARED_RADII[body]))
    seen = []
    for state, normal, along in zip(states[~bad], n[~bad], d[~bad], strict=True):
        noise = SCATTER * float(np.linalg.norm(state[3:6] / [1.0, 1.0, ratio]))
        # Rows of the normal and of the tangent: (0, 1, r_x) and (1, 0, -r_y).
        seen.append(
            Measurement(
                scene, scene.robot.neutral(), state[3:6], state[9:12],
                sigma=[noise, noise, noise * ratio],
                points={"floor": [normal[2], -along[2], 0.0]},
            )
        )  # fmt: skip
    mirrored = find_mirrored(seen)
    return Drops(body, tuple(mirrored.apply(seen)), mirrored, int(bad.sum()))


def drop_scene(body: str) -> Scene:
    """A planar body that touches a floor somewhere."""
    mass = MASSES[body]
    inertia = mass * SQUARED_RADII[body]
    urdf = robot_text(body, link_text("body", mass, inertia))
    floor = Contact("body", normal=[0, 1, 0], restitution=0.5, friction=0.2, name="floor")
    return Scene(Robot.from_urdf(urdf, root="planar"), contacts=[floor])


def _candidates(seen: Sequence[Measurement]) -> list[LawCandidate]:
    """The usual ones; and e by the angle of flight, and e and µ by it and by where it touches."""
    angles = [_angle(m) for m in seen]
    places = [_place(m) for m in seen]
    fifths, thirds = (np.percentile(angles, np.linspace(0, 100, n + 1)[1:-1]) for n in (5, 3))
    places_at = np.percentile(places, [100 / 3, 200 / 3])

    def by_angle(m: Measurement) -> str:
        return f"angle {1 + np.searchsorted(fifths, _angle(m))} of 5"

    def by_both(m: Measurement) -> str:
        angle, place = np.searchsorted(thirds, _angle(m)), np.searchsorted(places_at, _place(m))
        return f"angle {1 + angle} and place {1 + place} of 3"

    law = Law("poisson", "path")
    return [
        *usual_candidates(seen),
        LawCandidate("Poisson, along the path, e by angle of flight", law, by_group=True,
                     group_of=by_angle),
        LawCandidate("Poisson, along the path, e and µ by angle and place", law,
                     by_group=("restitution", "friction"), group_of=by_both),
    ]  # fmt: skip


def _angle(m: Measurement) -> float:
    """The direction of flight against the vertical [rad]."""
    x, y = np.array(m.v_before, dtype=float)[:2]
    return float(np.arctan2(x, -y))


def _place(m: Measurement) -> float:
    """How far beside the mass centre it touches [m]."""
    return float(np.array(m.points["floor"], dtype=float)[0])


def drop_section(
    path: str | os.PathLike[str], *, progress: Callable[[int, int], object] | None = None
) -> Section:
    """Errors of laws on impacts held out, each with one e and µ fitted to the others.

    Raises:
        FileError, InputError: as ``load_drops``, or as ``compare_laws``.
    """
    drops = load_drops(path)
    signs = ", ".join(
        f"{name} {'mirrored' if sign < 0 else 'as recorded'}"
        for name, sign in zip(("v_x", "v_y", "omega"), drops.mirrored.signs, strict=True)
    )
    compared = compare_laws(
        drops.measurements, _candidates(drops.measurements), restitution=["floor"],
        friction=["floor"], folds=2, robust="biweight", progress=progress,
    )  # fmt: skip
    lines = [
        f"{drops.body}: {len(drops.measurements)} impacts, {drops.flagged} flagged ones left out, "
        "half fitted and half held out in turn",
        f"momentum check: {signs}; no impulse at the contact explains "
        f"{100 * drops.mirrored.left:.1f} % of the jump (as recorded "
        f"{100 * drops.mirrored.left_before:.0f} %)",
        *(f"note: {note}" for note in drops.mirrored.notes),
        "",
        "sizes by kinetic energy; mean and median of v before",
        compared.report().rstrip("\n"),
        "",
        "No error of a law for these drops is published.",
    ]
    return Section(
        f"drops of the {drops.body}",
        lines,
        [
            (
                f"{drops.body}, v after, median, held out: {name}",
                f"{100 * after:.1f} %",
                "nothing published",
            )
            for name, after in _told(compared)
        ],
    )


def _told(compared: LawComparison) -> list[tuple[str, float]]:
    """Of each kind of law the best, and its error of v after."""
    pairs = list(zip(compared.names, compared.of_after.tolist(), strict=True))
    one = [pair for pair in pairs if " by " not in pair[0]]
    kinds = (
        [pair for pair in one if "path" in pair[0]],
        [pair for pair in one if "path" not in pair[0]],
        [pair for pair in pairs if " by " in pair[0]],
    )
    return [min(kind, key=lambda pair: pair[1]) for kind in kinds if kind]
