"""One self-contained HTML page: meshcat's player, the commands, a bar and a legend.

It needs no server and no network.
"""

from __future__ import annotations

import base64
import html
import json
import math
import zlib
from collections.abc import Sequence
from importlib import resources
from typing import TYPE_CHECKING, Any

from ..errors import ImpulsekitError
from .drawing import ROOT, packed, player_script
from .stage import SUNS

if TYPE_CHECKING:
    from .stage import Camera

# Nothing in the page may ask for anything outside it.
_POLICY = (
    "default-src 'none'; script-src 'unsafe-inline' 'unsafe-eval'; style-src 'unsafe-inline'; "
    "img-src data: blob:; worker-src blob:; connect-src data: blob:"
)

_BAR = """<div id="bar" role="toolbar" aria-label="Playback">
<button id="play" aria-label="Play">\u25b6\ufe0e</button>
<button id="previous" aria-label="Previous impact"
 title="Previous impact (p)">\u2759\u25c0\ufe0e</button>
<button id="next" aria-label="Next impact" title="Next impact (n)">\u25b6\ufe0e\u2759</button>
<div id="track"><div id="marks"></div>
<input id="time" type="range" min="0" max="1" step="any" value="0" aria-label="Time"></div>
<span id="clock" class="clock"></span>
<select id="speed" aria-label="Speed" title="Speed (+ and -)">{speeds}</select>
<button id="arrows" aria-pressed="true" title="Show or hide all arrows (a)">Arrows</button>
<button id="follow" aria-pressed="false" title="Keep the moving bodies centred (f)">Follow</button>
<button id="picture" title="Save this picture as PNG">PNG</button>
<button id="video" title="Save the whole playback as MP4">MP4</button>
<button id="fold" aria-expanded="true" aria-controls="legend"
 title="Fold the legend (l)">Legend</button>
<button id="help" aria-label="Keys" title="Keys (?)">?</button>
</div>
"""
_SPEEDS = (0.05, 0.1, 0.25, 0.5, 1, 2, 4)
_KEYS = """space  play, pause
\u2190 \u2192  a frame back, on; with shift ten
\u2191 \u2193  previous, next impact
Home End  first, last frame
+ \u2212  faster, slower
a  arrows    f  follow    l  legend
r  the first view    g  the player's panel"""


def page_of(title: str, commands: Sequence[dict[str, Any]], **facts: Any) -> str:
    """Return the page.

    Args:
        title: the robot's name, as plain text.
        commands: for the player, in their order.
        facts: data of ``player.js`` and ``film.js``: the "camera" in the player's axes; the
            "clock" with playback and motion times of its knots, None for a still picture;
            "rows" of the legend and its "notes"; "play", "loop", "fps", "frames";
            "impacts", "forces", "groups", "labels" and "followed".
    """
    facts |= {"root": ROOT, "title": title, "suns": list(SUNS)}
    # Inside a script element only "<" can end it or begin a comment.
    text = json.dumps(facts, allow_nan=False).replace("<", "\\u003c")
    blocks = [packed(command) for command in commands]
    whole = b"".join(len(block).to_bytes(4, "big") + block for block in blocks)
    deflated = base64.b64encode(zlib.compress(whole)).decode()
    speeds = "".join(
        f'<option value="{x}"{" selected" if x == 1 else ""}>{x}×</option>' for x in _SPEEDS
    )
    return f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{_POLICY}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<link rel="icon" href="data:,">
<title>{html.escape(title)}</title>
<style>{_beside("player.css")}</style>
</head>
<body>
<div id="meshcat-pane"></div>
<div id="values"><span id="pace"></span><span id="impact" aria-live="polite"></span></div>
<div id="legend"></div>
{_BAR.format(speeds=speeds)}<div id="name" hidden></div>
<div id="keys" hidden>{_KEYS}</div>
<script type="application/json" id="replay">{text}</script>
<script type="text/plain" id="commands">{deflated}</script>
<script>{player_script()}</script>
<script>{_beside("player.js")}</script>
<script>{_beside("film.js")}</script>
</body>
</html>
"""


def _beside(name: str) -> str:
    """Return the text of a file of this package."""
    return resources.files(__package__).joinpath(name).read_text(encoding="utf-8")


# The longest answer of a meshcat server to one command [ms].
PATIENCE = 10_000


def send_to(viewer: Any, commands: list[dict[str, Any]], camera: Camera) -> None:
    """Send commands to the server of a ``meshcat.Visualizer``; an earlier replay is deleted.

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
    """Return the camera for a window that looks at the origin: further off, it sees all."""
    view = camera.in_player()
    offset = [p - t for p, t in zip(view["position"], view["target"], strict=True)]
    share = 1.0 + math.hypot(*view["target"]) / math.hypot(*offset)
    return {
        "type": "set_property",
        "path": "/Cameras/default/rotated/<object>",
        "property": "position",
        "value": [share * x for x in offset],
    }
