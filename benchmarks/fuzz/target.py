"""What is done with a fuzzed file, and what may come of it."""

from __future__ import annotations

import json
import pathlib
import sys
import warnings
from dataclasses import dataclass
from random import Random
from typing import Any

import numpy as np

from impulsekit.chain import chain_urdf, pendulum_urdf
from impulsekit.errors import AssumptionWarning, ImpulsekitError, SetupWarning
from impulsekit.impact import Impact, solve
from impulsekit.robot import Robot
from impulsekit.scene import AppliedImpulse, Contact, Scene

from .grammar import mutated, random_scene, random_urdf

KINDS = ("urdf", "scene", "changed urdf", "changed scene")
# Stands in a file that no fuzzed file may get at.
SECRET = "canary-5d41402abc4b"
LONGEST_MESSAGE = 6000
_FORMS = ("text", "markdown", "json")

# What the watch over open files has to know.
_kind_now = [""]


@dataclass(frozen=True)
class Fault(Exception):
    """What a fuzzed file should not have brought about."""

    words: str

    def __str__(self) -> str:
        return self.words


def prepare(folder: pathlib.Path) -> None:
    """Lay out what the files refer to: a chain, models, a mesh, and the secret outside."""
    (folder / "canary.txt").write_text(SECRET)
    inside = folder / "in"
    for name in ("examples", "models"):
        (inside / name).mkdir(parents=True, exist_ok=True)
    (inside / "examples" / "chain.urdf").write_text(chain_urdf(3))
    (inside / "examples" / "a.stl").write_text("solid a\nendsolid a\n")
    for path in _shipped("models", "*.urdf"):
        (inside / "models" / path.name).write_bytes(path.read_bytes())


def _shipped(folder: str, pattern: str) -> list[pathlib.Path]:
    """Files of the checkout."""
    return sorted((pathlib.Path(__file__).parents[2] / folder).glob(pattern))


def _originals(kind: str) -> list[bytes]:
    if kind == "changed scene":
        own = [path.read_bytes() for path in _shipped("examples", "*.toml")]
        plain = '[robot]\nurdf = "chain.urdf"\n[[impulses]]\nframe = "link_1"\nlinear = [0, 1, 0]\n'
        return own or [plain.encode()]
    return [path.read_bytes() for path in _shipped("models", "*.urdf")] + [
        chain_urdf(4).encode(),
        pendulum_urdf(3).encode(),
    ]


def file_of(seed: int, number: int) -> tuple[str, bytes]:
    """Kind and content of a file: always the same for a seed and a number."""
    rng = Random(f"{seed} {number}")
    kind = KINDS[number % len(KINDS)]
    if kind == "urdf":
        return kind, random_urdf(rng).encode("utf-8", "surrogatepass")
    if kind == "scene":
        return kind, random_scene(rng).encode("utf-8", "surrogatepass")
    return kind, mutated(rng, rng.choice(_originals(kind)))


def forbid_leaving(folder: pathlib.Path) -> None:
    """From now on in this process: no network, no other program, no writing elsewhere."""
    own = str(folder)

    def watch(event: str, arguments: tuple[Any, ...]) -> None:
        if event in (
            "socket.connect",
            "subprocess.Popen",
            "os.system",
            "os.exec",
            "os.posix_spawn",
        ):
            raise Fault(f"{event} was called with {arguments!r:.200}")
        if event != "open" or not isinstance(arguments[0], str):
            return
        path, mode = arguments[0], str(arguments[1] or "r")
        writes = any(letter in mode for letter in "wax+")
        if writes and not path.startswith((own, "/dev/")) and "cache" not in path:
            raise Fault(f"{path} was opened to write")
        # A scene file may name the file of its robot; a URDF may name nothing outside.
        if path.endswith("canary.txt") and not _kind_now[0].endswith("scene"):
            raise Fault(f"{path} was read")

    sys.addaudithook(watch)


