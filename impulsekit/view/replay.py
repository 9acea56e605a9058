"""``replay``: an interactive page of a motion or an impact, in meshcat's player."""

from __future__ import annotations

import math
import os
import pathlib
import sys
import tempfile
import webbrowser
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import RangeError, warn_user
from ..errors.calls import public
from ..files import ENDINGS, checked_output, write_file
from ..formatting import Displayed, one_line
from ..scene.points import report_points
from .film import checked_films, draw_films
from .motions import Shown, shown_motion
from .timeline import Timeline

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ..impact import Impact
    from ..measured.recording import Recording
    from ..motion import Trajectory
    from ..scene.points import ReportPoint

# [s] The least duration, for a motion of one instant.
LEAST_DURATION = 1e-9
BAR = "{desc}: {percentage:3.0f} %|{bar}| [{elapsed}<{remaining}]"


@public
@dataclass(frozen=True, eq=False, repr=False)
class Replay(Displayed):
    """A replay, drawn.

    Attributes:
        times: (F,) playback times of the frames [s].
        motion_times: (F,) the instants of the motion they show [s].
        nodes: by joint name, the node of the player that moves with the joint.
        arrows: by entry, joint or point, the nodes of its arrows, impact by impact.
        notes: a sentence for each thing that could not be drawn as asked.
        commands: for meshcat's player, in order.
        html: the text of the page.
        page: the path of the page that was written, or None.
    """

    times: np.ndarray
    motion_times: np.ndarray
    nodes: Mapping[str, str]
    arrows: Mapping[str, tuple[str, ...]]
    notes: tuple[str, ...]
    commands: tuple[dict[str, Any], ...]
    html: str
    page: str | None

    def __repr__(self) -> str:
        arrows = sum(map(len, self.arrows.values()))
        parts = [f"{self.duration:g} s", f"{len(self.times)} frames", f"{arrows} arrows"]
        parts += [f"{len(self.notes)} notes"] * bool(self.notes)
        return one_line("Replay", *parts, f"{len(self.html) / 1e6:.1f} MB", page=self.page)

    @property
    def duration(self) -> float:
        """The duration of the playback [s]."""
        return float(self.times[-1])


@public
def replay(
    motion: Trajectory | Impact | Recording,
    html: str | os.PathLike[str] | None = None,
    *,
    open: bool = False,
    viewer: Any = None,
    points: Sequence[ReportPoint | str] = (),
    velocities: bool = True,
    reactions: bool | Iterable[str] = False,
    traces: Sequence[ReportPoint | str] = (),
    ghosts: Iterable[float] = (),
    fps: float = 60.0,
    speed: float | None = None,
    slow_motion: float = 0.2,
    slow_window: float = 0.05,
    span: float | None = None,
    hold: float = 0.8,
    loop: bool = True,
    play: bool = True,
    title: str | None = None,
    camera: str | ArrayLike | None = None,
    video: str | os.PathLike[str] | None = None,
    picture: str | os.PathLike[str] | None = None,
    size: tuple[int, int] = (1280, 720),
    progress: bool | Callable[[float], None] | None = None,
) -> Replay:
    """Write an interactive page of a motion, or of an impact with a short coast around it.

    The page is one file and needs only a browser with WebGL: no server, no port, no network.
    Between impacts it shows the force of every contact that pushes, of a ``Trajectory``.

    Args:
        motion: a ``Trajectory`` of ``simulate``, a ``Recording``, or an ``Impact``.
        html: path of the page; None returns it in ``Replay.html`` only.
        open: open it in the browser; without ``html`` from a temporary file.
        viewer: a ``meshcat.Visualizer`` that is drawn into as well.
        points: points whose velocities are drawn at impacts; by default some mass centres.
        velocities: draw velocity arrows.
        reactions: True for the reaction impulses of all joints, or joints by name.
        traces: points whose paths are drawn; the name of a frame means its origin.
        ghosts: instants of the motion whose poses stay in the picture [s].
        fps: frames for each second of playback.
        speed: motion seconds for each second of playback; by default 1, and for an impact
            one that stretches it to about four seconds.
        slow_motion: factor on the speed around impacts, up to 1.
        slow_window: time before and after an impact with that factor [s].
        span: for an impact, duration of the coast after it; half of it before [s].
        hold: playback time for which arrows are shown after an impact of a motion [s].
        loop: start again at the end.
        play: start when the page opens.
        title: title of the page; by default the robot's name.
        camera: "front" (from +x), "back", "left" (from +y), "right" or "top"; a position
            (x, y, z), or a pair of a position and a target [m]; None for a view that fits.
        video: path of an MP4 of the whole playback, drawn by a headless Chromium.
        picture: path of a PNG at the first impact, or of the middle where there is none.
        size: width and height of video and picture [px], both even.
        progress: True for a progress bar of the video on stderr, or a function that is called
            with the share of its frames that are drawn, 0 to 1.

    Raises:
        InputError: the motion has no instant, or is of another type; a page without a path; a
            video that does not end in .mp4, a picture that does not end in .png.
        RangeError: a rate, window, ghost or size outside its range.
        UnknownNameError: a joint or frame that the robot does not have.
        FileError: the page cannot be written.
        MissingExtraError: meshcat is not installed; for a video or picture, playwright or a
            Chromium is missing.

    Example:
        >>> from impulsekit import AppliedImpulse, Robot, Scene, solve
        >>> from impulsekit.models import chain_urdf
        >>> robot = Robot.from_urdf(chain_urdf(3), root="planar")
        >>> scene = Scene(robot, [AppliedImpulse("link_1", linear=[0, 5, 0], name="blow")])
        >>> shown = replay(solve(scene, robot.neutral(), robot.velocity()))
        >>> len(shown.times) > 100, shown.arrows["blow"]
        (True, ('/impulsekit/impacts/0/0 impulse blow',))
    """
    # meshcat is loaded when the first replay is drawn.
    from .bodies import Actors, robot_colors
    from .drawing import Drawing
    from .effects import draw_effects, legend_row
    from .page import page_of, send_to
    from .stage import camera_of, draw_stage

    if html is not None:
        html = checked_output(html, "replay: page", *ENDINGS["page"])
    films = checked_films(video, picture, size)
    shown = shown_motion(motion, span)
    if not 0.0 < hold < math.inf:
        raise RangeError.of("replay: hold", hold, "a finite number of seconds above 0")
    timeline = _timeline(shown, speed, slow_motion, slow_window)
    times = timeline.frames(fps, [time for time, _ in shown.impacts])
    actors = Actors.of(shown, timeline.to_motion(times))
    drawing = Drawing()
    actors.draw(drawing, times, _ghost_times(shown, ghosts))
    effects = draw_effects(
        drawing,
        shown,
        timeline,
        actors.reach,
        points=report_points(points, "replay: points"),
        velocities=velocities,
        reactions=reactions if isinstance(reactions, bool) else list(reactions),
        traces=report_points(traces, "replay: traces"),
        hold=None if shown.impact_alone is not None else hold,
    )
    seen = np.concatenate([actors.corners, *effects.ends])
    kinds = {joint.shortname() for joint in shown.robot.model.joints}
    is_planar = "JointModelPlanar" in kinds
    view = camera_of(camera, seen, actors.subject, shown.planes, is_planar)
    draw_stage(drawing, seen, shown.planes, view, actors.corners)
    drawing.animate(timeline.duration, loop=loop)
    notes = (*actors.notes, *effects.notes)
    colors = robot_colors(shown.robot).items()
    robots = [legend_row(prefix.rstrip("/"), color) for prefix, color in colors]
    text = page_of(
        shown.robot.name if title is None else title,
        drawing.commands,
        camera=view.in_player(),
        clock=_clock(timeline),
        rows=[*robots, *effects.rows],
        notes=notes,
        play=play,
        loop=loop,
        fps=fps,
        frames=times.astype(np.float32).tolist(),
        impacts=effects.impacts,
        forces=effects.forces,
        groups=effects.groups,
        labels=[*effects.labels, *actors.labels],
        followed=actors.followed,
    )
    page = _written(text, html, open)
    with _told(progress) as tell:
        draw_films(text, films, tell)
    if viewer is not None:
        send_to(viewer, drawing.commands, view)
    return Replay(
        times,
        timeline.to_motion(times),
        actors.nodes,
        effects.arrows,
        notes,
        tuple(drawing.commands),
        text,
        page,
    )


