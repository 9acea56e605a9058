"""Built pages in a browser: nothing complains, nothing is fetched, every link leads somewhere."""

from __future__ import annotations

import pathlib
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
    for path in sorted((root / "_images").glob("*.png")):
        faults += [f"{path.name}: a blank picture"] * is_blank(path)
    for path, targets in links.items():
        for target in sorted(targets):
            fault = _dead(target, places)
            if fault:
                faults.append(f"{path.relative_to(root)}: {fault}")
    return len(pages), faults


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
