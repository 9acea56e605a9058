"""``simulate``: a scene, a state and a duration to a ``Trajectory``."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InputError, NotFiniteError, RangeError, a_thing, quoted, warn_of_setup
from ..errors.calls import public
from ..scene import Scene
from ..scene.functions import let_through
from ..scene.motion import MotionSettings
from ..scene.numbers import number
from .followed import Followed, checked_start, warn_of_start
from .record.trajectory import Trajectory

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

__all__ = ["chosen_settings", "sample_times", "simulate"]

# Simulated time of the whole, and what is left to wait.
BAR = "{l_bar}{bar}| {n:.4g} of {total:.4g} s [{elapsed}<{remaining}]"


@public
def simulate(
    scene: Scene,
    q: ArrayLike,
    v: ArrayLike,
    duration: float | None = None,
    *,
    samples: ArrayLike | None = None,
    settings: MotionSettings | None = None,
    progress: bool | Callable[[float], None] | None = None,
    **changes: Any,
) -> Trajectory:
    """Simulate the motion of a scene's robot; impacts on the way are detected and solved.

    The scene's impulses act at t = 0, together with the contacts that touch then. After that,
    gravity and the scene's forces move the robot and its constraints hold. A contact that closes
    is an impact under the scene's law; contacts then rest under Coulomb's law and open again.
    Redundant resting points (four corners of a box) share the load like stiff springs, each with
    a stiffness proportional to its effective mass. Polyhedra of a ``Collision`` (boxes, convex
    meshes without very many edges) touch where corners meet faces and where edges cross, to
    machine precision; below 2e-4 m/s they come to rest, placed to 1e-9 m. A step that would
    press bodies into each other by more than 1e-5 m (small ones: a thousandth of their radius),
    or points into planes and joint limits by 1e-4 m or rad, ends the motion with the status
    ``PENETRATION``.

    Forces that are functions of time are sampled 2000 times over the motion, so that a pulse of
    a thousandth of its duration is not missed. For shorter pulses, and where a force jumps, give
    ``stop_times``, at which a step ends and the next begins, or ``max_step``.

    Where friction jams a sliding contact (Painlevé) that would be pressed in without it, no finite
    force satisfies Coulomb's law: an impact without collision stops the slip, listed in
    ``impacts``. A slide that comes to the border of these states where its contact may open as
    well (the singular point of Génot & Brogliato 1999) lets go there, without an impact. An
    impact that is not valid (``Impact.is_valid``) ends the motion with ``IMPACT_NOT_VALID``;
    ``detail`` gives the reason. If the law admits several v⁺, the motion
    continues from the one that ``solve`` returns by the rule of ``impact.uniqueness``;
    ``Trajectory.ambiguous`` lists these impacts.

    Args:
        scene: the robot, what acts on it, and the law of contact.
        q: (nq,) configuration at the start.
        v: (nv,) velocity at the start, before the impulses act.
        duration: [s], 0 or more; 0 gives the state after the impulses alone.
        samples: number of samples, evenly from 0 to the end; or increasing times [s].
        settings: method, tolerances and limits; see ``MotionSettings``.
        progress: True for a progress bar on stderr, or a function that is called with the time
            [s] after every step.
        **changes: single settings to change, such as ``accuracy="high"`` or ``method="radau"``.

    Warns:
        SetupWarning: the first time that a scene is simulated, if nothing can be hit or q is likely
            not meant.

    Returns:
        The motion. If it ended early, ``status`` gives the reason, and the part computed until
        then is kept; after Ctrl-C the status is ``INTERRUPTED``.

    Raises:
        ShapeError, NotFiniteError, StateError: q or v is not valid.
        RangeError, NotFiniteError: a duration or setting outside its range.
        CallbackError, ShapeError, NotFiniteError, RangeError: a function of the scene gave
            something else than numbers. What it raises itself comes out as it was raised, with
            a note of where and when.
        InputError: a contact is penetrated at the start, or one has adhesion
            without a holding_force.
        SingularMassError: a joint moves no inertia at the start.
        ContradictionError: the constraints contradict each other at the start.

    Example:
        >>> from impulsekit import Contact, Robot, Scene, simulate
        >>> ball = Robot.from_urdf("models/ball.urdf", root="freeflyer")
        >>> floor = Contact("ball", normal=[0, 0, 1], restitution=0.9)
        >>> drop = ball.configuration(root_joint=[0, 0, 1, 0, 0, 0, 1])
        >>> motion = simulate(Scene(ball, contacts=[floor]), drop, ball.velocity(), duration=1)
        >>> [round(time, 6) for time, _ in motion.impacts]
        [0.451524]
    """
    if not (progress is None or isinstance(progress, bool) or callable(progress)):
        raise InputError(f"progress must be True or a function of the time, got {quoted(progress)}")
    chosen, times = chosen_settings(settings, duration, samples, changes)
    q, v = checked_start(scene, q, v, "simulate")
    warn_of_start(scene, q)
    with (
        np.errstate(over="ignore", invalid="ignore", divide="ignore"),
        _shown(progress, chosen.duration) as tell,
    ):
        followed = let_through(lambda: Followed(scene, q, v, chosen), lambda: 0.0)
        return let_through(lambda: followed.to_end(times, tell), lambda: followed.core.t)


@contextmanager
def _shown(
    progress: bool | Callable[[float], None] | None, duration: float
) -> Iterator[Callable[[float], None] | None]:
    """Return the callback that receives the time after every step; a bar for True."""
    if progress is not True:
        yield progress or None
        return
    from tqdm import tqdm

    with tqdm(total=duration, bar_format=BAR, miniters=0) as bar:
        yield lambda time: _tell(bar, time)


def _tell(bar: Any, time: float) -> None:
    bar.update(time - bar.n)


def chosen_settings(
    settings: MotionSettings | None,
    duration: float | None,
    samples: Any,
    changes: Mapping[str, Any],
) -> tuple[MotionSettings, np.ndarray]:
    """The settings that hold, and the (T,) times of the samples [s]; arguments of ``simulate``.

    Raises:
        InputError, RangeError, NotFiniteError, UnknownNameError: what is wrong with them.
    """
    base = MotionSettings() if settings is None else settings
    if not isinstance(base, MotionSettings):
        raise InputError(f"settings must be a MotionSettings, got {a_thing(base)}")
    given: dict[str, Any] = dict(changes)
    if duration is not None:
        given["duration"] = duration
    if samples is not None and np.ndim(samples) == 0:
        given["samples"] = samples
    chosen = base.changed(**given)
    if settings is None and duration is None:
        warn_of_setup([f"no duration is given: the motion ends after {chosen.duration:g} s"])
    if samples is not None and np.ndim(samples) > 0:
        return chosen, sample_times(samples, chosen.duration)
    return chosen, sample_times(chosen.samples, chosen.duration)


def sample_times(samples: Any, duration: float) -> np.ndarray:
    """The (T,) times of samples [s]: so many, evenly, or those that are given.

    Raises:
        RangeError, NotFiniteError: no times of such a motion.
    """
    if np.ndim(samples) == 0:
        return np.linspace(0.0, duration, int(samples) if duration > 0.0 else 1)
    times = np.array([number(t, "samples") for t in samples])
    if not times.size:
        raise RangeError.of("samples", samples, "at least one time")
    if (np.diff(times) <= 0.0).any() or times[0] < 0.0 or times[-1] > duration:
        raise RangeError.of("samples", samples, f"rising times from 0 to {duration:g} s")
    if not math.isfinite(times.sum()):
        raise NotFiniteError.of("samples", "their sum", times.sum())
    return times
