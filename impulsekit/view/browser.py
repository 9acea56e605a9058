"""Showing a page or drawing into a running meshcat window, without ever hanging."""

from __future__ import annotations

import math
import os
import pathlib
import sys
import webbrowser
from typing import TYPE_CHECKING, Any

from ..errors import ImpulsekitError
from .drawing import ROOT
from .meshcat_library import packed

if TYPE_CHECKING:
    from .stage import Camera

__all__ = ["send_to", "show_page"]

# How long a meshcat server may take for one command [ms].
PATIENCE = 10_000


def show_page(path: pathlib.Path) -> bool:
    """Open a page in the user's browser; False where there is no display or no browser."""
    graphical = sys.platform in ("win32", "darwin") or any(
        os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER")
    )
    # Without a display Python would start a browser for the terminal and wait for its end.
    if not graphical:
        return False
    try:
        return webbrowser.open(path.resolve().as_uri(), new=2)
    except (webbrowser.Error, OSError):
        return False


def send_to(viewer: Any, commands: list[dict[str, Any]], camera: Camera) -> None:
    """Send commands to the server of a ``meshcat.Visualizer``; an earlier replay makes room.

    Raises:
        ImpulsekitError: its server does not answer.
    """
    import zmq

    socket = viewer.window.zmq_socket
    before = socket.getsockopt(zmq.RCVTIMEO), socket.getsockopt(zmq.SNDTIMEO)
    try:
        socket.setsockopt(zmq.RCVTIMEO, PATIENCE)
        socket.setsockopt(zmq.SNDTIMEO, PATIENCE)
        for command in [{"type": "delete", "path": f"/{ROOT}"}, *commands, _from_afar(camera)]:
            name, path = command["type"], command["path"]
            socket.send_multipart([name.encode(), path.encode(), packed(command)])
            socket.recv()
    except zmq.ZMQError as error:
        raise ImpulsekitError(
            f"the meshcat server at {viewer.window.zmq_url} does not answer ({error}); start a "
            "new meshcat.Visualizer(), or write a page with html="
        ) from None
    finally:
        socket.setsockopt(zmq.RCVTIMEO, before[0])
        socket.setsockopt(zmq.SNDTIMEO, before[1])


def _from_afar(camera: Camera) -> dict[str, Any]:
    """The camera for a window that always looks at the origin: further off, it sees all."""
    view = camera.in_player()
    offset = [p - t for p, t in zip(view["position"], view["target"], strict=True)]
    share = 1.0 + math.hypot(*view["target"]) / math.hypot(*offset)
    return {
        "type": "set_property",
        "path": "/Cameras/default/rotated/<object>",
        "property": "position",
        "value": [share * x for x in offset],
    }
