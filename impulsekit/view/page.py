"""One self-contained HTML page: meshcat's player, the commands, a legend. No server, no network."""

from __future__ import annotations

import base64
import html
import json
from typing import TYPE_CHECKING, Any

from .meshcat_library import packed, player_script
from .stage import SUNS

if TYPE_CHECKING:
    from .stage import Camera

__all__ = ["page_of"]

# Nothing in the page may ask for anything outside it.
_POLICY = (
    "default-src 'none'; script-src 'unsafe-inline' 'unsafe-eval'; style-src 'unsafe-inline'; "
    "img-src data: blob:; worker-src blob:; connect-src data: blob:"
)

_STYLE = """
html, body { margin: 0; height: 100%; background: #eef1f4; }
#meshcat-pane { width: 100vw; height: 100vh; overflow: hidden; }
#legend {
  position: absolute; left: 14px; bottom: 12px; padding: 9px 12px; max-width: 44em;
  font: 13px/1.5 system-ui, sans-serif; color: #22303c; background: rgba(255, 255, 255, .82);
  border-radius: 6px; pointer-events: none; overflow-wrap: anywhere;
}
#legend b { font-weight: 600; }
#legend .clock { font-variant-numeric: tabular-nums; }
#legend i { display: inline-block; width: 18px; height: 4px; margin-right: 7px;
  border-radius: 2px; vertical-align: middle; }
#trouble { position: absolute; inset: 40% 10% auto; text-align: center;
  font: 15px/1.5 system-ui, sans-serif; color: #8b1e1e; }
"""

# The legend is built of text nodes alone, so no name in it is ever read as markup.
_LEGEND = """
function legendOf(facts) {
  const legend = document.getElementById("legend");
  const line = (bold, text, color) => {
    const row = document.createElement("div");
    if (color) {
      const swatch = document.createElement("i");
      swatch.style.background = color;
      row.append(swatch);
    }
    const word = document.createElement(bold ? "b" : "span");
    word.textContent = text;
    row.append(word);
    legend.append(row);
    return word;
  };
  line(true, facts.title);
  const clock = facts.clock ? line(false, "") : null;
  if (clock) clock.className = "clock";
  for (const row of facts.rows) line(false, row.text, row.color);
  for (const note of facts.notes) line(false, note);
  return clock;
}
function motionTime(clock, t) {
  const [played, moved] = [clock.played, clock.moved];
  let i = 1;
  while (i < played.length - 1 && t > played[i]) i++;
  const span = played[i] - played[i - 1];
  const share = span > 0 ? Math.min(Math.max((t - played[i - 1]) / span, 0), 1) : 1;
  const rate = span > 0 ? (moved[i] - moved[i - 1]) / span : 1;
  return [moved[i - 1] + share * (moved[i] - moved[i - 1]), rate];
}
function runClock(viewer, word, clock) {
  const show = () => {
    const [t, rate] = motionTime(clock, viewer.animator.time);
    const value = (t * clock.scale).toFixed(clock.digits);
    const pace = Math.abs(rate - 1) < 1e-6 ? "" :
      rate < 1 ? ", slowed " + Number((1 / rate).toPrecision(2)) + " times" :
      ", sped up " + Number(rate.toPrecision(2)) + " times";
    word.textContent = "t = " + value + " " + clock.unit + pace;
    requestAnimationFrame(show);
  };
  show();
}
"""

_START = """
const replay = JSON.parse(document.getElementById("replay").textContent);
const clockWord = legendOf(replay);
let viewer;
try {
  viewer = new MeshCat.Viewer(document.getElementById("meshcat-pane"));
  for (const block of document.querySelectorAll("script.command")) {
    const bytes = Uint8Array.from(atob(block.textContent), c => c.charCodeAt(0));
    viewer.handle_command_bytearray(bytes);
  }
  if (replay.camera) {
    viewer.camera.up.set(...replay.camera.up);
    viewer.set_camera(viewer.camera);
    viewer.camera.position.set(...replay.camera.position);
    viewer.controls.target.set(...replay.camera.target);
    viewer.controls.update();
    // A sun shines on the middle of the picture, not on the origin.
    for (const name of replay.suns) {
      const sun = viewer.scene_tree.find(["Lights", name, "<object>"]).object;
      sun.target.position.set(...replay.camera.target);
      sun.target.updateMatrixWorld();
    }
  }
  if (!replay.play) viewer.animator.pause();
  if (replay.clock) runClock(viewer, clockWord, replay.clock);
  viewer.set_dirty();
} catch (error) {
  const trouble = document.createElement("div");
  trouble.id = "trouble";
  trouble.textContent = "This page needs WebGL, which this browser does not offer: " + error;
  document.body.append(trouble);
  throw error;
}
"""


def page_of(
    title: str,
    commands: list[dict[str, Any]],
    *,
    camera: Camera,
    clock: dict[str, Any] | None,
    rows: list[dict[str, str]],
    notes: list[str],
    play: bool,
) -> str:
    """The page.

    Args:
        title: the robot's name, as plain text.
        commands: for the player, in their order.
        camera: the view.
        clock: playback and motion times of the knots; None for a still picture.
        rows: of the legend, each with its "text" and "color".
        notes: further lines of the legend.
        play: whether it starts by itself.
    """
    facts = {
        "title": title,
        "camera": camera.in_player(),
        "suns": list(SUNS),
        "clock": clock,
        "rows": rows,
        "notes": notes,
        "play": play,
    }
    # Inside a script element only "<" can end it or begin a comment.
    text = json.dumps(facts, allow_nan=False).replace("<", "\\u003c")
    blocks = "\n".join(
        f'<script type="text/plain" class="command">{base64.b64encode(packed(c)).decode()}</script>'
        for c in commands
    )
    return f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{_POLICY}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<link rel="icon" href="data:,">
<title>{html.escape(title)}</title>
<style>{_STYLE}</style>
</head>
<body>
<div id="meshcat-pane"></div>
<div id="legend"></div>
<script type="application/json" id="replay">{text}</script>
{blocks}
<script>{player_script()}</script>
<script>{_LEGEND}{_START}</script>
</body>
</html>
"""