def try_file(folder: pathlib.Path, kind: str, content: bytes, number: int) -> str:
    """Load a file and strike what it holds; the outcome in a word.

    Raises:
        Fault: it was neither loaded nor refused by an error of ours.
        Exception: likewise, whatever it is.
    """
    of_scene = kind.endswith("scene")
    _kind_now[0] = kind
    path = folder / "in" / "examples" / ("file.toml" if of_scene else "file.urdf")
    path.write_bytes(content)
    rng = Random(number)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        # Scenes made at random are seldom what anybody means.
        warnings.simplefilter("ignore", SetupWarning)
        # What was assumed of a quirk is told, as it should be.
        warnings.simplefilter("ignore", AssumptionWarning)
        # Numbers at the edge of the range overflow; what comes of it is the status's to tell.
        warnings.simplefilter("ignore", RuntimeWarning)
        try:
            impact = _scene_struck(path) if of_scene else _urdf_struck(path, rng)
            if impact is None:
                return "loaded"
            _examine(impact, rng)
            return impact.status.name
        except ImpulsekitError as error:
            _examine_words(str(error))
            return type(error).__name__


def _urdf_struck(path: pathlib.Path, rng: Random) -> Impact | None:
    root = rng.choice(("fixed", "planar", "freeflyer"))
    given: Any = path
    if rng.random() < 0.2:
        try:
            given = "<" + path.read_text(encoding="utf-8").partition("<")[2]
        except UnicodeDecodeError:
            given = path
    robot = Robot.from_urdf(given, root, mimic=rng.random() < 0.3)
    repr(robot)
    _ = robot.links
    if rng.random() < 0.3:
        for name in ("collision_model", "visual_model"):
            try:
                getattr(robot, name)
            except ImpulsekitError as error:
                _examine_words(str(error))
    if robot.nv == 0 or robot.nv > 200:
        return None
    frame = rng.choice(robot.frame_names)
    impulses = [AppliedImpulse(frame, linear=[0.3, -0.2, 1.0], at=[0.1, 0.2, 0.0])]
    contacts = [Contact(frame, restitution=0.5, friction=0.3)] if rng.random() < 0.3 else []
    scene = Scene(robot, impulses, contacts=contacts)
    v = np.ones(robot.nv) if rng.random() < 0.5 else robot.velocity()
    return solve(scene, robot.neutral(), -v)


def _scene_struck(path: pathlib.Path) -> Impact:
    from impulsekit.scenefile import load_scene

    file = load_scene(path)
    return solve(file.scene, file.q, file.v)


def _examine(impact: Impact, rng: Random) -> None:
    """Prove that an answer is a number or says that it is none, and that it can be shown."""
    if impact.is_valid() and not np.isfinite(impact.v_after).all():
        raise Fault(f"{impact.status.name}, and v_after is {impact.v_after}")
    if rng.random() < 0.1:
        from impulsekit.view.report import report

        for form in _FORMS:
            _examine_words(report(impact, form=form), longest=10**7)
        json.dumps(impact.to_dict())
    if rng.random() < 0.01:
        from impulsekit.view.replay import replay

        page = replay(impact).html
        body = page[: page.index("<script>")]
        if "<script>alert" in body or "</title><" in body:
            raise Fault("a name is markup in the page")


def _examine_words(text: str, longest: int = LONGEST_MESSAGE) -> None:
    """Prove that a text is fit for a terminal and tells nothing that it should not."""
    if not text or len(text) > longest:
        raise Fault(f"a message of {len(text)} characters: {text[:200]!r}")
    for character in text:
        if character != "\n" and not character.isprintable():
            raise Fault(f"U+{ord(character):04X} in {text[:300]!r}")
    for inner in (SECRET, "Traceback", " object at 0x", "root:x:", "pinocchio::", "/project/"):
        if inner in text:
            raise Fault(f'"{inner}" in {text[:300]!r}')
