"""Built pages in a browser: nothing complains, nothing is fetched, every link leads somewhere."""

from __future__ import annotations

import hashlib
import pathlib
import re
from urllib.parse import unquote, urlsplit

import numpy as np

from ..view.browser import OpenPage

# Of 0 to 255: darker than this, or with channels that differ by more, is no floor or sky.
DARK, COLORFUL = 120, 60
# The share of a picture that the smallest subject takes, a chain of thin rods.
LEAST_DRAWN = 2e-4

# Where links, pictures, scripts and styles of a page lead to, and the names of its places.
_LINKS = """() => [...document.querySelectorAll("a[href], link[href], img[src], script[src]")]
    .map(node => node.href || node.src)"""
_PLACES = """() => [...document.querySelectorAll("[id]")].map(node => node.id)"""
_BROKEN = (
    """() => [...document.images].filter(x => x.complete && !x.naturalWidth).map(x => x.src)"""
)
# Wider than the page at the width of a telephone, and code that is cut off there.
_WIDE = """() => {
    const root = document.documentElement, found = [];
    if (root.scrollWidth > root.clientWidth + 1) found.push("the page overflows to the right");
    for (const pre of document.querySelectorAll(".cell_input pre"))
        if (pre.scrollWidth > pre.clientWidth + 1)
            found.push("code is cut: " + pre.textContent.slice(0, 40));
    return found;
}"""
TELEPHONE = 400  # [px]
# Words that visitors look for.
SEARCHED = (
    "gym", "drag", "drop test", "self collision", "video", "inverse dynamics", "cite", "install",
    "windows", "conda", "wheel", "restitution", "friction", "coulomb", "newton", "poisson",
    "stronge", "collision", "contact", "impulse", "mujoco", "urdf", "mjcf", "sdf", "xacro",
    "gradient", "torch", "jax", "batch", "dask", "replay", "meshcat", "energy", "hammer", "landing",
    "peak force", "percussion", "whittaker", "kane", "uniqueness",
)  # fmt: skip


def examine(folder: str | pathlib.Path, opened: OpenPage) -> tuple[int, list[str]]:
    """Open every page below a folder: how many there are, and what is wrong, a line each.

    Args:
        folder: of the built pages.
        opened: a page of a browser, as ``tests.view.browser.browser`` gives it.
    """
    root = pathlib.Path(folder).resolve()
    pages = sorted(root.rglob("*.html"))
    links: dict[pathlib.Path, set[str]] = {}
    places: dict[pathlib.Path, set[str]] = {}
    faults: list[str] = []
    for path in pages:
        name = path.relative_to(root)
        opened.requests.clear()
        opened.complaints.clear()
        opened.page.goto(path.as_uri(), wait_until="load")
        links[path] = set(opened.run(_LINKS))
        places[path] = set(opened.run(_PLACES))
        faults += [f"{name}: asks for {url}" for url in opened.requests]
        faults += [f"{name}: complains: {words}" for words in opened.complaints]
        faults += [f"{name}: no picture in {url}" for url in opened.run(_BROKEN)]
        if "moving" not in name.parts:
            faults += _in_other_ways(opened, name)
    for path in sorted((root / "_images").glob("*.png")):
        faults += [f"{path.name}: a blank picture"] * is_blank(path)
    faults += repeated_pictures(root / "_images")
    faults += [f"search finds nothing for {word}" for word in unfound_words(root)]
    for path, targets in links.items():
        for target in sorted(targets):
            fault = _dead(target, places)
            if fault:
                faults.append(f"{path.relative_to(root)}: {fault}")
    return len(pages), faults


def _in_other_ways(opened: OpenPage, name: pathlib.Path) -> list[str]:
    """What is wrong with the open page as wide as a telephone, and in the dark."""
    page = opened.page
    before, size = len(opened.complaints), page.viewport_size
    page.set_viewport_size({"width": TELEPHONE, "height": 800})
    faults = [f"{name}: at {TELEPHONE} px {words}" for words in opened.run(_WIDE)]
    page.emulate_media(color_scheme="dark")
    opened.run("() => new Promise(requestAnimationFrame)")
    page.emulate_media(color_scheme="light")
    page.set_viewport_size(size)
    return faults + [f"{name}: complains: {words}" for words in opened.complaints[before:]]


def repeated_pictures(folder: pathlib.Path) -> list[str]:
    """A line for each picture that is there twice under different names."""
    seen: dict[str, str] = {}
    faults = []
    for path in sorted(folder.glob("*.png")):
        first = seen.setdefault(hashlib.sha256(path.read_bytes()).hexdigest(), path.name)
        if first != path.name:
            faults.append(f"{path.name}: the same picture as {first}")
    return faults


def unfound_words(root: pathlib.Path) -> list[str]:
    """The words of ``SEARCHED`` that no page holds, by the text that the search indexes."""
    if not (root / "searchindex.js").exists():
        return []
    texts = [
        re.sub(r"<[^>]+>", " ", path.read_text(encoding="utf-8")).lower()
        for path in root.rglob("*.html")
        if "moving" not in path.parts
    ]
    return [word for word in SEARCHED if not any(word in text for text in texts)]


def is_blank(path: pathlib.Path) -> bool:
    """Whether a picture shows nothing but paper, or a replay's pale floor and sky."""
    from PIL import Image

    pixels = np.asarray(Image.open(path).convert("RGB")).astype(int)
    # Bodies, arrows and ink are darker or more colourful than floor, grid and sky.
    drawn = (pixels.mean(axis=2) < DARK) | (np.ptp(pixels, axis=2) > COLORFUL)
    return bool(drawn.mean() < LEAST_DRAWN)


def _dead(url: str, places: dict[pathlib.Path, set[str]]) -> str | None:
    """What is wrong with a link to a file; links to other sites are not followed."""
    parts = urlsplit(url)
    if parts.scheme != "file":
        return None
    target = pathlib.Path(unquote(parts.path))
    if not target.is_file():
        return f"dead link to {url}"
    known = places.get(target)
    if known is not None and parts.fragment and unquote(parts.fragment) not in known:
        return f"no place {parts.fragment} in {target.name}"
    return None
