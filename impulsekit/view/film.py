"""Videos and pictures of a page, drawn frame by frame in a headless Chromium."""

from __future__ import annotations

import base64
import pathlib
import shutil
import tempfile
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from typing import Any

from ..errors import ImpulsekitError, MissingExtraError, RangeError
from ..files import ENDINGS, checked_output, write_file

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")
# WebGL by the processor: the same pixels with a graphics card and without one.
FLAGS = (
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-dev-shm-usage",
    "--hide-scrollbars",
)
# For a frame of a large robot on a busy machine, and for an hour of video [ms].
PATIENCE = 3_600_000
# The largest picture in H.264 [px].
LARGEST = 4096


def checked_films(video: Any, picture: Any, size: tuple[int, int]) -> dict[str, Any]:
    """Return the path of each kind that is asked for, and the "size"; empty if none is.

    Raises:
        InputError: a path that does not end as it should.
        RangeError: a size that no video has.
        FileError: a file that cannot be written.
    """
    found: dict[str, Any] = {}
    for kind, path in (("video", video), ("picture", picture)):
        if path is None:
            continue
        found[kind] = checked_output(path, f"replay: {kind}", *ENDINGS[kind])
    if found:
        if len(size) != 2 or not all(16 <= n <= LARGEST and n % 2 == 0 for n in size):
            raise RangeError.of("replay: size", size, f"two even numbers from 16 to {LARGEST}")
        found["size"] = (int(size[0]), int(size[1]))
    return found


def draw_films(
    page: str, wishes: Mapping[str, Any], tell: Callable[[float], None] | None = None
) -> None:
    """Draw the video and the picture of a page's text, whichever are wished for.

    Args:
        tell: called with the share of the video that is drawn.

    Raises:
        MissingExtraError: playwright or Chromium is missing.
        ImpulsekitError: the browser could not draw or encode them.
    """
    if wishes:
        # A thread of its own: a notebook's event loop leaves no place for the browser's.
        with ThreadPoolExecutor(1) as pool:
            pool.submit(_draw, page, wishes, tell).result()


def _draw(page: str, wishes: Mapping[str, Any], tell: Callable[[float], None] | None) -> None:
    width, height = wishes["size"]
    with tempfile.TemporaryDirectory() as folder, headless(width, height) as tab:
        path = pathlib.Path(folder) / "page.html"
        path.write_text(page, encoding="utf-8")
        if tell is not None:
            tab.expose_function("told", tell)
        tab.goto(path.as_uri())
        tab.wait_for_function("() => window.ready")
        for kind in ("video", "picture"):
            if kind in wishes:
                try:
                    arguments = "w, h, window.told" if kind == "video" else "w, h"
                    drawn = tab.evaluate(f"([w, h]) => films.{kind}({arguments})", [width, height])
                except Exception as error:
                    raise ImpulsekitError(f"replay: no {kind} could be drawn: {error}") from None
                write_file(wishes[kind], base64.b64decode(drawn))


@contextmanager
def headless(width: int, height: int) -> Iterator[Any]:
    """Open a tab of a headless Chromium.

    Raises:
        MissingExtraError: playwright or Chromium is missing.
    """
    with MissingExtraError.unless("playwright", "video", "a video or picture of a replay"):
        from playwright.sync_api import Error, sync_playwright
    own = next((path for name in BROWSERS if (path := shutil.which(name))), None)
    with sync_playwright() as driver:
        try:
            browser = driver.chromium.launch(executable_path=own, args=list(FLAGS))
        except Error as error:
            raise MissingExtraError(
                "a video or picture of a replay needs Chromium: apt install chromium, or "
                f"playwright install chromium ({str(error).splitlines()[0]})",
                package="chromium",
                extra="video",
            ) from None
        try:
            tab = browser.new_page(viewport={"width": width, "height": height})
            tab.set_default_timeout(PATIENCE)
            yield tab
        finally:
            browser.close()
