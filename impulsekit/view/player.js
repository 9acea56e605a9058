"use strict";
// The page's player: a bar, a legend and keys around meshcat's viewer. Names go into text
// nodes alone, so none of them is ever read as markup.
const replay = JSON.parse(document.getElementById("replay").textContent);
// As text, for which browsers take no coloured picture.
const [PLAY, PAUSE] = ["\u25b6\ufe0e", "\u275a\u275a"];
let viewer;

const byId = id => document.getElementById(id);
const parts = path => path.split("/").filter(part => part);
const nodeAt = path => viewer.scene_tree.find(parts(path));

function element(tag, options, parent) {
  const made = Object.assign(document.createElement(tag), options);
  if (parent) parent.append(made);
  return made;
}

// ---- the motion's time -------------------------------------------------------------------

function motionTime(clock, t) {
  const [played, moved] = [clock.played, clock.moved];
  let i = 1;
  while (i < played.length - 1 && t > played[i]) i++;
  const span = played[i] - played[i - 1];
  const share = span > 0 ? Math.min(Math.max((t - played[i - 1]) / span, 0), 1) : 1;
  const rate = span > 0 ? (moved[i] - moved[i - 1]) / span : 1;
  return [moved[i - 1] + share * (moved[i] - moved[i - 1]), rate];
}

class Player {
  constructor() {
    this.animator = viewer.animator;
    this.clock = replay.clock;
    this.impacts = [...new Set(replay.impacts.map(hit => Math.fround(hit.time)))];
    this.frames = this.duration ? replay.frames : [];
    this.dragging = false;
    this.resume = false;
  }

  get time() { return this.animator.time; }
  get duration() { return this.animator.duration; }

  // Between two frames a pose is interpolated; at a frame it is exact.
  nearestFrame(t) {
    const after = this.frames.findIndex(frame => frame >= t);
    const [low, high] = [this.frames.at(after > 0 ? after - 1 : after), this.frames.at(after)];
    return t - low < high - t ? low : high ?? Math.min(Math.max(t, 0), this.duration);
  }

  seek(t) {
    const instant = Math.min(Math.max(t, 0), this.duration);
    this.animator.seek(instant);
    this.animator.display_progress(instant);
    viewer.set_dirty();
  }

  play() {
    if (!this.duration) return;
    if (!replay.loop && this.time >= this.duration * (1 - 1e-9)) this.seek(0);
    this.animator.play();
  }

  pause() { this.animator.pause(); }
  toggle() { this.animator.playing ? this.pause() : this.play(); }

  stepFrames(count) {
    this.pause();
    const frames = this.frames;
    if (!frames.length) return this.seek(this.time + count / 60);
    let i = frames.indexOf(this.nearestFrame(this.time));
    i = Math.min(Math.max(i + count, 0), frames.length - 1);
    return this.seek(frames[i]);
  }

  // Past the last impact the first one follows, and the other way round.
  stepImpact(direction) {
    if (!this.impacts.length) return;
    this.pause();
    const near = 1e-6 * Math.max(this.duration, 1e-3);
    const ahead = direction > 0
      ? this.impacts.find(t => t > this.time + near)
      : this.impacts.findLast(t => t < this.time - near);
    this.seek(ahead ?? this.impacts.at(direction > 0 ? 0 : -1));
  }

  // The numbers of the impacts at this instant, from 1, as text; several may be at one frame.
  impactHere() {
    const near = 1e-6 * Math.max(this.duration, 1e-3);
    const here = replay.impacts.flatMap((hit, i) =>
      Math.abs(Math.fround(hit.time) - this.time) <= near ? [i + 1] : []);
    if (!here.length) return "";
    const [first, last] = [here[0], here.at(-1)];
    return (first < last ? "impacts " + first + " to " + last : "impact " + first)
      + " of " + replay.impacts.length;
  }

  // The impulses of the impact whose arrows are shown, or the forces that act between impacts.
  get text() {
    const near = 1e-6 * Math.max(this.duration, 1e-3);
    const shown = replay.impacts.filter(
      hit => Math.fround(hit.time) <= this.time + near && this.time < hit.end + near);
    // Where the next one begins, the last one ends.
    const latest = Math.max(...shown.map(hit => Math.fround(hit.time)));
    const hits = shown.filter(hit => Math.fround(hit.time) >= latest - near);
    if (hits.length) return hits.map(hit => hit.text).filter(text => text).join("; ");
    return replay.forces.map(force => [force.name, this.force(force)])
      .filter(([, size]) => size > 0)
      .map(([name, size]) => name + ": " + size + " N").join("; ");
  }

