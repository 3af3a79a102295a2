// Gamepads as the browser has them. Most have the standard mapping; Firefox on Linux reports 8 axes and 11 buttons, with
// triggers that rest at -1 (and read 0 until they are first moved). Whoever asks the browser gets the standard mapping.
const ichainPads = { seen: false, lost: "" };

(() => {
  const RAW_AXES = 8, RAW_BUTTONS = 11;
  const moved = new Map();  // index of a pad -> its axes that have read anything but 0

  function button(value) { return { value, pressed: value > 0.5, touched: value > 0 }; }

  ichainPads.standard = pad => {
    if (!pad || pad.mapping === "standard" || pad.axes.length < RAW_AXES || pad.buttons.length !== RAW_BUTTONS) return pad;
    const touched = moved.get(pad.index) ?? new Set();
    moved.set(pad.index, touched);
    pad.axes.forEach((value, k) => { if (value !== 0) touched.add(k); });
    const trigger = k => button(touched.has(k) ? (pad.axes[k] + 1) / 2 : 0);
    const hat = (k, sign) => button(sign * pad.axes[k] > 0.5 ? 1 : 0);
    const b = pad.buttons;
    return {
      id: pad.id, index: pad.index, connected: pad.connected, timestamp: pad.timestamp, mapping: "standard",
      axes: [0, 1, 3, 4].map(k => pad.axes[k]),
      buttons: [
        b[0], b[1], b[2], b[3], b[4], b[5], trigger(2), trigger(5), b[6], b[7], b[9], b[10],
        hat(7, -1), hat(7, 1), hat(6, -1), hat(6, 1), b[8],
      ],
    };
  };

  const ask = navigator.getGamepads?.bind(navigator);
  if (ask) navigator.getGamepads = () => Array.from(ask(), ichainPads.standard);

  // What to tell the person about gamepads; `lost` is an alarm.
  ichainPads.look = () => {
    if (!navigator.getGamepads) {
      return window.isSecureContext ? "this browser has no gamepads"
        : "forbidden by the browser: this page comes over plain http from another machine; open it through a tunnel to "
          + "127.0.0.1 (ssh -L), or use the keys";
    }
    const pad = Array.from(navigator.getGamepads()).find(one => one && one.connected);
    if (pad) {
      ichainPads.seen = true;
      ichainPads.lost = "";
      return pad.id || "connected";
    }
    if (ichainPads.seen) ichainPads.lost = "the gamepad is gone: plug it in again and press one of its buttons";
    return ichainPads.seen ? "gone" : "none; press one of its buttons if there is one";
  };
  addEventListener("keydown", () => { if (ichainPads.lost) { ichainPads.seen = false; ichainPads.lost = ""; } }, true);
})();
