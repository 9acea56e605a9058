"""Pictures and videos: of the size and length that they should have, or a clear error."""

import sys

import numpy as np
import pytest

import impulsekit as ik
from impulsekit.errors import MissingExtraError
from impulsekit.measured import Recording
from impulsekit.view import film


@pytest.fixture(scope="module")
def swing():
    robot = ik.Robot.from_urdf(ik.models.pendulum_urdf(2))
    scene = ik.Scene(robot, [ik.AppliedImpulse("link_2", linear=[1, 0, 0], name="blow")])
    impact = ik.solve(scene, robot.neutral(), robot.velocity())
    times = np.linspace(0.0, 0.5, 20)
    q = [robot.neutral() + x for x in times]
    return Recording(robot, times, q, [(0.2, impact)])


def picture_of(path):
    from PIL import Image

    return np.asarray(Image.open(path).convert("RGB")).astype(int)


def test_a_video_has_the_length_and_size_asked_for(swing, page, tmp_path):
    film_of, still = tmp_path / "swing.mp4", tmp_path / "swing.png"
    options = {"fps": 20, "slow_motion": 1.0, "size": (320, 180)}
    shown = ik.replay(swing, video=film_of, picture=still, **options)
    assert shown.page is None
    page.page.goto(film_of.as_uri())
    page.page.wait_for_function("() => document.querySelector('video').readyState >= 2")
    size = page.run("""async () => {
        const film = document.querySelector("video");
        return [film.duration, film.videoWidth, film.videoHeight];
    }""")
    assert size == [pytest.approx(0.5, abs=1e-3), 320, 180]
    drawn = picture_of(still)
    assert drawn.shape == (180, 320, 3)
    # The red of the blow and the blue of the velocity after it are there.
    red, green, blue = drawn.transpose(2, 0, 1)
    assert ((red > 150) & (green < 90) & (blue < 90)).sum() > 20
    assert ((blue > 150) & (red < 90)).sum() > 20


@pytest.mark.parametrize(("button", "start"), [("PNG", b"\x89PNG"), ("MP4", b"\0\0\0\x20ftypisom")])
def test_a_button_saves(swing, page, tmp_path, button, start):
    ik.replay(swing, tmp_path / "page.html", play=False, fps=5, slow_motion=1.0)
    page.page.set_viewport_size({"width": 500, "height": 300})
    page.open(tmp_path / "page.html")
    with page.page.expect_download(timeout=60_000) as saved:
        page.page.get_by_role("button", name=button).click()
    assert saved.value.suggested_filename == f"{swing.robot.name}.{button.lower()}"
    saved.value.save_as(tmp_path / "saved")
    assert (tmp_path / "saved").read_bytes().startswith(start)
    page.page.set_viewport_size({"width": 800, "height": 500})


def test_without_playwright_or_chromium_the_line_to_install_it_is_said(
    swing, tmp_path, monkeypatch
):
    monkeypatch.setattr(film, "BROWSERS", ())
    monkeypatch.setenv("PLAYWRIGHT_BROWSERS_PATH", str(tmp_path))
    with pytest.raises(MissingExtraError, match="playwright install chromium"):
        ik.replay(swing, video=tmp_path / "a.mp4")
    monkeypatch.setitem(sys.modules, "playwright.sync_api", None)
    with pytest.raises(MissingExtraError, match=r"\.\[video\]"):
        ik.replay(swing, picture=tmp_path / "a.png")
