"""``identify``: from recordings to coefficients in one call, with a report."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..design.fit import Fit, fit_impacts
from ..design.parameters import changed_scene
from ..errors import InputError, check_kind
from ..errors.calls import public
from ..formatting import OneLine, plain
from ..scene import Scene
from .calibration import Calibration, calibrate
from .comparison import LawComparison, compare_laws
from .found_impacts import FoundImpacts
from .impact_detection import find_impacts
from .motions import FEWEST_RECORDINGS, MotionFit, check_choices, fit_motion
from .recording import Recording, as_recordings

# Of recordings, so many notes are shown.
MOST_NOTES = 8


@public
@dataclass(frozen=True, eq=False, repr=False)
class Identification(OneLine):
    """Everything that recordings determine of a scene.

    Attributes:
        recordings: as they were used: calibrated.
        calibration: None if there was none.
        impacts: what was found in them.
        by_impact: the fit to single impacts; None with too few.
        by_motion: the fit to whole motions; None if it was not asked for, or with too few.
        scene: the scene with the fitted coefficients, of whole motions where there are any.
        notes: what was left out, and why.
        laws: how laws predict the impacts; None if it was not asked for, or with too few.

    Example:
        >>> import impulsekit as ik
        >>> file = ik.load_scene("examples/cube_tosses.toml")
        >>> tosses = ik.measured.load_recordings("examples/cube_tosses.npz", file.scene.robot)
        >>> found = ik.measured.identify(tosses[:4], file.scene, motions=False)
        >>> found.by_motion is None, found.calibration is None, "Impacts" in found.report()
        (True, False, True)
    """

    recordings: tuple[Recording, ...] = field(repr=False)
    calibration: Calibration | None
    impacts: FoundImpacts
    by_impact: Fit | None
    by_motion: MotionFit | None
    scene: Scene = field(repr=False)
    notes: tuple[str, ...] = ()
    laws: LawComparison | None = None

    def report(self, level: float = 0.95) -> str:
        """Return the report as text."""
        return _report(self, level)

    def to_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Return all numbers of the report, ready for JSON."""
        return _as_dict(self, level)


def _report(found: Identification, level: float) -> str:
    """Return the report as text."""
    samples = sum(len(each.t) for each in found.recordings)
    lines = [f"{_count(len(found.recordings), 'recording')}, {samples} samples"]
    # What was repaired or left out while reading.
    from_files = [f"{each.name or 'recording'}: {note}" for each in found.recordings
            for note in each.notes]  # fmt: skip
    lines += [f"note: {line}" for line in from_files[:MOST_NOTES]]
    if len(from_files) > MOST_NOTES:
        lines.append(f"note: {len(from_files) - MOST_NOTES} more such notes")
    lines.append("")
    if found.calibration is not None:
        lines += ["Calibration", *str(found.calibration).splitlines(), ""]
    impacts = found.impacts
    lines += [
        "Impacts",
        f"{_count(len(impacts), 'impact')} with flight on both sides, "
        f"{len(impacts.balanced())} of them consistent with the momentum balance at known contacts",
        f"{_count(len(impacts.phases), 'phase')} without flight, "
        f"{_count(len(impacts.outliers), 'sample')} off the others",
        *(f"note: {note}" for note in impacts.notes),
        "",
    ]
    if found.by_impact is not None:
        lines += ["Fitted to single impacts", *_fit_lines(found.by_impact, level), ""]
    if found.laws is not None:
        lines += [
            "Laws, by single impacts held out; errors in per cent of v before, by kinetic energy",
            *found.laws.report().splitlines(), "",
        ]  # fmt: skip
    if found.by_motion is not None:
        lines += ["Fitted to whole motions", *_motion_lines(found.by_motion, level), ""]
    lines += [f"note: {note}" for note in found.notes]
    return "\n".join(lines).rstrip("\n") + "\n"


def _count(number: int, what: str) -> str:
    return f"{number} {what}{'' if number == 1 else 's'}"


def _fit_lines(fit: Fit, level: float) -> list[str]:
    rows = _table(fit.names, fit.values, fit.intervals(level), level)
    tail = 50.0 * (1.0 - level)
    drawn = np.percentile(fit.resampled(), [tail, 100.0 - tail], axis=0).T
    known = np.isfinite(fit.intervals(level)).all(axis=1)
    rows += [
        f"resampled: {name} {low:.4g} to {high:.4g}"
        for name, (low, high), is_known in zip(fit.names, drawn, known, strict=True)
        if is_known and low < high
    ]
    return [*rows, *(f"note: {note}" for note in fit.notes)]


