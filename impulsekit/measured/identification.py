"""``identify``: from recordings to coefficients in one call, with a report."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from ..design.fit import Fit, fit_impacts
from ..errors import InputError, check_kind
from ..scene import Scene
from .calibration import calibrate
from .comparison import compare_laws
from .finding import find_impacts
from .identification_report import Identification
from .motions import FEWEST_RECORDINGS, check_choices, fit_motion
from .recording import Recording, as_recordings

__all__ = ["identify"]

# Fewer impacts tell a coefficient for each contact badly.
FEWEST_IMPACTS = 5
# Fewer tell laws apart by chance.
FEWEST_TO_COMPARE = 10


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
    processes: int | None = None,
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
        processes, progress, seed: as for ``fit_motion``.

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
    check_choices(held_out, processes, seed)
    check_kind(scene, Scene, "identify")
    several = as_recordings(recordings, "identify")
    restitution, friction = _chosen(scene, restitution, friction)
    notes: list[str] = []
    found_calibration = None
    if calibration:
        found_calibration = calibrate(several, scene)
        several = [found_calibration.apply(each) for each in several]
        if (moved := found_calibration.scene(scene)) is not scene:
            scene = moved
            notes.append("the mass centre was moved to where free fall puts it")
    impacts = find_impacts(several, scene)
    by_impact = None
    good = impacts.balanced()
    if len(good) >= FEWEST_IMPACTS:
        by_impact = fit_impacts(
            good.measurements(scene), restitution=restitution, friction=friction, robust="biweight"
        )
    else:
        notes.append(
            f"{len(good)} of {len(impacts)} impacts balance momentum at known contacts, too few to "
            f"fit (at least {FEWEST_IMPACTS})"
        )
    laws = None
    if compare and len(good) >= FEWEST_TO_COMPARE:
        laws = compare_laws(
            good.measurements(scene), restitution=restitution, friction=friction, seed=seed
        )
    elif compare:
        notes.append(
            f"{len(good)} impacts are too few to compare laws (at least {FEWEST_TO_COMPARE})"
        )
    by_motion = None
    enough = round((1.0 - held_out) * len(several)) >= FEWEST_RECORDINGS
    if motions and enough:
        by_motion = fit_motion(
            several, scene, restitution=restitution, friction=friction, held_out=held_out,
            processes=processes, progress=progress, seed=seed,
        )  # fmt: skip
    elif motions:
        notes.append(f"{len(several)} recordings are too few to fit whole motions")
    fitted = scene
    if by_motion is not None:
        fitted = by_motion.scene
    elif by_impact is not None:
        fitted = _with(scene, by_impact, restitution, friction)
    return Identification(
        tuple(several), found_calibration, impacts, by_impact, by_motion, fitted, tuple(notes), laws
    )


def _shared(names: tuple[str, ...], known: Sequence[str]) -> str | tuple[str, ...]:
    """What one coefficient of all these is called: a pattern where one fits."""
    if len(names) == 1:
        return names[0]
    first, last = min(names), max(names)
    same = [a == b for a, b in zip(first, last, strict=False)]
    start = first[: (*same, False).index(False)]
    if [name for name in known if name.startswith(start)] == list(names):
        return f"{start}*"
    return names


def _with(scene: Scene, fit: Fit, restitution: Any, friction: Any) -> Scene:
    from ..design.parameters import changed_scene, parameters_of

    return changed_scene(scene, parameters_of(scene, restitution, friction, {}), fit.values)


def _chosen(scene: Scene, restitution: Any, friction: Any) -> tuple[Any, Any]:
    """By default one coefficient for all contacts that have a number for it."""
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
