"""Pages in a real browser: Debian's chromium, headless, with a software renderer and no network."""

from __future__ import annotations

import os
import pathlib
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest

from impulsekit.view.film import BROWSERS, FLAGS

# No word to the network, besides what the films of pages are drawn with.
QUIET = [
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]
LOCAL = ("file:", "data:", "blob:")

# The matrix of a node in the world, with z up as in the scene instead of y as in the player.
_WORLDS = """(paths) => {
    viewer.scene.updateMatrixWorld(true);
    const back = viewer.scene.matrixWorld.clone().invert();
    return paths.map(path => {
        const node = viewer.scene_tree.find(path.split("/").filter(x => x));
        return back.clone().multiply(node.object.matrixWorld).elements;
    });
}"""
_SEEK = """(t) => {
    viewer.animator.pause();
    viewer.animator.seek(t);
    viewer.animator.display_progress(t);
    viewer.render();
}"""
_SHOWN = """(path) => {
    let node = viewer.scene_tree.find(path.split("/").filter(x => x)).object;
    for (; node; node = node.parent) if (!node.visible) return false;
    return true;
}"""


def chromium() -> str:
    """The browser's path. Without one a test is skipped, but in CI it fails."""
    found = next((path for name in BROWSERS if (path := shutil.which(name))), None)
    if found is None:
        sentence = "no chromium: pages cannot be opened (apt-get install chromium)"
        if os.environ.get("CI"):
            pytest.fail(sentence)
        pytest.skip(sentence)
    return found


@dataclass
class OpenPage:
    """A page that is open, and what went wrong in it."""

    page: Any
    requests: list[str] = field(default_factory=list)
    complaints: list[str] = field(default_factory=list)

    def run(self, script: str, argument: Any = None) -> Any:
        """What a script in the page gives."""
        return self.page.evaluate(script, argument)

    def open(self, path: pathlib.Path) -> None:
        """Load a page from a file."""
        self.page.goto(path.resolve().as_uri())
        self.page.wait_for_function("() => window.ready", timeout=30_000)
        self.run("() => viewer.animator.pause()")

    def leave(self) -> None:
        """Load nothing: a scene that stays open is drawn sixty times a second, by the processor."""
        self.page.goto("about:blank")

    def seek(self, t: float) -> None:
        """Go to a playback time [s]."""
        self.run(_SEEK, t)

    def world(self, path: str) -> np.ndarray:
        """(4, 4) where a node is in the scene."""
        return self.worlds([path])[0]

    def worlds(self, paths: list[str]) -> np.ndarray:
        """(n, 4, 4) where several nodes are in the scene."""
        return np.array(self.run(_WORLDS, paths)).reshape(-1, 4, 4).transpose(0, 2, 1)

    def shown(self, path: str) -> bool:
        """Whether a node and all above it are visible."""
        return self.run(_SHOWN, path)

    def duration(self) -> float:
        """The length of the animation [s]."""
        return self.run("() => viewer.animator.duration")

    def picture(self) -> np.ndarray:
        """(height, width, 3) what is on the screen."""
        import io

        from PIL import Image

        return np.asarray(Image.open(io.BytesIO(self.page.screenshot())).convert("RGB"))


@contextmanager
def browser() -> Iterator[OpenPage]:
    """A browser with one page, for as many files as one likes."""
    path = chromium()
    from playwright.sync_api import sync_playwright

    with sync_playwright() as driver:
        started = driver.chromium.launch(executable_path=path, args=[*FLAGS, *QUIET])
        try:
            context = started.new_context(viewport={"width": 800, "height": 500})
            page = context.new_page()
            opened = OpenPage(page)

            def on_request(route: Any) -> None:
                opened.requests.append(route.request.url)
                route.abort()

            context.route(lambda url: not url.startswith(LOCAL), on_request)
            page.on(
                "console",
                lambda message: (
                    opened.complaints.append(message.text)
                    if message.type in ("error", "warning")
                    else None
                ),
            )
            page.on("pageerror", lambda error: opened.complaints.append(str(error)))
            yield opened
        finally:
            started.close()