  // The size of a contact force at this moment [N].
  force({ times, sizes }) {
    const i = times.findIndex(t => t >= this.time);
    return sizes[i < 0 ? sizes.length - 1 : i];
  }
}

// ---- the picture -------------------------------------------------------------------------

class Stage {
  constructor() {
    this.view = replay.camera;
    this.following = false;
    this.followed = replay.followed;
    this.names = new Map(replay.labels.map(([path, text]) => [nodeAt(path).object, text]));
    this.fading = new Map();
    const render = viewer.render.bind(viewer);
    this.draw = () => { this.#follow(); this.#fade(); render(); };
    this.filming = false;
    viewer.render = () => { if (!this.filming) this.draw(); };
    this.reset();
    for (const name of replay.suns) {
      // A sun shines on the middle of the picture, not on the origin.
      const sun = viewer.scene_tree.find(["Lights", name, "<object>"]).object;
      sun.target.position.set(...this.view.target);
      sun.target.updateMatrixWorld();
    }
  }

  reset() {
    viewer.camera.up.set(...this.view.up);
    viewer.set_camera(viewer.camera);
    viewer.camera.position.set(...this.view.position);
    viewer.controls.target.set(...this.view.target);
    viewer.controls.update();
    viewer.set_dirty();
  }

  // The mass centre of what moves, in the player's axes.
  centre() {
    const sum = new MeshCat.THREE.Vector3();
    let mass = 0;
    for (const [path, weight, lever] of this.followed) {
      const node = nodeAt(path).object;
      node.updateWorldMatrix(true, false);
      const point = new MeshCat.THREE.Vector3(...lever).applyMatrix4(node.matrixWorld);
      sum.addScaledVector(point, weight);
      mass += weight;
    }
    return mass > 0 ? sum.divideScalar(mass) : null;
  }

  // The camera comes as near as what moves is large.
  follow(on) {
    this.following = on;
    if (on) {
      const box = new MeshCat.THREE.Box3();
      for (const [path] of this.followed) box.expandByObject(nodeAt(path).object);
      const radius = box.getBoundingSphere(new MeshCat.THREE.Sphere()).radius;
      const { position, fov } = viewer.camera;
      const offset = position.clone().sub(viewer.controls.target);
      const near = 1.6 * radius / Math.sin(0.5 * fov * Math.PI / 180);
      if (near > 0 && near < offset.length())
        position.copy(viewer.controls.target).add(offset.setLength(near));
    }
    viewer.set_dirty();
  }

  // What is followed stays in the middle: the camera keeps its distance and direction.
  #follow() {
    const now = this.following ? this.centre() : null;
    if (!now) return;
    const moved = now.sub(viewer.controls.target);
    viewer.camera.position.add(moved);
    viewer.controls.target.add(moved);
    viewer.camera.lookAt(viewer.controls.target);
  }

  // Before the arrows of an impact go they fade.
  #fade() {
    for (const [number, { time, end }] of replay.impacts.entries()) {
      const last = 0.4 * (end - time);
      const now = viewer.animator.time;
      const left = end < viewer.animator.duration && now >= time && now <= end && last > 0
        ? Math.min(1, (end - now) / last) : 1;
      if (left === (this.fading.get(number) ?? 1)) continue;
      this.fading.set(number, left);
      nodeAt(replay.root + "/impacts/" + number).object.traverse(({ material }) => {
        if (!material) return;
        const own = material.userData;
        own.opacity ??= material.opacity;
        own.transparent ??= material.transparent;
        material.opacity = left * own.opacity;
        material.transparent = own.transparent || left < 1;
      });
    }
  }

  // The name of what is under a point of the window, or null; arrows and marks come first.
  nameAt(x, y) {
    const frame = viewer.renderer.domElement.getBoundingClientRect();
    const point = new MeshCat.THREE.Vector2(
      2 * (x - frame.left) / frame.width - 1, 1 - 2 * (y - frame.top) / frame.height);
    const ray = new MeshCat.THREE.Raycaster();
    ray.setFromCamera(point, viewer.camera);
    for (const parts of [["impacts", "forces"], ["traces", "bodies"]])
      for (const hit of ray.intersectObjects(
        parts.map(part => nodeAt(replay.root + "/" + part).object), true)) {
        const name = this.#nameOf(hit.object);
        if (name !== null) return name;
      }
    return null;
  }

  #nameOf(object) {
    let found = null;
    for (; object; object = object.parent) {
      if (!object.visible) return null;
      found ??= this.names.get(object) ?? null;
    }
    return found;
  }

  // What a node holds is hidden below it: whether the node itself shows, the tracks decide.
  show(paths, on) {
    for (const path of paths) for (const child of nodeAt(path).object.children) child.visible = on;
    viewer.set_dirty();
  }

  showArrows(on) {
    for (const part of ["impacts", "forces"])
      nodeAt(replay.root + "/" + part).object.visible = on;
    viewer.set_dirty();
  }
}

