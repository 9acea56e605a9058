"use strict";
// Pictures and videos of the page: every frame is drawn, encoded by the browser as H.264 and
// written into an MP4, whose boxes are those of ISO/IEC 14496-12.
const FPS = Math.min(replay.fps, 30);

const u16 = n => [n >>> 8 & 255, n & 255];
const u32 = n => [n >>> 24 & 255, n >>> 16 & 255, ...u16(n)];
const words = text => [...text].map(letter => letter.charCodeAt(0));
const zeros = n => new Array(n).fill(0);
const box = (kind, ...content) => {
  const body = content.flat();
  return [...u32(body.length + 8), ...words(kind), ...body];
};
const table = (kind, rows, ...before) =>
  box(kind, u32(0), ...before, u32(rows.length), rows.flatMap(u32));

// The description of a track whose samples lie one after another from `offset` on.
function movie(width, height, chunks, avcC, offset) {
  const [scale, step] = [Math.round(FPS * 1000), 1000];
  const length = u32(chunks.length * step);
  const one = u32(0x10000);
  const matrix = [one, zeros(12), one, zeros(12), u32(0x40000000)].flat();
  const keys = chunks.flatMap((chunk, i) => chunk.key ? [i + 1] : []);
  const format = box("avc1", zeros(6), u16(1), zeros(16), u16(width), u16(height),
    u32(0x480000), u32(0x480000), zeros(4), u16(1), zeros(32), u16(24), u16(0xffff),
    box("avcC", [...avcC]));
  const samples = box("stbl",
    box("stsd", u32(0), u32(1), format),
    box("stts", u32(0), u32(1), u32(chunks.length), u32(step)),
    table("stss", keys),
    box("stsc", u32(0), u32(1), u32(1), u32(chunks.length), u32(1)),
    table("stsz", chunks.map(chunk => chunk.data.length), u32(0)),
    table("stco", [offset]));
  const media = box("mdia",
    box("mdhd", zeros(12), u32(scale), length, u16(0x55c4), u16(0)),
    box("hdlr", zeros(8), words("vide"), zeros(13)),
    box("minf", box("vmhd", u32(1), zeros(8)),
      box("dinf", box("dref", u32(0), u32(1), box("url ", u32(1)))), samples));
  return box("moov",
    box("mvhd", zeros(12), u32(scale), length, one, u16(0x100), zeros(10), matrix,
      zeros(24), u32(2)),
    box("trak", box("tkhd", u32(7), zeros(8), u32(1), zeros(4), length, zeros(16), matrix,
      u16(width), u16(0), u16(height), u16(0)), media));
}

const films = {
  // Run `draw` on a canvas of exactly this size; the page has its own again afterwards.
  async at(width, height, draw) {
    const [ratio, time] = [viewer.renderer.getPixelRatio(), player.time];
    player.pause();
    stage.filming = true;
    viewer.renderer.setPixelRatio(1);
    viewer.set_3d_pane_size(width, height);
    try {
      return await draw(viewer.renderer.domElement);
    } finally {
      stage.filming = false;
      viewer.renderer.setPixelRatio(ratio);
      viewer.set_3d_pane_size();
      player.seek(time);
    }
  },

  // A PNG in base64: of the given time, or of the first impact.
  picture(width, height, time = player.impacts[0] ?? player.duration / 2) {
    return films.at(width, height, canvas => {
      player.seek(time);
      stage.draw();
      return canvas.toDataURL("image/png").split(",")[1];
    });
  },

  // An MP4 in base64, of the whole playback.
  async video(width, height, progress = () => {}) {
    const level = width * height > 1920 * 1088 ? "33" : "28";
    const config = { codec: "avc1.6400" + level, width, height, framerate: FPS,
      bitrate: Math.max(4e5, 9 * width * height), avc: { format: "avc" } };
    if (typeof VideoEncoder === "undefined"
        || !(await VideoEncoder.isConfigSupported(config)).supported)
      throw new Error("this browser cannot encode H.264");
    const chunks = [];
    let avcC = null;
    let fault = null;
    const encoder = new VideoEncoder({
      error: error => { fault = error; },
      output: (chunk, about) => {
        avcC = about.decoderConfig ? new Uint8Array(about.decoderConfig.description) : avcC;
        const data = new Uint8Array(chunk.byteLength);
        chunk.copyTo(data);
        chunks.push({ data, key: chunk.type === "key" });
      },
    });
    encoder.configure(config);
    const count = Math.max(1, Math.round(player.duration * FPS));
    await films.at(width, height, async canvas => {
      for (let i = 0; i < count && !fault; i++) {
        player.seek(i / FPS);
        stage.draw();
        const frame = new VideoFrame(canvas, { timestamp: Math.round(1e6 * i / FPS) });
        encoder.encode(frame, { keyFrame: i % 60 === 0 });
        frame.close();
        progress((i + 1) / count);
        while (encoder.encodeQueueSize > 4) await new Promise(done => setTimeout(done, 1));
      }
      await encoder.flush();
    });
    if (fault) throw fault;
    const head = box("ftyp", words("isom"), u32(512), words("isomiso2avc1mp41"));
    const size = chunks.reduce((sum, chunk) => sum + chunk.data.length, 8);
    const parts = [head, [...u32(size), ...words("mdat")]].map(x => new Uint8Array(x));
    parts.push(...chunks.map(chunk => chunk.data),
      new Uint8Array(movie(width, height, chunks, avcC, head.length + 8)));
    return films.base64(new Blob(parts));
  },

  async base64(blob) {
    const bytes = new Uint8Array(await blob.arrayBuffer());
    let text = "";
    for (let i = 0; i < bytes.length; i += 32768)
      text += String.fromCharCode(...bytes.subarray(i, i + 32768));
    return btoa(text);
  },

  save(content, kind, ending) {
    const bytes = Uint8Array.from(atob(content), letter => letter.charCodeAt(0));
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([bytes], { type: kind }));
    link.download = (replay.title.replace(/[^\w-]+/g, "_") || "replay") + ending;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10000);
  },

  async press(kind) {
    const pane = byId("meshcat-pane");
    const [width, height] = [pane.offsetWidth & ~1, pane.offsetHeight & ~1];
    const button = byId(kind);
    const text = button.textContent;
    button.disabled = true;
    try {
      if (kind === "picture")
        films.save(await films.picture(width, height, player.time), "image/png", ".png");
      else
        films.save(await films.video(width, height,
          share => { button.textContent = Math.floor(100 * share) + " %"; }), "video/mp4", ".mp4");
    } catch (error) {
      button.title = String(error.message ?? error);
      byId("impact").textContent = button.title;
    }
    button.textContent = text;
    button.disabled = false;
  },
};
