"""The gallery: each example is run, and gets its output, a replay, a picture and plots."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import re
import runpy
import sys
import time
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
ROOT = HERE.parent
EXAMPLES = ROOT / "examples"
GENERATED = HERE / "_generated"
# Each example stands in one group, by its file's name.
GROUPS = {
    "Struck chains and linkages": (
        "whittaker_chain.toml", "pendulum_10.toml", "pendulum_peg.toml", "rhombus.toml",
        "four_bar.toml", "struck_four_bar.py", "draw_figure_2.py", "draw_figure_3.py",
        "draw_struck_chain.py", "falling_chain.py",
    ),
    "Balls": (
        "bouncing_ball.toml", "dropped_ball.toml", "billiard.toml", "billiard_sequential.toml",
        "newtons_cradle.py", "hopper_to_target.py", "planned_bounce.py",
    ),
    "Arms and hands": (
        "thrown_ball.toml", "replay_thrown_ball.py", "panda_ball.toml", "caught_ball.toml",
        "ball_in_moving_gripper.py", "stopped_door.toml", "stopped_door.py",
        "wall_hit_by_ur5.py", "arm_against_hand.py", "catch_by_a_panda.py",
    ),
    "Legged robots and walkers": (
        "solo12_landing.toml", "dropped_solo12.toml", "landing_study.toml",
        "knee_sparing_landing.py", "talos_hand.toml", "talos_heel_strike.toml",
        "strike_a_hand.py", "rimless_wheel.py", "compass_gait.py",
    ),
    "Inside MuJoCo": (
        "ball_on_arm.py", "box_in_mujoco.py", "juggling_paddle.py", "landing_in_mujoco.py",
    ),
    "Tools, doors, vehicles: what the hand and the hinge feel": (
        "hammer.toml", "hammer_nail.toml", "nail_by_a_panda.py", "hammer_blow.py",
        "spared_hinges.toml", "door_stop.py", "golf_swing.py", "tennis_racket.py",
        "gun_recoil.py", "car_crash.py",
    ),
    "Laws of contact, compared and measured": (
        "falling_rod.toml", "falling_rod.py", "rocking_block.toml", "rocking_block.py",
        "rough_floor.toml", "rough_floor.py", "bounced_ball.toml", "cube_tosses.toml",
        "which_law.py", "dropped_phone.py", "racket_rubbers.py",
    ),
}  # fmt: skip
# [s] Of a scene whose file has no duration although nothing touches at its start.
DURATIONS = {"cube_tosses.toml": 1.0}
# Its shell flies off for a mile: the shot is shown, not the motion.
SHOTS = ("gun_recoil.py",)
PICTURE = (640, 400)  # [px]
WORDS = """Every file of the folder `examples`, by subject. A page has the picture, an interactive
replay that opens without a network, the output and the source.
`impulsekit solve examples/NAME.toml` solves a scene, `python examples/NAME.py` runs a script.
"""
# Where the usual view hides what happens.
CAMERAS: dict[str, Any] = {
    "stopped_door.toml": "back",
    "stopped_door.py": ((-2.2, 2.6, 1.6), (0.3, 0.0, 0.8)),
    "billiard_sequential.toml": "left",
    "replay_thrown_ball.py": "left",
}
# Names that a title writes otherwise.
PROPER = {
    "talos": "Talos", "panda": "Panda", "solo12": "Solo12", "ur5": "UR5",
    "whittaker": "Whittaker's", "newtons": "Newton's", "mujoco": "MuJoCo",
}  # fmt: skip


def name_of(file: str) -> str:
    """Return the name of an example's page."""
    return file.removesuffix(".toml").replace(".py", "_py")


def title_of(file: str) -> str:
    """Return the title of an example's page, of its file's name."""
    stem, _, kind = file.partition(".")
    words = " ".join(PROPER.get(word, word) for word in stem.split("_"))
    both = {f"{stem}.py", f"{stem}.toml"} <= {name for group in GROUPS.values() for name in group}
    return words[0].upper() + words[1:] + (", in Python" if both and kind == "py" else "")


