// The panel over a running scene: instructions, state and alarms; held keys move Meshcat's sliders, which spring back.
// `ichainLive` is what tests read: watching, status, frames (drawn by the browser in the last second).
const ichainLive = { watching: false, status: {}, frames: 0 };

(() => {
  const ASK = 250, MOVE = 33, FULL = 250, BACK = 150;  // [ms]: asking, moving; from 0 to 1; from 1 to 0
  const FEW = 12;  // frames a second that are too few to drive by
  const PATIENCE = 4000;  // [ms] after which a scene that is not connected is said to be out of reach
  const config = ichainConfig;
  const panel = ichainMake(document.body, "div");
  panel.id = "ichain-live";
  ichainMake(panel, "h1", "", config.title);
  const state = ichainMake(panel, "div", "state", "connecting ...");
  const alarm = ichainMake(panel, "div", "alarm", "");
  const values = ichainMake(panel, "table", "values");
  const help = ichainMake(panel, "table", "help");
  for (const [keys, text, pad] of config.instructions) {
    const line = ichainMake(help, "tr"), cell = ichainMake(line, "td");
    for (const key of keys) ichainMake(cell, "kbd", "", key);
    const words = ichainMake(line, "td", "", text);
    if (pad) ichainMake(words, "span", "pad", pad);
  }

  function show(status) {
    ichainLive.status = status;
    if (status.state === undefined) return;
    state.className = "state " + status.state;
    state.textContent = status.text;
    const slow = ichainLive.frames < FEW ? `this browser draws only ${ichainLive.frames} frames a second` : "";
    const pad = config.pads ? { gamepad: ichainPads.look() } : {};
    const scene = performance.now() > PATIENCE && viewer.connection?.readyState !== WebSocket.OPEN
      ? `the scene at ${config.socket} is out of reach from this browser: forward that port, too` : "";
    alarm.textContent = [status.alarm, ichainPads.lost, scene, slow].filter(text => text).join("; ");
    values.replaceChildren();
    for (const [label, value] of Object.entries({ ...status.values, ...pad })) {
      const line = ichainMake(values, "tr");
      ichainMake(line, "td", "", label);
      ichainMake(line, "td", "", value);
    }
  }

  // A worker asks, as drawing may keep this thread busy for seconds. Whoever hides the page does not look: the worker is
  // silent then, and the program takes the person as gone.
  const worker = new Worker(URL.createObjectURL(new Blob([`
    let hidden = false, asking = false;
    onmessage = event => { hidden = event.data; };
    setInterval(async () => {
      if (hidden || asking) return;
      asking = true;
      try {
        const reply = await fetch("${location.origin}/ichain/status", { cache: "no-store", signal: AbortSignal.timeout(2000) });
        postMessage(await reply.json());
      } catch (error) { postMessage(null); }
      asking = false;
    }, ${ASK});`])));
  worker.onmessage = event => {
    ichainLive.watching = event.data !== null && viewer.connection?.readyState === WebSocket.OPEN;
    if (event.data !== null) show(event.data);
    else if (ichainLive.status.state !== "ended") {
      state.className = "state waiting";
      state.textContent = "no answer: the program has ended, or the connection is lost";
    }
  };
  const tell = () => worker.postMessage(document.hidden);
  document.addEventListener("visibilitychange", tell);
  tell();

  let drawn = [];
  const count = now => {
    drawn.push(now);
    drawn = drawn.filter(time => now - time < 1000);
    ichainLive.frames = drawn.length;
    requestAnimationFrame(count);
  };
  requestAnimationFrame(count);

  // A machine that draws without a graphics card gets a plainer picture rather than a late one.
  let plainer = 0, slow = 0;
  setInterval(() => {
    slow = ichainLive.watching && !document.hidden && ichainLive.frames < FEW ? slow + 1 : 0;
    if (slow < 2 || plainer === 2) return;
    plainer += 1;
    slow = 0;
    viewer.set_property(["Lights", "SpotLight", "<object>"], "castShadow", false);
    viewer.renderer.setPixelRatio(plainer === 1 ? 0.6 : 0.35);
    viewer.set_dirty();
  }, 1500);

  // Held keys.
  const held = new Set();
  const axes = {};  // slider -> position; there while keys move it or it springs back
  const typing = event => event.target instanceof HTMLInputElement;
  addEventListener("keydown", event => {
    if (typing(event) || event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.code in config.keys) {
      held.add(event.code);
      axes[config.keys[event.code][0]] ??= 0;
    } else if (!event.repeat) return;  // to Meshcat's buttons, once for each press
    event.preventDefault();
    event.stopImmediatePropagation();
  }, true);
  addEventListener("keyup", event => held.delete(event.code), true);
  addEventListener("blur", () => held.clear());
  const sliders = new Set(Object.values(config.keys).map(([name]) => name));
  addEventListener("pointerup", () => {  // a slider dragged with the mouse springs back too
    for (const name of sliders) axes[name] ??= viewer.gui_controllers[name]?.getValue() ?? 0;
  }, true);

  let last = performance.now();
  setInterval(() => {
    const now = performance.now(), passed = Math.min(now - last, 200);
    last = now;
    for (const name of Object.keys(axes)) {
      const slider = viewer.gui_controllers[name];
      if (!slider) continue;
      let goal = 0;
      for (const code of held) if (config.keys[code][0] === name) goal += config.keys[code][1];
      const away = goal !== 0 && Math.sign(goal - axes[name]) * axes[name] >= 0;
      const step = passed / (away ? FULL : BACK);
      axes[name] += Math.min(Math.max(goal - axes[name], -step), step);
      slider.setValue(axes[name]);
      if (goal === 0 && axes[name] === 0) delete axes[name];
    }
  }, MOVE);

  // Meshcat folds its controls away at first, and unfolds the scene's.
  const open = setInterval(() => {
    if (!Object.keys(viewer.gui_controllers).length) return;
    viewer.gui.open();
    viewer.gui.__folders.Scene?.close();
    clearInterval(open);
  }, 200);
})();
