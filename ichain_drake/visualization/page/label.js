// A page on which a person marks when interactions are active, and where pieces begin.
// `ichainData` holds recordings, what was inferred, cuts that were found, and marks of an earlier session.
const ichain = (() => {
  const LEFT = 170, LANE = 18, STRIP = 28, EDGE_GAP = 6, AXIS = 18;
  const COLORS = { on: "#9bc4e2", open: "#d8dde2", yes: "#2e7d46", no: "#c2453b", line: "#1f5f99", cursor: "#d28a00" };
  const data = ichainData, marks = [], removed = data.logs.map(() => new Set());
  const cuts = data.logs.map(log => new Map(log.cuts.map(cut => [cut.row, { name: "", person: false, ...cut }])));
  const firstNames = data.logs.map(() => "");
  let selected = null, dragging = null, saved = true, strips = true;

  const rowAt = (log, time) => log.times.reduce(
    (best, t, row) => (Math.abs(t - time) < Math.abs(log.times[best] - time) ? row : best), 0);
  for (const mark of data.marks) {
    const i = data.logs.findIndex(log => log.name === mark.piece);
    const log = data.logs[i], a = rowAt(log, mark.from);
    if (mark.interaction !== "cut") marks.push({ i, edge: mark.interaction, a, b: rowAt(log, mark.to), active: mark.active });
    else if (!mark.active) removed[i].add(a);
    else if (a === 0) firstNames[i] = mark.name;
    else if (cuts[i].has(a)) cuts[i].get(a).name = mark.name;
    else cuts[i].set(a, { row: a, why: "marked by a person", sure: 1, fixed: false, person: true, name: mark.name });
  }

  const bar = ichainMake(document.body, "div");
  bar.id = "ichain-bar";
  ichainMake(bar, "h1", "", data.title);
  const at = ichainMake(bar, "span", "at", "drag along an interaction, or click where to cut");
  const buttons = {};
  const button = (name, text, act) => {
    buttons[name] = ichainMake(bar, "button", name, text);
    buttons[name].addEventListener("click", () => { act(); buttons[name].blur(); });
  };
  button("yes", "active (1)", () => mark(true));
  button("no", "not active (0)", () => mark(false));
  button("clear", "clear (Del)", () => mark(null));
  button("cut", "cut here (C)", () => cut());
  button("columns", "columns (V)", () => view());
  button("save", "save (S)", () => save());
  button("end", "save and end (Esc)", () => end());
  const said = ichainMake(bar, "span", "said");
  const legend = ichainMake(bar, "span", "legend", "status:");
  for (const [color, text] of [[COLORS.on, "inferred active"], [COLORS.open, "open: nothing shows"],
                               [COLORS.yes, "marked active"], [COLORS.no, "marked not active"]]) {
    ichainMake(legend, "i").style.background = color;
    legend.append(text);
  }
  const list = ichainMake(document.body, "main");

  const pieces = i => {
    const starts = [0, ...[...cuts[i].keys()].sort((a, b) => a - b)];
    return starts.map((a, k) => [a, (starts[k + 1] ?? data.logs[i].times.length) - 1]);
  };
  const say = (text, alarm = false) => {
    said.textContent = text;
    said.classList.toggle("alarm", alarm);
  };
  const changed = text => { saved = false; say(`${text} (not saved)`); };

  function mark(active) {
    if (!selected || !selected.edge) return say("drag along an interaction first", true);
    const { i, edge, a, b } = selected;
    // What was marked there before gives way; what sticks out of the selection stays.
    for (const old of marks.filter(m => m.i === i && m.edge === edge && m.a <= b && m.b >= a)) {
      marks.splice(marks.indexOf(old), 1);
      if (old.a < a) marks.push({ ...old, b: a - 1 });
      if (old.b > b) marks.push({ ...old, a: b + 1 });
    }
    if (active !== null) marks.push({ i, edge, a, b, active });
    const { name, times } = data.logs[i];
    const what = active === null ? "nothing is marked" : active ? "active" : "not active";
    changed(`${name}, ${edge}, ${times[a].toFixed(2)} to ${times[b].toFixed(2)} s: ${what}`);
    redraw();
  }
  function cut() {
    if (!selected) return say("click where the piece behind the cut begins", true);
    const { i, a } = selected;
    if (a === 0 || cuts[i].has(a)) return say("there is a cut already", true);
    cuts[i].set(a, { row: a, why: "marked by a person", sure: 1, fixed: false, person: !removed[i].delete(a), name: "" });
    changed(`cut at ${data.logs[i].times[a].toFixed(2)} s`);
    build();
  }
  function join(i, row) {
    const old = cuts[i].get(row);
    cuts[i].delete(row);
    if (!old.person) removed[i].add(row);
    changed(`joined at ${data.logs[i].times[row].toFixed(2)} s`);
    build();
  }
  function move(i, row, step) {
    const old = cuts[i].get(row), to = row + step;
    if (to < 1 || to >= data.logs[i].times.length || cuts[i].has(to)) return;
    cuts[i].delete(row);
    if (!old.person) removed[i].add(row);
    cuts[i].set(to, { ...old, row: to, why: "moved by a person", sure: 1, person: !removed[i].delete(to) });
    changed(`cut moved to ${data.logs[i].times[to].toFixed(2)} s`);
    build();
  }
  function name(i, row, text) {
    if (row === 0) firstNames[i] = text.trim();
    else cuts[i].get(row).name = text.trim();
    saved = false;
    say(`${text.trim() || "no name"} (not saved)`);
  }
  function view() {
    strips = !strips;
    build();
  }
  function rows() {
    const out = [];
    data.logs.forEach((log, i) => {
      const cutRow = (row, active, label) =>
        out.push({ piece: log.name, interaction: "cut", from: log.times[row], active: active ? 1 : 0, name: label });
      if (firstNames[i]) cutRow(0, true, firstNames[i]);
      for (const c of [...cuts[i].values()].sort((a, b) => a.row - b.row)) if (c.person || c.name) cutRow(c.row, true, c.name);
      for (const row of [...removed[i]].sort((a, b) => a - b)) cutRow(row, false, "");
      for (const m of marks.filter(m => m.i === i).sort((a, b) => a.edge.localeCompare(b.edge) || a.a - b.a)) {
        out.push({ piece: log.name, interaction: m.edge, from: log.times[m.a], to: log.times[m.b], active: m.active ? 1 : 0 });
      }
    });
    return out;
  }
  const send = (path, content) => fetch(path, {
    method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(content),
  }).then(reply => reply.ok ? reply.json() : { error: `${reply.status} ${reply.statusText}` })
    .catch(() => ({ error: "the program has ended, or can't be reached" }));
  async function save() {
    const reply = await send("/ichain/save", rows());
    saved = !reply.error;
    say(reply.error ? `NOT SAVED: ${reply.error}` : reply.text, Boolean(reply.error));
    return saved;
  }
  async function end() {
    if (!await save()) return;
    await send("/ichain/end", {});
    say("ended; close this page");
    for (const b of document.querySelectorAll("button, input")) b.disabled = true;
  }

  // One panel a piece: its name, its cut, and lanes of interactions and columns over the same rows.
  function build() {
    const scroll = window.scrollY;
    list.replaceChildren();
    data.logs.forEach((log, i) => pieces(i).forEach(([a, b], k) => panel(log, i, a, b, k)));
    window.scrollTo(0, scroll);
  }
  function panel(log, i, a, b, k) {
    const part = ichainMake(list, "section"), head = ichainMake(part, "header"), found = cuts[i].get(a);
    part.dataset.log = log.name;
    part.dataset.row = a;
    const label = ichainMake(head, "input");
    label.placeholder = `piece ${k + 1}`;
    label.value = a === 0 ? firstNames[i] : found.name;
    label.addEventListener("change", () => name(i, a, label.value));
    label.addEventListener("keydown", event => { if (event.key === "Enter") label.blur(); });
    ichainMake(head, "span", "rows", `${log.name} rows ${a} to ${b}, ${log.times[a].toFixed(2)} to ${log.times[b].toFixed(2)} s`);
    ichainMake(head, "span", "why", found ? `${found.why} (sure by ${found.sure.toFixed(3)})` : "");
    if (found && !found.fixed) {
      for (const [text, act] of [["◀ earlier", () => move(i, a, -1)], ["later ▶", () => move(i, a, 1)],
                                 ["join to the one above", () => join(i, a)]]) {
        ichainMake(head, "button", "", text).addEventListener("click", act);
      }
    }
    const canvas = ichainMake(part, "canvas");
    const lanes = data.interactions.length, top = lanes * LANE + EDGE_GAP;
    const columns = strips ? log.columns : [], bottom = top + columns.length * STRIP, height = bottom + AXIS;
    const width = Math.max(canvas.clientWidth, LEFT + 100), sharp = window.devicePixelRatio || 1;
    canvas.style.height = `${height}px`;
    canvas.width = width * sharp;
    canvas.height = height * sharp;
    const step = (width - LEFT) / (b - a + 1), x = row => LEFT + (row - a) * step;
    const pen = canvas.getContext("2d");
    function draw() {
      pen.setTransform(sharp, 0, 0, sharp, 0, 0);
      pen.clearRect(0, 0, width, height);
      pen.font = "12px system-ui, sans-serif";
      pen.textBaseline = "middle";
      const block = (first, last, y, color, inset) => {
        const from = Math.max(first, a), to = Math.min(last, b);
        if (from > to) return;
        pen.fillStyle = color;
        pen.fillRect(x(from), y + inset, (to - from + 1) * step, LANE - 2 - 2 * inset);
      };
      data.interactions.forEach((edge, j) => {
        const y = j * LANE;
        pen.fillStyle = "#f6f8fa";
        pen.fillRect(LEFT, y, width - LEFT, LANE - 2);
        for (const [from, to] of log.open[edge] || []) block(from, to, y, COLORS.open, 0);
        for (const [from, to] of log.on[edge] || []) block(from, to, y, COLORS.on, 3);
        for (const m of marks) if (m.i === i && m.edge === edge) block(m.a, m.b, y, m.active ? COLORS.yes : COLORS.no, 0);
        pen.fillStyle = "#1c2733";
        pen.fillText(edge, 0, y + LANE / 2 - 1, LEFT - 8);
        if (selected && selected.i === i && selected.edge === edge && selected.a <= b && selected.b >= a) {
          pen.strokeStyle = COLORS.cursor;
          pen.lineWidth = 2;
          pen.strokeRect(x(Math.max(selected.a, a)), y, (Math.min(selected.b, b) - Math.max(selected.a, a) + 1) * step, LANE - 2);
        }
      });
      columns.forEach(({ label: text, low, high, values }, j) => {
        const y = top + j * STRIP, scale = (STRIP - 6) / (high - low || 1);
        pen.fillStyle = "#5b6b7a";
        pen.fillText(text, 0, y + STRIP / 2, LEFT - 8);
        pen.strokeStyle = COLORS.line;
        pen.lineWidth = 1;
        pen.beginPath();
        for (let row = a; row <= b; row += 1) pen.lineTo(x(row) + step / 2, y + STRIP - 3 - (values[row] - low) * scale);
        pen.stroke();
      });
      // Seconds below, at round times.
      const length = log.times[b] - log.times[a];
      const each = [1, 2, 5, 10, 20, 50, 100, 200, 500].find(s => length / s <= 12) ?? 1000;
      pen.fillStyle = "#5b6b7a";
      for (let t = Math.ceil(log.times[a] / each) * each; t <= log.times[b]; t += each) {
        pen.fillText(`${t} s`, LEFT + ((t - log.times[a]) / (length || 1)) * (width - LEFT - step), bottom + AXIS / 2);
      }
      if (selected && selected.i === i && selected.a >= a && selected.a <= b) {
        pen.strokeStyle = COLORS.cursor;
        pen.beginPath();
        pen.moveTo(x(selected.a), 0);
        pen.lineTo(x(selected.a), height);
        pen.stroke();
      }
    }
    const place = event => {
      const box = canvas.getBoundingClientRect();
      const row = Math.min(b, Math.max(a, a + Math.floor((event.clientX - box.left - LEFT) / step)));
      return { row, lane: Math.floor((event.clientY - box.top) / LANE) };
    };
    canvas.addEventListener("mousedown", event => {
      const { row, lane } = place(event);
      dragging = { draw, place, row };
      selected = { i, edge: data.interactions[lane] ?? null, a: row, b: row };
      redraw();
      event.preventDefault();
      document.activeElement.blur();
    });
    canvas.addEventListener("mousemove", event => tell(i, place(event).row));
    part.draw = draw;
    draw();
  }
  const redraw = () => { for (const part of list.children) part.draw(); };
  function tell(i, row) {
    const log = data.logs[i], { a, b, edge } = selected && selected.i === i ? selected : { a: row, b: row, edge: null };
    const range = edge && b > a ? `; selected ${edge} ${log.times[a].toFixed(2)} to ${log.times[b].toFixed(2)} s` : "";
    at.textContent = `${log.times[row].toFixed(2)} s, row ${row}${range}`;
  }
  window.addEventListener("mousemove", event => {
    if (!dragging) return;
    const { row } = dragging.place(event);
    [selected.a, selected.b] = [Math.min(row, dragging.row), Math.max(row, dragging.row)];
    dragging.draw();
  });
  window.addEventListener("mouseup", () => { dragging = null; });
  window.addEventListener("resize", build);
  window.addEventListener("keydown", event => {
    if (event.target.tagName === "INPUT" || event.ctrlKey || event.metaKey || event.altKey) return;
    const act = { 1: () => mark(true), 0: () => mark(false), Delete: () => mark(null), Backspace: () => mark(null),
                  c: cut, v: view, s: save, Escape: end }[event.key];
    if (act) { event.preventDefault(); act(); }
  });
  build();
  say(data.notice, Boolean(data.notice));
  return { ready: true, rows, isSaved: () => saved, said: () => said.textContent };
})();