def first_words(path: Path) -> str:
    """Return the sentences that an example begins with."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".py":
        return re.match(r'"""(.*?)(?:\n\n|""")', text, re.S)[1].replace("\n", " ").strip()
    lines = []
    for line in text.splitlines():
        if not line.startswith("#") or line.startswith("#  "):
            break
        lines.append(line.removeprefix("#").strip())
    return " ".join(lines)


def run_example(file: str) -> float:
    """Run an example: writes its output, page and plots; gives the seconds that it took.

    Raises:
        RuntimeError: it fails.
    """
    import matplotlib

    import impulsekit as ik

    begin = time.perf_counter()
    matplotlib.use("Agg")
    os.chdir(GENERATED / "work")
    name = name_of(file)
    place = GENERATED / "gallery" / name
    warnings.simplefilter("ignore")
    with open(f"{place}.txt", "w", encoding="utf-8") as out, contextlib.redirect_stdout(out):
        show = _solved if file.endswith(".toml") else _script
        subject, points = show(EXAMPLES / file)
        page = GENERATED / f"extra/moving/{name}.html"
        ik.replay(subject, page, points=points, fps=30.0, camera=CAMERAS.get(file))
        if file.endswith(".toml"):
            ik.plots.overview(subject, f"{place}_plots.png")
    return time.perf_counter() - begin


def _solved(path: Path) -> tuple[Any, Any]:
    """Run a scene file by the command; gives what the command computed, and the file's points."""
    import impulsekit as ik
    from impulsekit import impact, motion, scenefile
    from impulsekit.cli import main

    file, command = ik.load_scene(path), ["solve"]
    duration = file.motion.duration if file.motion else DURATIONS.get(path.name)
    if duration is not None:
        command = ["simulate", "--duration", str(duration), "--quiet"]
    scenefile.load_scene = lambda _: file
    seen: list[Any] = []
    _note(seen, impact, "solve")
    _note(seen, motion, "simulate")
    main([*command, str(path)], standalone_mode=False)
    return seen[0], file.points if duration is None else ()


def _script(path: Path) -> tuple[Any, Any]:
    """Run a script; gives its last motion, the middle one of its impacts, or a stand-in."""
    from stand_ins import STAND_INS

    import impulsekit as ik
    from impulsekit.impact import ImpactSolver

    impacts: list[Any] = []
    motions: list[Any] = []
    _note(impacts, ik, "solve")
    _note(impacts, ImpactSolver, "solve")
    _note(motions, ik, "simulate")
    picture = [f"{GENERATED / 'gallery' / name_of(path.name)}_drawn.png"]
    sys.argv = [str(path), *(picture if path.name.startswith("draw_") else [])]
    names = runpy.run_path(str(path), run_name="__main__")
    if path.name in STAND_INS:
        return STAND_INS[path.name](names), ()
    if path.name in SHOTS:
        return motions[-1].impacts[0][1], ()
    return (motions[-1] if motions else impacts[len(impacts) // 2]), ()


def _note(seen: list[Any], home: Any, name: str) -> None:
    """Replace a function by one whose results are noted."""
    function = getattr(home, name)

    def noted(*args: Any, **options: Any) -> Any:
        seen.append(function(*args, **options))
        return seen[-1]

    setattr(home, name, noted)


def made_examples(files: list[str]) -> Iterator[tuple[str, float]]:
    """Run examples in processes of their own; gives each when it is done, with its seconds."""
    import trimesh.exchange.dae  # noqa: F401

    import impulsekit.cli  # noqa: F401
    from impulsekit import load_scene, plots, replay, simulate, solve  # noqa: F401

    # What the processes share is loaded once, here.
    file = load_scene(EXAMPLES / "billiard.toml")
    impact = solve(file.scene, file.q, file.v)
    replay(impact)
    plots.overview(impact, GENERATED / "work/first.png")
    with multiprocessing.get_context("fork").Pool(2, maxtasksperchild=1) as pool:
        yield from pool.imap_unordered(_timed, files, chunksize=1)


def _timed(file: str) -> tuple[str, float]:
    try:
        return file, run_example(file)
    except (Exception, SystemExit) as error:
        raise RuntimeError(f"examples/{file}: {type(error).__name__}: {error}") from error


def draw_picture(tab: Any, name: str) -> None:
    """Draw the picture of an example's page in a tab of a browser."""
    import base64

    tab.goto((GENERATED / f"extra/moving/{name}.html").as_uri())
    tab.wait_for_function("() => window.ready")
    drawn = tab.evaluate("([w, h]) => films.picture(w, h)", list(PICTURE))
    # A page that stays open is drawn sixty times a second.
    tab.goto("about:blank")
    (GENERATED / "gallery" / f"{name}.png").write_bytes(base64.b64decode(drawn))


def page_of(file: str) -> str:
    """Return the page of an example that has been run."""
    name, path = name_of(file), EXAMPLES / file
    place = GENERATED / "gallery" / name
    text = Path(f"{place}.txt").read_text(encoding="utf-8").rstrip()
    moving = f"../../moving/{name}.html"
    made = [f"# {title_of(file)}\n", first_words(path), "", f"From `examples/{file}`.", ""]
    made += [f"```{{image}} {name}.png", f":alt: {title_of(file)}, as a picture"]
    made += [f":target: {moving}", "```\n"]
    made += [f'<a class="reference external" href="{moving}">Open the interactive replay</a>\n']
    for kind, words in (("drawn", "what the script draws"), ("plots", "its numbers as plots")):
        if Path(f"{place}_{kind}.png").exists():
            made += [f"![{file}: {words}]({name}_{kind}.png)\n"]
    if text:
        made += ["## Output\n", "```text", text, "```\n"]
    language = "toml" if path.suffix == ".toml" else "python"
    relative = os.path.relpath(path, GENERATED / "gallery")
    made += ["## Source\n", f"```{{literalinclude}} {relative}", f":language: {language}", "```\n"]
    return "\n".join(made)


def list_of_examples() -> str:
    """Return the gallery's first page: thumbnails by subject."""
    made = ["# Gallery\n", WORDS]
    for title, files in GROUPS.items():
        made += [f"## {title}\n", "::::{grid} 2 2 3 3", ":gutter: 2\n"]
        for file in files:
            words = re.split(r"(?<!\bp)[.:] |\.$", first_words(EXAMPLES / file))[0]
            picture = f"{name_of(file)}{'_drawn' if file.startswith('draw_') else ''}.png"
            made += [f":::{{grid-item-card}} {title_of(file)}", f":img-top: {picture}",
                     f":link: {name_of(file)}", ":link-type: doc", words, ":::"]  # fmt: skip
        made += ["::::\n"]
    pages = [name_of(file) for files in GROUPS.values() for file in files]
    return "\n".join([*made, "```{toctree}", ":hidden:", *pages, "```\n"])


def write_gallery(say: Callable[[str], None], write: Callable[[Path, str], None]) -> None:
    """Write a page for each example, and the list of them.

    Args:
        say: takes a line for whoever waits.
        write: takes the path and the text of a page.
    """
    from impulsekit.view.film import headless

    (GENERATED / "gallery").mkdir(parents=True, exist_ok=True)
    files = [file for group in GROUPS.values() for file in group]
    with headless(64, 40) as tab:
        for number, (file, seconds) in enumerate(made_examples(files), 1):
            draw_picture(tab, name_of(file))
            write(GENERATED / "gallery" / f"{name_of(file)}.md", page_of(file))
            say(f"example {number} of {len(files)}: {file}, {seconds:.1f} s")
    write(GENERATED / "gallery" / "index.md", list_of_examples())