// ---- legend, bar and keys ----------------------------------------------------------------

function buildLegend(stage) {
  const legend = byId("legend");
  element("b", { textContent: replay.title, title: replay.title }, legend);
  for (const row of replay.rows) {
    const paths = replay.groups[row.group] ?? [];
    const line = element(paths.length ? "button" : "span", { className: "row" }, legend);
    element("i", {}, line).style.background = row.color;
    element("span", { textContent: row.short }, line);
    line.title = row.text;
    if (!paths.length) continue;
    line.title = "show or hide: " + row.text;
    line.setAttribute("aria-pressed", "true");
    line.addEventListener("click", () => {
      const on = line.getAttribute("aria-pressed") === "false";
      line.setAttribute("aria-pressed", String(on));
      if (stage()) stage().show(paths, on);
    });
  }
  for (const note of replay.notes)
    element("span", { className: "row", textContent: note, title: note }, legend);
}

function press(id, on) { byId(id).setAttribute("aria-pressed", String(on)); }
const pressed = id => byId(id).getAttribute("aria-pressed") === "true";

function buildBar(player, stage) {
  const slider = byId("time");
  slider.max = String(player.duration || 1);
  const moves = Boolean(player.duration && replay.clock);
  for (const id of ["play", "time", "speed", "video"]) byId(id).disabled = !moves;
  for (const id of ["next", "previous"])
    byId(id).disabled = !(moves && player.impacts.length);
  for (const t of player.impacts.filter((_, i, all) => i % Math.ceil(all.length / 300) === 0))
    element("i", {}, byId("marks")).style.left = 100 * t / (player.duration || 1) + "%";
  const acts = {
    play: () => player.toggle(),
    next: () => player.stepImpact(1),
    previous: () => player.stepImpact(-1),
    arrows: () => { press("arrows", !pressed("arrows")); stage.showArrows(pressed("arrows")); },
    follow: () => { press("follow", !pressed("follow")); stage.follow(pressed("follow")); },
    fold: () => {
      const legend = byId("legend");
      legend.hidden = !legend.hidden;
      byId("fold").setAttribute("aria-expanded", String(!legend.hidden));
      viewer.set_3d_pane_size();
    },
    picture: () => films.press("picture"),
    video: () => films.press("video"),
    help: () => { byId("keys").hidden = !byId("keys").hidden; },
  };
  for (const [id, act] of Object.entries(acts))
    byId(id).addEventListener("click", event => {
      act();
      // After a click of the mouse the space bar is the player's again.
      if (event.detail) byId(id).blur();
    });
  byId("arrows").disabled = !Object.keys(replay.groups).length;
  byId("follow").disabled = !(moves && replay.followed.length);
  byId("speed").addEventListener("change", event => {
    player.animator.mixer.timeScale = Number(event.target.value);
    event.target.blur();
  });
  slider.addEventListener("input", () => {
    if (!player.dragging) {
      player.dragging = true;
      player.resume = player.animator.playing;
      player.pause();
    }
    player.seek(player.nearestFrame(Number(slider.value)));
  });
  slider.addEventListener("change", () => {
    if (player.dragging && player.resume) player.play();
    player.dragging = false;
  });
  return acts;
}

