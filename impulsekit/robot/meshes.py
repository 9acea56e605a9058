"""Each mesh is read once while a robot that shows it is there."""

from __future__ import annotations

import html
import os
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any
from weakref import WeakValueDictionary

__all__ = ["Stamp", "loader_of", "mesh_paths"]

Stamp = tuple[str, int, int]
"""A file, when it was written [ns], and its size."""

_FILENAME = re.compile(r"""filename=(["'])(.*?)\1""")
_loaders: WeakValueDictionary[frozenset[Stamp], Any] = WeakValueDictionary()


def mesh_paths(shapes: Mapping[str, Sequence[str]]) -> set[str]:
    """The meshes that elements written by ``checked_shapes`` name."""
    written = (shape for of_link in shapes.values() for shape in of_link)
    return {html.unescape(path) for shape in written for _, path in _FILENAME.findall(shape)}


def loader_of(paths: Iterable[str]) -> Any:
    """coal's reader of these meshes, which keeps what it has read as long as somebody keeps it.

    Files that were written anew are read anew.
    """
    import coal

    stamps = frozenset(stamp for path in paths if (stamp := _stamp(path)) is not None)
    loader = _loaders.get(stamps)
    if loader is None:
        loader = _loaders[stamps] = coal.CachedMeshLoader()
    return loader


def _stamp(path: str) -> Stamp | None:
    try:
        found = os.stat(path)
    except OSError:
        return None
    return path, found.st_mtime_ns, found.st_size
