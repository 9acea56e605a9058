"""The examination of built pages finds what it is for; ``python -m tests.docs`` runs it on all."""

import re

import pytest

from .site import SEARCHED, examine, repeated_pictures, unfound_words

WHOLE = '<!DOCTYPE html><html><head><link rel="icon" href="data:,"></head><body id="top">{}</body>'


@pytest.mark.parametrize(
    ("body", "fault"),
    [
        ('<a href="other.html#there">a page</a> <a href="https://example.org">a site</a>', None),
        ('<a href="gone.html">a page</a>', "dead link to .*gone.html"),
        ('<a href="other.html#nowhere">a place</a>', "no place nowhere in other.html"),
        ("<script>console.error('broken')</script>", "complains: broken"),
        ("<script>throw new Error('thrown')</script>", "complains: .*thrown"),
        ('<img src="http://127.0.0.1:9/picture.png">', "asks for http://127.0.0.1:9/picture.png"),
        ('<img src="other.html">', "no picture in .*other.html"),
        ('<p style="width: 900px">wide</p>', "at 400 px the page overflows to the right"),
        (
            '<div class="cell_input"><pre style="width: 90px; overflow-x: auto">'
            + 40 * "code"
            + "</pre></div>",
            "at 400 px code is cut: codecode.*",
        ),
    ],
)
def test_what_is_wrong_with_a_page_is_found(tmp_path, session_browser, body, fault):
    (tmp_path / "index.html").write_text(WHOLE.format(body))
    (tmp_path / "other.html").write_text(WHOLE.format('<p id="there"></p>'))
    count, faults = examine(tmp_path, session_browser)
    assert count == 2
    if fault is None:
        assert faults == []
    else:
        assert any(re.fullmatch(f"index.html: {fault}", each) for each in faults), faults


def test_a_blank_picture_is_found(tmp_path, session_browser):
    from PIL import Image, ImageDraw

    (tmp_path / "index.html").write_text(WHOLE.format(""))
    (tmp_path / "_images").mkdir()
    # A replay's sky and floor, without and with a thin arrow.
    picture = Image.new("RGB", (640, 400), (230, 237, 245))
    ImageDraw.Draw(picture).rectangle([0, 200, 640, 400], fill=(204, 209, 214))
    picture.save(tmp_path / "_images/blank.png")
    ImageDraw.Draw(picture).line([300, 100, 300, 180], fill=(199, 51, 33), width=3)
    picture.save(tmp_path / "_images/arrow.png")
    _, faults = examine(tmp_path, session_browser)
    assert faults == ["blank.png: a blank picture"]


def test_a_picture_that_is_there_twice_is_found(tmp_path):
    for name in ("first.png", "second.png"):
        (tmp_path / name).write_bytes(b"the same")
    (tmp_path / "third.png").write_bytes(b"another")
    assert repeated_pictures(tmp_path) == ["second.png: the same picture as first.png"]


def test_a_word_that_no_page_has_is_found(tmp_path):
    (tmp_path / "searchindex.js").write_text("")
    words = " ".join(word for word in SEARCHED if word != "drag")
    (tmp_path / "index.html").write_text(WHOLE.format(f"<p>{words}</p>"))
    assert unfound_words(tmp_path) == ["drag"]
