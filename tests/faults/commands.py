"""Faults on the command line."""

# One fault a line, however long.
# ruff: noqa: E501

from __future__ import annotations

import pathlib

from .fault import CommandRefused, Fault
from .things import ARM

SCENE = '[robot]\nurdf = "arm.urdf"\n[[impulses]]\nframe = "hand"\nlinear = [1, 0, 0]\n'


def _command(what: str, *words: str) -> Fault:
    def act() -> None:
        from click.testing import CliRunner

        from impulsekit.cli import main

        pathlib.Path("arm.urdf").write_text(ARM)
        pathlib.Path("good.toml").write_text(SCENE)
        pathlib.Path("notes.txt").write_text("Dear diary\n")
        pathlib.Path("folder").mkdir(exist_ok=True)
        result = CliRunner().invoke(main, list(words), prog_name="impulsekit")
        if result.exit_code:
            # Of what click says about a command's use, the last line is the word.
            raise CommandRefused(result.exit_code, result.stderr.strip().splitlines()[-1])

    return Fault(f"`impulsekit {' '.join(words)}`: {what}", act)


FAULTS = (
    _command("no such command", "sove", "good.toml"),
    _command("no such flag", "solve", "good.toml", "--jsn", "a.json"),
    _command("no file", "solve"),
    _command("one file too many", "solve", "good.toml", "good.toml"),
    _command("a file that does not exist", "solve", "god.toml"),
    _command("a folder", "solve", "folder"),
    _command("a text that is no scene", "solve", "notes.txt"),
    _command("a robot instead of a scene", "solve", "arm.urdf"),
    _command("a form that does not exist", "solve", "good.toml", "--form", "pdf"),
    _command("JSON into a folder that does not exist", "solve", "good.toml", "--json", "no/a.json"),
    _command("JSON onto a folder", "solve", "good.toml", "--json", "folder"),
    _command("a plot of an unknown format", "solve", "good.toml", "--plot", "a.xyz"),
    _command("a page into a folder that does not exist", "solve", "good.toml", "--html", "no/a.html"),
    _command("a negative duration", "simulate", "good.toml", "-t", "-1"),
    _command("a duration in words", "simulate", "good.toml", "-t", "long"),
    _command("no samples", "simulate", "good.toml", "-n", "0"),
    _command("a motion into a folder that does not exist", "simulate", "good.toml", "-o", "no/m.npz"),
    _command("a replay of a text", "replay", "notes.txt", "--html", "a.html"),
    _command("a replay at no frames", "replay", "good.toml", "--html", "a.html", "--fps", "0"),
    _command("a study without [batch]", "batch", "good.toml"),
    _command("no threads", "batch", "good.toml", "--threads", "0"),
    _command("a design without points", "design", "good.toml"),
    _command("a plane that does not exist", "design", "good.toml", "--plane", "zz"),
    _command("an argument that robots does not take", "robots", "panda", "ur5"),
)  # fmt: skip
