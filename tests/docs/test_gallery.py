"""The gallery: every example is in it, with a replay and a picture that shows something."""

import re
import shutil
import sys

import pytest

import impulsekit as ik
from impulsekit.impact import ImpactSolver

from .site import is_blank
from .test_pages import DOCS, ROOT


@pytest.fixture
def gallery(monkeypatch, tmp_path):
    """The module that makes it, writing into a folder of its own."""
    monkeypatch.syspath_prepend(str(DOCS))
    import make_gallery

    for name in ("work", "gallery", "extra/moving"):
        (tmp_path / name).mkdir(parents=True)
    for name in ("models", "examples"):
        (tmp_path / "work" / name).symlink_to(ROOT / name)
    monkeypatch.setattr(make_gallery, "GENERATED", tmp_path)
    # What it replaces in the process of a script is put back.
    for home, name in ((ik, "solve"), (ik, "simulate"), (ImpactSolver, "solve"), (sys, "argv")):
        monkeypatch.setattr(home, name, getattr(home, name))
    return make_gallery


def test_every_example_stands_in_one_group(gallery):
    files = [file for group in gallery.GROUPS.values() for file in group]
    examples = [path.name for path in (ROOT / "examples").iterdir()]
    assert sorted(files) == sorted(name for name in examples if name.endswith((".py", ".toml")))


@pytest.mark.slow
def test_examples_have_a_picture_that_is_not_blank(gallery, session_browser, tmp_path):
    # A scene solved, one that is simulated, a script, and one that computes without a scene.
    files = ["billiard.toml", "dropped_ball.toml", "car_crash.py", "tennis_racket.py"]
    for file, seconds in gallery.made_examples(files):
        name = gallery.name_of(file)
        session_browser.page.set_viewport_size({"width": 64, "height": 40})
        gallery.draw_picture(session_browser.page, name)
        assert seconds > 0.0
        picture = tmp_path / f"gallery/{name}.png"
        assert not is_blank(picture)
        text = gallery.page_of(file)
        assert f":target: ../../moving/{name}.html" in text
        assert (tmp_path / f"extra/moving/{name}.html").stat().st_size < 5e6
        assert (DOCS.parent / "examples" / file).exists()
    session_browser.page.set_viewport_size({"width": 800, "height": 500})
    assert "168 impacts" in (tmp_path / "gallery/dropped_ball.txt").read_text()
    count = sum(map(len, gallery.GROUPS.values()))
    assert gallery.list_of_examples().count("grid-item-card") == count


def test_a_failing_example_is_named(gallery, tmp_path, monkeypatch):
    shutil.copytree(ROOT / "examples", tmp_path / "own", ignore=shutil.ignore_patterns("*.npz"))
    (tmp_path / "own/broken.py").write_text("raise ValueError('planted')\n", encoding="utf-8")
    monkeypatch.setattr(gallery, "EXAMPLES", tmp_path / "own")
    with pytest.raises(RuntimeError, match=r"examples/broken\.py: ValueError: planted"):
        gallery._timed("broken.py")


def test_every_how_to_has_a_picture_of_an_example(gallery):
    names = {gallery.name_of(file) for group in gallery.GROUPS.values() for file in group}
    for path in (DOCS / "howto").glob("*.md"):
        text = path.read_text("utf-8")
        shown = re.findall(r"_generated/gallery/(\w+)\.(?:png|md)", text)
        assert set(shown) <= names, path
        assert path.stem == "index" or shown or "ik.plots." in text, path