def _motion_lines(fit: MotionFit, level: float) -> list[str]:
    rows = _table(fit.names, fit.values, fit.intervals(level), level)
    rows.append(f"{'error of the motion':24} {'mean':>20} {'median':>20}")
    rows += [
        error_row(what, errors)
        for what, errors in (("fitted", fit.errors), ("held out", fit.held_out))
        if len(errors)
    ]
    return [*rows, *(f"note: {note}" for note in fit.notes)]


def error_row(what: str, errors: np.ndarray) -> str:
    """Return mean and median of (K, 2) distances and angles, without recordings that failed."""
    fine = errors[np.isfinite(errors).all(axis=1)]
    if not len(fine):
        return f"{what}: no motion came to its end"
    cells = [
        f"{1e3 * each[0]:6.1f} mm, {math.degrees(each[1]):5.1f}°"
        for each in (fine.mean(axis=0), np.median(fine, axis=0))
    ]
    return f"{f'{what} ({len(errors)})':24} {cells[0]:>20} {cells[1]:>20}"


def _table(names: Any, values: Any, ends: Any, level: float) -> list[str]:
    width = max(24, *map(len, names))
    rows = [f"{'parameter':{width}} {'value':>9}   {f'{100 * level:g} % interval':>20}"]
    for name, value, (low, high) in zip(names, values, ends, strict=True):
        known = math.isfinite(high - low)
        ends_text = f"{low:.4g} to {high:.4g}" if known else "not determined"
        rows.append(f"{name:{width}} {f'{value:.4g}' if known else '-':>9}   {ends_text:>20}")
    return rows


def _as_dict(found: Identification, level: float) -> dict[str, Any]:
    """Return plain data for JSON; what is not finite is None."""
    calibration = found.calibration
    by_motion, by_impact = found.by_motion, found.by_impact
    data: dict[str, Any] = {
        "recordings": [each.name for each in found.recordings],
        "calibration": None,
        "impacts": [
            {
                "recording": each.recording, "time": each.time, "time_sigma": each.time_sigma,
                "contacts": list(each.contacts), "balance": each.balance, "q": each.q,
                "v_before": each.v_before, "v_after": each.v_after, "impulses": each.impulses,
            }
            for each in found.impacts.impacts
        ],
        "by_impact": None,
        "by_motion": None,
        "laws": None if found.laws is None else found.laws.to_dict(),
        "notes": list(found.notes),
    }  # fmt: skip
    if calibration is not None:
        names = tuple(calibration.sigma)
        data["calibration"] = {
            name: {"value": getattr(calibration, name), "sigma": calibration.sigma[name]}
            for name in names
        }
    for key, fit in (("by_impact", by_impact), ("by_motion", by_motion)):
        if fit is not None:
            data[key] = {
                "parameters": {
                    name: {"value": value if np.isfinite(ends).all() else None, "interval": ends}
                    for name, value, ends in zip(
                        fit.names, fit.values, fit.intervals(level), strict=True
                    )
                },
                "notes": list(fit.notes),
            }
    if by_motion is not None:
        data["by_motion"] |= {
            "errors": by_motion.errors, "held_out": by_motion.held_out,
            "held_names": list(by_motion.held_names),
        }  # fmt: skip
    found_data: dict[str, Any] = plain(data)
    return found_data


# Fewer distinguish laws by chance.
FEWEST_TO_COMPARE = 10