@contextmanager
def _told(
    progress: bool | Callable[[float], None] | None,
) -> Iterator[Callable[[float], None] | None]:
    """Return the callback that receives the share of a video that is drawn; a bar for True."""
    if progress is not True:
        yield progress or None
        return
    from tqdm import tqdm

    with tqdm(total=100, desc="video", bar_format=BAR) as bar:
        yield lambda share: bar.update(100.0 * share - bar.n)


def _timeline(shown: Shown, speed: float | None, slow_motion: float, window: float) -> Timeline:
    """Return the times of a motion in playback; an impact alone is stretched evenly."""
    usual = 1.0
    if shown.impact_alone is not None:
        usual, slow_motion = max(shown.end - shown.start, LEAST_DURATION) / 4.0, 1.0
    return Timeline.of(
        shown.start,
        shown.end,
        [time for time, _ in shown.impacts],
        speed=usual if speed is None else speed,
        slow_motion=slow_motion,
        window=window,
    )


def _ghost_times(shown: Shown, ghosts: Iterable[float]) -> list[float]:
    times = [float(ghost) for ghost in ghosts]
    for time in times:
        if not shown.start <= time <= shown.end:
            raise RangeError.of("replay: ghosts", time, f"{shown.start:g} to {shown.end:g} s")
    return times


def _clock(timeline: Timeline) -> dict[str, Any] | None:
    """Return the times of the page's clock; None for a still picture."""
    if timeline.duration <= 0.0:
        return None
    span = float(timeline.moved[-1] - timeline.moved[0])
    unit, scale = ("ms", 1e3) if span < 0.5 else ("s", 1.0)
    return {
        "played": timeline.played.tolist(),
        "moved": timeline.moved.tolist(),
        "unit": unit,
        "scale": scale,
        # The eye can follow three digits of the whole span.
        "digits": max(0, 2 - math.floor(math.log10(span * scale))),
    }


def _written(text: str, html: str | os.PathLike[str] | None, show: bool) -> str | None:
    if html is None and not show:
        return None
    if html is None:
        handle, name = tempfile.mkstemp(prefix="impulsekit-", suffix=".html")
        os.close(handle)
    else:
        name = os.fspath(html)
    path = pathlib.Path(name)
    write_file(path, text)
    if show and not _opened(path):
        warn_user(f"no browser could be opened; the page is {path}")
    return str(path)


def _opened(path: pathlib.Path) -> bool:
    """Open a page in the user's browser; False where there is no display or no browser."""
    graphical = sys.platform in ("win32", "darwin") or any(
        os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER")
    )
    # Without a display Python would start a browser for the terminal and wait for its end.
    if not graphical:
        return False
    try:
        return webbrowser.open(path.resolve().as_uri(), new=2)
    except (webbrowser.Error, OSError):
        return False
