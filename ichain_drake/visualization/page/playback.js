// Inflates the recording inside the page, hands it to Meshcat, and shows the read-out and the transport bar.
// `ichain` is what tests and deep links (#t=12.5) use: ready, duration, seek(seconds), play(), pause().
const ichain = { ready: false, duration: 0 };

(() => {
  const hud = ichainMake(document.body, "div");
  hud.id = "ichain-hud";
  const animator = viewer.animator;
  let log, panel, rows = [];

  async function inflate(text) {
    const packed = Uint8Array.from(atob(text), c => c.charCodeAt(0));
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Response(stream).arrayBuffer();
  }

  // Records of a length (4 bytes, little endian) and that many bytes: the log as JSON, then Meshcat's commands.
  function* records(buffer) {
    const view = new DataView(buffer);
    for (let at = 0; at < buffer.byteLength;) {
      const size = view.getUint32(at, true);
      yield new Uint8Array(buffer, at + 4, size);
      at += 4 + size;
    }
  }

  function number(value) {
    if (value === null) return "-";
    const size = Math.abs(value);
    return value.toFixed(size >= 100 ? 1 : size >= 10 ? 2 : 3);
  }

  function row(table, label, unit, values) {
    const line = ichainMake(table, "tr", unit === null ? "text" : "");
    ichainMake(line, "td", "", label);
    const cell = ichainMake(line, "td", "value", "");
    if (!unit) cell.colSpan = 2;
    else ichainMake(line, "td", "unit", unit);
    rows.push({ line, cell, values });
  }

  function build() {
    document.title = log.scenario + " - playback";
    ichainMake(hud, "h1", "", log.scenario);
    ichainMake(hud, "div", "sub", `${log.physics} physics, seed ${log.seed}`);
    const main = ichainMake(hud, "table");
    log.head = { episode: ichainMake(ichainMake(main, "tr"), "td", "object") };
    log.head.episode.colSpan = 3;
    row(main, "time", "s", null);
    log.head.time = rows.pop().cell;
    for (const { label, unit, values } of log.readouts) row(main, label, unit, values);
    if (log.legend.length) {
      const legend = ichainMake(hud, "details");
      legend.open = true;
      ichainMake(legend, "summary", "", "legend");
      for (const { label, color } of log.legend) {
        const line = ichainMake(legend, "div");
        ichainMake(line, "span", "swatch").style.background = color;
        line.appendChild(document.createTextNode(label));
      }
    }
    const objects = ichainMake(hud, "details");
    ichainMake(objects, "summary", "", "states of the objects");
    const table = ichainMake(objects, "table");
    for (const { name, type, variables } of log.objects) {
      const title = ichainMake(ichainMake(table, "tr"), "td", "object", name === type ? name : `${name} (${type})`);
      title.colSpan = 3;
      for (const { label, unit, values } of variables) row(table, label, unit, values);
    }
    panel = ichainPanel(log, number, time => ichain.seek(time));
    buildBar();
  }

  function buildBar() {
    const bar = ichainMake(document.body, "div");
    bar.id = "ichain-bar";
    log.button = ichainMake(bar, "button", "play", "Play");
    log.button.onclick = () => animator.playing ? ichain.pause() : ichain.play();
    const track = ichainMake(bar, "div", "track");
    log.slider = ichainMake(track, "input");
    Object.assign(log.slider, { type: "range", min: 0, max: ichain.duration, step: 1 / log.rate, value: 0 });
    log.slider.setAttribute("aria-label", "time");
    log.slider.oninput = () => ichain.seek(Number(log.slider.value));
    const names = ichainMake(track, "div", "names");
    log.episodes.forEach((episode, i) => {
      const end = i + 1 < log.episodes.length ? log.episodes[i + 1].start : ichain.duration;
      const name = ichainMake(names, "span", "", episode.name);
      name.style.left = `${100 * episode.start / ichain.duration}%`;
      name.style.maxWidth = `${100 * (end - episode.start) / ichain.duration}%`;
      name.onclick = () => ichain.seek(episode.start);
    });
    log.clock = ichainMake(bar, "span", "clock");
    const speed = ichainMake(bar, "select");
    speed.setAttribute("aria-label", "speed");
    for (const factor of [0.25, 0.5, 1, 2, 4, 8]) ichainMake(speed, "option", "", `${factor}x`).value = factor;
    speed.value = 1;
    speed.onchange = () => { animator.mixer.timeScale = Number(speed.value); };
  }

  // Which episode and which of its samples shows at a playback time.
  function sampleAt(time) {
    let i = 0;
    while (i + 1 < log.episodes.length && log.episodes[i + 1].start <= time + 1e-4) i++;
    const sample = Math.floor((time - log.episodes[i].start) * log.rate + 1e-3);
    return [i, Math.max(0, Math.min(log.episodes[i].samples - 1, sample))];
  }

  let shown = null;
  function show() {
    const time = animator.time;
    const state = `${time} ${animator.playing}`;
    if (state !== shown) {
      shown = state;
      const [i, k] = sampleAt(time);
      const episode = log.episodes[i];
      log.head.episode.textContent =
        log.episodes.length > 1 ? `${episode.name} (${i + 1} of ${log.episodes.length})` : episode.name;
      log.head.time.textContent = (episode.time + k / log.rate).toFixed(2);
      for (const { line, cell, values } of rows) {
        const column = values[i];
        line.style.display = column ? "" : "none";
        if (column) {
          const value = column[k];
          cell.textContent = typeof value === "string" ? value : number(value);
        }
      }
      panel(i, k);
      log.button.textContent = animator.playing ? "Pause" : "Play";
      log.slider.value = time;
      log.clock.textContent = `${time.toFixed(1)} / ${ichain.duration.toFixed(1)} s`;
    }
    requestAnimationFrame(show);
  }

  ichain.seek = time => {
    const at = Math.max(0, Math.min(ichain.duration, time));
    animator.play();  // Meshcat moves only what has been played once
    animator.pause();
    animator.seek(at);
    animator.display_progress(at);
  };
  ichain.pause = () => animator.pause();
  ichain.play = () => {
    const at = animator.time >= ichain.duration - 1e-3 ? 0 : animator.time;
    ichain.seek(at);
    animator.play();
  };

  // #t=12.5 opens the playback there, standing still.
  function follow() {
    const text = new URLSearchParams(location.hash.slice(1)).get("t");
    const time = Number(text);
    if (text === null || text === "" || !Number.isFinite(time)) return false;
    ichain.seek(time);
    return true;
  }

  // Gives a ribbon the number `drawn`, which tracks can drive: how many of its segments (2 triangles each) show.
  function growable(path) {
    const mesh = viewer.scene_tree.find(path.split("/").filter(part => part)).object;
    let drawn = 0;
    mesh.geometry.setDrawRange(0, 0);
    Object.defineProperty(mesh, "drawn", {
      get: () => drawn,
      set: value => { drawn = value; mesh.geometry.setDrawRange(0, 6 * Math.floor(value + 1e-3)); },
    });
  }

  async function open() {
    if (typeof DecompressionStream === "undefined") {
      hud.textContent = "This browser can't inflate the recording; open it in Chrome 80, Firefox 113, Safari 16.4 or later.";
      return;
    }
    const parts = records(await inflate(document.getElementById("ichain-recording").textContent.trim()));
    log = JSON.parse(new TextDecoder().decode(parts.next().value));
    let animation;
    for (const command of parts) {
      if (animation) viewer.handle_command_bytearray(animation);
      animation = command;  // the last one
    }
    log.growing.forEach(growable);
    viewer.handle_command_bytearray(animation);
    viewer.gui.close();
    ichain.duration = animator.duration;
    build();
    if (!follow()) ichain.play();
    window.addEventListener("hashchange", follow);
    window.addEventListener("keydown", event => {
      if (event.code === "Space" && event.target === document.body) log.button.click();
    });
    show();
    ichain.ready = true;
  }
  open().catch(error => { hud.textContent = `The recording can't be shown: ${error}`; console.error(error); });
})();
