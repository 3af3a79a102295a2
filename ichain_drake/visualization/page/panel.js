// The panel at the right: the interaction graph, whose edges light up while active, and strips of quantities over time.
// `ichainPanel(log, number, seek)` builds it and gives back show(episode, sample), which brings it to a sample.
const ichainPanel = (log, number, seek) => {
  const SVG = "http://www.w3.org/2000/svg";
  const WIDTH = 240, HEIGHT = 34;
  const draw = (parent, tag, attributes, text) => {
    const element = document.createElementNS(SVG, tag);
    for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
    if (text !== undefined) element.textContent = text;
    parent.appendChild(element);
    return element;
  };
  if (!log.graph && !log.strips.length) return () => {};
  const panel = ichainMake(document.body, "div");
  panel.id = "ichain-panel";

  // In a narrow window the parts are folded, so that the scene is seen first.
  function fold(className, title) {
    const part = ichainMake(panel, "details", className);
    part.open = window.innerWidth >= 1000;
    ichainMake(part, "summary", "", title);
    return part;
  }

  function graph({ width, height, boxes, edges }) {
    const part = fold("graph", "interactions");
    const scale = Math.min(1, WIDTH / width);
    const svg = draw(part, "svg", { viewBox: `0 0 ${width} ${height}`, width: width * scale, height: height * scale });
    const tips = draw(svg, "defs", {});
    for (const kind of ["off", "on"]) {
      const tip = draw(tips, "marker", {
        id: `ichain-tip-${kind}`, viewBox: "0 0 8 8", refX: 7, refY: 4, orient: "auto",
        markerWidth: kind === "on" ? 10 : 8, markerHeight: kind === "on" ? 10 : 8, markerUnits: "userSpaceOnUse",
      });
      draw(tip, "path", { d: "M0 0.5 L8 4 L0 7.5 Z", class: `tip ${kind}` });
    }
    const lines = edges.map(({ name, curve: [a, c, b] }) => {
      const line = draw(svg, "path", { d: `M${a} Q${c} ${b}`, class: "edge" });
      line.dataset.edge = name;
      draw(line, "title", {}, name);
      return line;
    });
    const nodes = {};
    for (const { name, box: [x, y, w, h] } of boxes) {
      nodes[name] = draw(svg, "rect", { x: x - w / 2, y: y - h / 2, width: w, height: h, rx: 6, class: "node" });
      draw(svg, "text", { x, y: y + 4, class: "name" }, name);
    }
    return (i, k) => {
      const moved = new Set();
      edges.forEach(({ child, switched }, j) => {
        // The number of switches up to now is odd while it is active.
        const on = switched[i] !== null && switched[i].filter(sample => sample <= k).length % 2 === 1;
        lines[j].classList.toggle("on", on);
        lines[j].classList.toggle("unknown", switched[i] === null);
        if (on) moved.add(child);
      });
      for (const [name, node] of Object.entries(nodes)) node.classList.toggle("on", moved.has(name));
    };
  }

  // As wide as the strip in pixels: in each column the line goes over the least and the largest value.
  function outline(values, y) {
    const n = values.length, parts = [];
    let pen = "M";
    for (let column = 0; column < Math.min(WIDTH, n); column++) {
      const from = Math.floor(column * n / Math.min(WIDTH, n));
      const to = Math.max(from + 1, Math.floor((column + 1) * n / Math.min(WIDTH, n)));
      const some = values.slice(from, to).filter(value => value !== null);
      if (!some.length) { pen = "M"; continue; }
      const x = (WIDTH * (from + to - 1) / 2 / Math.max(1, n - 1)).toFixed(1);
      const low = Math.min(...some), high = Math.max(...some);
      const ends = some[0] <= some[some.length - 1] ? [low, high] : [high, low];
      for (const value of low === high ? [low] : ends) {
        parts.push(`${pen}${x} ${y(value).toFixed(1)}`);
        pen = "L";
      }
    }
    return parts.join(" ");
  }

  function strip(strips, { label, values: episodes }) {
    const part = ichainMake(strips, "div", "strip");
    const head = ichainMake(part, "div", "head");
    ichainMake(head, "span", "label", label);
    const value = ichainMake(head, "span", "value");
    const svg = draw(part, "svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, preserveAspectRatio: "none", height: HEIGHT });
    const band = draw(svg, "rect", { x: 0, width: WIDTH, class: "wanted" });
    const line = draw(svg, "path", { class: "line" });
    const cursor = draw(svg, "line", { y1: 0, y2: HEIGHT, class: "cursor" });
    let shown = -1, samples = 1;
    svg.addEventListener("click", event => {
      const { left, width } = svg.getBoundingClientRect();
      seek(log.episodes[shown].start + (event.clientX - left) / width * (samples - 1) / log.rate);
    });
    function change(i) {
      const { values, lower, upper, wanted } = episodes[i];
      shown = i;
      samples = values.length;
      const known = values.filter(v => v !== null);
      let low = known.reduce((a, b) => Math.min(a, b), Infinity), high = known.reduce((a, b) => Math.max(a, b), -Infinity);
      if (!known.length) low = high = 0;
      // What is wanted is in view as well.
      for (const bound of [lower, upper]) if (bound !== null) { low = Math.min(low, bound); high = Math.max(high, bound); }
      const pad = 0.08 * (high - low) || 0.5;
      const y = v => HEIGHT * (high + pad - v) / (high - low + 2 * pad);
      line.setAttribute("d", outline(values, y));
      const top = upper === null ? 0 : y(upper), bottom = lower === null ? HEIGHT : y(lower);
      band.setAttribute("y", top);
      band.setAttribute("height", wanted ? Math.max(1, bottom - top) : 0);
    }
    return (i, k) => {
      part.style.display = episodes[i] ? "" : "none";
      if (!episodes[i]) return;
      if (i !== shown) change(i);
      const { values, unit, lower, upper, wanted } = episodes[i];
      const now = values[k], x = WIDTH * k / Math.max(1, samples - 1);
      const met = wanted && now !== null && (lower === null || now >= lower) && (upper === null || now <= upper);
      value.textContent = `${number(now)}${unit ? " " + unit : ""}`;
      part.classList.toggle("met", met);
      cursor.setAttribute("x1", x);
      cursor.setAttribute("x2", x);
    };
  }

  const shows = [];
  if (log.graph) shows.push(graph(log.graph));
  if (log.strips.length) {
    const strips = fold("strips", "over time");
    shows.push(...log.strips.map(entry => strip(strips, entry)));
  }
  return (i, k) => shows.forEach(show => show(i, k));
};