@public
def identify(
    recordings: Sequence[Recording],
    scene: Scene,
    *,
    restitution: Sequence[str | Sequence[str]] | None = None,
    friction: Sequence[str | Sequence[str]] | None = None,
    calibration: bool = True,
    motions: bool = True,
    compare: bool = False,
    held_out: float = 0.25,
    threads: int | None = None,
    progress: Callable[[int, int], object] | None = None,
    seed: int = 0,
) -> Identification:
    """Calibrate recordings, find their impacts, fit single impacts and whole motions.

    Args:
        recordings: of the scene's robot.
        scene: contacts, gravity, forces; its coefficients are where the fits start.
        restitution, friction: as for ``fit_impacts``; by default one coefficient shared by all
            contacts that have a number for it.
        calibration: whether to calibrate first; it needs a free root and free fall.
        motions: whether to fit whole motions, which takes longest.
        compare: whether to compare laws on the single impacts, see ``compare_laws``.
        held_out: share of the recordings that the fit to whole motions leaves out.
        threads, progress, seed: as for ``fit_motion``.

    Raises:
        InputError: no contact with a coefficient, or as for ``calibrate`` and ``find_impacts``.
        UnknownNameError, RangeError.

    Example:
        >>> import impulsekit as ik
        >>> file = ik.load_scene("examples/cube_tosses.toml")
        >>> tosses = ik.measured.load_recordings("examples/cube_tosses.npz", file.scene.robot)
        >>> identify(tosses, file.scene).by_motion["corner_*: friction"]  # doctest: +SKIP
        0.18
    """
    check_choices(held_out, threads, seed)
    check_kind(scene, Scene, "identify")
    several = as_recordings(recordings, "identify")
    restitution, friction = _chosen(scene, restitution, friction)
    notes, found_calibration = list[str](), None
    if calibration:
        found_calibration = calibrate(several, scene)
        several = [found_calibration.apply(each) for each in several]
        if (moved := found_calibration.scene(scene)) is not scene:
            scene = moved
            notes.append("the mass centre was moved to where free fall puts it")
    impacts = find_impacts(several, scene)
    by_impact, good = None, impacts.balanced()
    if len(good):
        by_impact = fit_impacts(
            good.measurements(scene), restitution=restitution, friction=friction, robust="biweight"
        )
    else:
        notes.append(
            f"none of {_count(len(impacts), 'impact')} balances momentum at known contacts: there "
            "is nothing to fit"
        )
    laws = by_motion = None
    if compare and len(good) >= FEWEST_TO_COMPARE:
        laws = compare_laws(
            good.measurements(scene), restitution=restitution, friction=friction, seed=seed
        )
    elif compare:
        words = f"{len(good)} impacts are too few to compare laws"
        notes.append(f"{words} (at least {FEWEST_TO_COMPARE})")
    enough = round((1.0 - held_out) * len(several)) >= FEWEST_RECORDINGS
    if motions and enough:
        by_motion = fit_motion(
            several, scene, restitution=restitution, friction=friction, held_out=held_out,
            threads=threads, progress=progress, seed=seed,
        )  # fmt: skip
    elif motions:
        notes.append(
            f"whole motions are fitted to {FEWEST_RECORDINGS} recordings or more, here "
            f"{'is' if len(several) == 1 else 'are'} {len(several)}"
        )
    fitted = scene if by_impact is None else _with(scene, by_impact)
    fitted = fitted if by_motion is None else by_motion.scene
    return Identification(
        tuple(several), found_calibration, impacts, by_impact, by_motion, fitted, tuple(notes), laws
    )


def _shared(names: tuple[str, ...], known: Sequence[str]) -> str | tuple[str, ...]:
    """Return the name of one coefficient shared by all these: a pattern where one fits."""
    if len(names) == 1:
        return names[0]
    first, last = min(names), max(names)
    same = [a == b for a, b in zip(first, last, strict=False)]
    start = first[: (*same, False).index(False)]
    if [name for name in known if name.startswith(start)] == list(names):
        return f"{start}*"
    return names


def _with(scene: Scene, fit: Fit) -> Scene:
    """Return the scene with the values of a fit; what is not determined stays as it was."""
    known = np.isfinite(fit.intervals(0.95)).all(axis=1)
    starts = np.array([each.start for each in fit.parameters])
    return changed_scene(scene, fit.parameters, np.where(known, fit.values, starts))


def _chosen(scene: Scene, restitution: Any, friction: Any) -> tuple[Any, Any]:
    """Choose by default one coefficient for all contacts that have a number for it."""
    chosen = []
    for kind, given in (("restitution", restitution), ("friction", friction)):
        if given is None:
            names = tuple(
                name
                for name, entry in zip(scene.entry_names("contacts"), scene.contacts, strict=True)
                if isinstance(getattr(entry, kind, None), float)
                and (kind == "restitution" or getattr(entry, kind) > 0.0)
            )
            given = [_shared(names, scene.entry_names("contacts"))] if names else []
        chosen.append(given)
    if not any(chosen):
        raise InputError("identify: the scene has no contact with a restitution or friction to fit")
    return chosen[0], chosen[1]