function listenToKeys(player, stage, acts) {
  const speed = by => {
    const select = byId("speed");
    const to = Math.min(Math.max(select.selectedIndex + by, 0), select.options.length - 1);
    select.selectedIndex = to;
    player.animator.mixer.timeScale = Number(select.value);
  };
  const keys = {
    " ": acts.play, k: acts.play,
    ArrowRight: event => player.stepFrames(event.shiftKey ? 10 : 1),
    ArrowLeft: event => player.stepFrames(event.shiftKey ? -10 : -1),
    ArrowDown: acts.next, n: acts.next, ArrowUp: acts.previous, p: acts.previous,
    Home: () => { player.pause(); player.seek(0); },
    End: () => { player.pause(); player.seek(player.duration); },
    "+": () => speed(1), "-": () => speed(-1),
    a: acts.arrows, f: acts.follow, l: acts.fold, r: () => stage.reset(), "?": acts.help,
    g: () => { document.body.classList.toggle("panel"); viewer.gui.open(); },
  };
  document.addEventListener("keydown", event => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const kind = event.target.tagName;
    const typed = kind === "INPUT" && event.target.type !== "range";
    if (typed || kind === "SELECT" || (kind === "BUTTON" && event.key === " ")) return;
    const act = keys[event.key];
    if (!act) return;
    event.preventDefault();
    const button = Object.keys(acts).find(id => acts[id] === act);
    if (!button || !byId(button).disabled) act(event);
  });
}

function nameOnHover(stage) {
  const pane = byId("meshcat-pane");
  const label = byId("name");
  let asked = null;
  pane.addEventListener("pointermove", event => {
    const first = asked === null;
    asked = event;
    if (first) requestAnimationFrame(() => {
      const { clientX: x, clientY: y, buttons } = asked;
      asked = null;
      const name = buttons ? null : stage.nameAt(x, y);
      label.hidden = name === null;
      if (name === null) return;
      label.textContent = name;
      label.style.left = Math.min(x + 14, innerWidth - label.offsetWidth - 4) + "px";
      label.style.top = Math.max(y - 26, 4) + "px";
    });
  });
  pane.addEventListener("pointerleave", () => { label.hidden = true; });
}

function keepShowing(player) {
  const [clock, pace, impact, slider] = ["clock", "pace", "impact", "time"].map(byId);
  let playing = null;
  const show = () => {
    const t = player.time;
    const [moved, rate] = motionTime(replay.clock, t);
    const value = (moved * replay.clock.scale).toFixed(replay.clock.digits);
    clock.textContent = "t = " + value + " " + replay.clock.unit;
    const here = player.impactHere();
    const speed = Number((rate * player.animator.mixer.timeScale).toPrecision(2));
    pace.textContent = here && !player.animator.playing ? here : "at " + speed + "×";
    pace.title = speed + " s of the motion in each second";
    const words = player.text;
    if (impact.textContent !== words) impact.textContent = impact.title = words;
    if (!player.dragging) slider.value = String(t);
    slider.setAttribute("aria-valuetext", clock.textContent);
    if (playing !== player.animator.playing) {
      playing = player.animator.playing;
      byId("play").textContent = playing ? PAUSE : PLAY;
      byId("play").setAttribute("aria-label", playing ? "Pause" : "Play");
      byId("play").title = (playing ? "Pause" : "Play") + " (space)";
    }
    requestAnimationFrame(show);
  };
  show();
}

// ---- start -------------------------------------------------------------------------------

let stage = null;
let player = null;

// The commands lie deflated one after another, each behind its length of four bytes.
async function load() {
  const bytes = Uint8Array.from(atob(byId("commands").textContent), c => c.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  const whole = await new Response(stream).arrayBuffer();
  const view = new DataView(whole);
  for (let at = 0; at < whole.byteLength;) {
    const length = view.getUint32(at);
    viewer.handle_command_bytearray(new Uint8Array(whole, at + 4, length));
    at += 4 + length;
  }
}

async function start() {
  buildLegend(() => stage);
  try {
    viewer = new MeshCat.Viewer(byId("meshcat-pane"));
    // Its own measure is the window's height, of which the bar and the legend take a part.
    const fit = viewer.set_3d_pane_size;
    const pane = byId("meshcat-pane");
    viewer.set_3d_pane_size = (width = pane.offsetWidth, height = pane.offsetHeight) =>
      fit.call(viewer, width, Math.max(height, 1));
    await load();
    stage = new Stage();
    player = new Player();
    listenToKeys(player, stage, buildBar(player, stage));
    nameOnHover(stage);
    if (!replay.play) viewer.animator.pause();
    if (replay.clock) keepShowing(player);
    viewer.set_3d_pane_size();
    viewer.set_dirty();
    window.ready = true;
  } catch (error) {
    element("div", {
      id: "trouble",
      textContent: "This page needs WebGL, which this browser does not offer: " + error,
    }, document.body);
    throw error;
  }
}

start();
