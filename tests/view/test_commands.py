"""The command's pages and sheets."""

import pathlib

import matplotlib
import numpy as np
import pytest
from click.testing import CliRunner

matplotlib.use("Agg")

import impulsekit as ik
from impulsekit.cli import main

EXAMPLES = pathlib.Path(__file__).parents[2] / "examples"
CHAIN = str(EXAMPLES / "whittaker_chain.toml")


def run(*arguments):
    return CliRunner().invoke(main, list(arguments))


@pytest.mark.slow
def test_solve_writes_a_page_and_a_sheet(tmp_path):
    page, sheet = tmp_path / "page.html", tmp_path / "sheet.png"
    done = run("solve", CHAIN, "--html", str(page), "--plot", str(sheet))
    assert done.exit_code == 0, done.output
    assert done.stderr == ""
    assert "17.321" in done.stdout
    assert page.read_text().startswith("<!DOCTYPE html>")
    assert sheet.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(("form", "start"), [("markdown", "# whittaker"), ("json", "{")])
def test_solve_in_other_forms(form, start):
    done = run("solve", CHAIN, "--form", form)
    assert done.exit_code == 0
    assert done.stdout.startswith(start)


def test_replay_of_a_scene(tmp_path):
    page = tmp_path / "page.html"
    done = run("replay", CHAIN, "--html", str(page), "--reactions", "--traces", "--ghost", "0")
    assert done.exit_code == 0, done.output
    assert done.stdout.strip() == str(page)
    assert "path of struck end" in page.read_text()
    assert "joint reaction" in page.read_text()


def test_replay_of_a_saved_motion(tmp_path):
    robot = ik.Robot.from_urdf(ik.models.chain_urdf(3), root="planar")
    motion = ik.simulate(ik.Scene(robot), robot.neutral(), np.ones(robot.nv), duration=0.2)
    motion.save(tmp_path / "motion.npz")
    done = run("replay", str(tmp_path / "motion.npz"), "--html", str(tmp_path / "page.html"))
    assert done.exit_code == 0, done.output
    assert (tmp_path / "page.html").stat().st_size > 800_000


@pytest.mark.slow
def test_replay_as_a_video(tmp_path):
    video = tmp_path / "chain.mp4"
    done = run("replay", CHAIN, "--video", str(video), "--fps", "2")
    assert done.exit_code == 0, done.output
    assert done.stdout == f"{video}\n"
    assert video.read_bytes()[4:12] == b"ftypisom"


def test_replay_without_a_display_says_where_the_page_is(monkeypatch):
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER"):
        monkeypatch.delenv(name, raising=False)
    done = run("replay", CHAIN)
    assert done.exit_code == 0
    page = pathlib.Path(done.stdout.strip())
    assert f"no browser could be opened; the page is {page}" in done.stderr
    page.unlink()


def test_simulate_writes_a_page_and_a_sheet(tmp_path):
    page, sheet = tmp_path / "page.html", tmp_path / "sheet.png"
    done = run("simulate", CHAIN, "-t", "0.2", "--html", str(page), "--plot", str(sheet))
    assert done.exit_code == 0, done.output
    assert done.stderr == ""
    assert page.stat().st_size > 800_000
    assert sheet.read_bytes().startswith(b"\x89PNG")
