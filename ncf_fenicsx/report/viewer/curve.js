"use strict";
/* One figure of curves: drawn by uPlot, with values under the pointer, and as CSV and SVG files. */

function cssValue(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

function make(tag, text, parent) {
  const made = document.createElement(tag);
  made.textContent = text;
  parent?.append(made);
  return made;
}

function download(name, type, text) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text], { type }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

function followTheme(redraw) {
  document.getElementById("theme").onclick = () => {
    const dark = getComputedStyle(document.documentElement).colorScheme.includes("dark");
    document.documentElement.dataset.theme = dark ? "light" : "dark";
    redraw();
  };
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
  let chosen;
  addEventListener("beforeprint", () => {
    chosen = document.documentElement.dataset.theme;
    document.documentElement.dataset.theme = "light";
    document.documentElement.dataset.printing = "true";
    redraw();
  });
  addEventListener("afterprint", () => {
    if (chosen) document.documentElement.dataset.theme = chosen;
    else delete document.documentElement.dataset.theme;
    delete document.documentElement.dataset.printing;
    redraw();
  });
}

class Curve {
  /* content: title, x {label, values}, y label, logarithmic (both axes), lines [{label, values, and for other than
     their order has it: colour and pattern (numbers), width, points, front (a best front)}]. */
  constructor(parent, content) {
    this.figure = make("figure", "", parent);
    this.figure.curve = this;
    this.caption = make("figcaption", content.title, this.figure);
    this.plot = make("div", "", this.figure);
    const buttons = make("p", "", this.figure);
    buttons.className = "row screen-only";
    this.button(buttons, "CSV", () => download(`${this.fileName()}.csv`, "text/csv", this.csv()));
    this.button(buttons, "SVG", () => download(`${this.fileName()}.svg`, "image/svg+xml", this.svg()));
    this.content = content;
    this.mark = null;
    this.draw();
  }

  button(parent, text, action) {
    const button = make("button", text, parent);
    button.type = "button";
    button.setAttribute("aria-label", `${this.caption.textContent} as ${text}`);
    button.onclick = action;
  }

  fileName() {
    return this.content.title.toLowerCase().replace(/[^a-z0-9]+/g, "_");
  }

  colour(line, number) {
    return line.front ? cssValue("--front") : cssValue(`--line-${(line.colour ?? number) % 6}`);
  }

  dash(line, number) {
    if (line.front) return [];
    return [[], [8, 4], [2, 3], [8, 3, 2, 3], [1, 5], [14, 4]][(line.pattern ?? Math.floor(number / 6)) % 6];
  }

  /* On paper three curves stand side by side. */
  size() {
    if (document.documentElement.dataset.printing) return { width: 240, height: 165 };
    return { width: Math.max(this.plot.clientWidth || this.figure.clientWidth, 240), height: 240 };
  }

  data() {
    const { x, lines } = this.content;
    return [x.values, ...lines.map((line) => line.values)].map((values) => Array.from(values));
  }

  draw() {
    this.drawn?.destroy();
    const { x, y, lines, logarithmic } = this.content;
    const text = { stroke: cssValue("--text"), font: "12px system-ui", labelFont: "12px system-ui", labelSize: 20 };
    const rule = { grid: { stroke: cssValue("--rule"), width: 1 }, ticks: { stroke: cssValue("--rule"), width: 1 } };
    const scale = logarithmic ? { distr: 3 } : {};
    const values = (plot, ticks) => ticks.map((tick) => (tick === null ? "" : shortNumber(tick)));
    const value = (plot, shown) => shortNumber(shown);
    const named = (line, number) => ({
      label: line.label, value, stroke: this.colour(line, number), width: line.width ?? 2, dash: this.dash(line, number),
      points: { show: (line.points ?? x.values.length < 40), size: 5 }, spanGaps: true,
    });
    const options = {
      ...this.size(),
      scales: { x: { time: false, ...scale }, y: scale },
      axes: [{ ...text, ...rule, label: x.label, values }, { ...text, ...rule, label: y, size: 58, values }],
      series: [{ label: x.label, value }, ...lines.map(named)],
      hooks: { draw: [(plot) => this.drawMark(plot)] },
      cursor: { drag: { x: true, y: true } },
    };
    this.drawn = new vendor.uPlot(options, this.data(), this.plot);
  }

  update(content) {
    this.content = { ...this.content, ...content };
    this.caption.textContent = this.content.title;
    this.drawn.setData(this.data());
  }

  markAt(place) {
    if (place === this.mark) return;
    this.mark = place;
    this.drawn.redraw(false);
  }

  drawMark(plot) {
    if (this.mark === null) return;
    const x = plot.valToPos(this.mark, "x", true);
    const { ctx, bbox } = plot;
    ctx.save();
    ctx.strokeStyle = cssValue("--text");
    ctx.setLineDash([4, 4]);
    ctx.beginPath();
    ctx.moveTo(x, bbox.top);
    ctx.lineTo(x, bbox.top + bbox.height);
    ctx.stroke();
    ctx.restore();
  }

  csv() {
    const { x, y, lines } = this.content;
    const quoted = (words) => `"${words.replaceAll('"', '""')}"`;
    const head = [quoted(x.label), ...lines.map((line) => quoted(`${line.label}, ${y}`))];
    const rows = this.data()[0].map((_, row) => this.data().map((column) => column[row] ?? "").join(","));
    return `${head.join(",")}\n${rows.join("\n")}\n`;
  }

  /* The curves as uPlot shows them, with its scales and marks of the axes. */
  svg() {
    const { x, y, lines, title } = this.content;
    const [width, height, left, top, right, bottom] = [640, 400, 70, 36, 620, 340];
    const log = this.content.logarithmic ? Math.log10 : (number) => number;
    const range = (name) => [this.drawn.scales[name].min, this.drawn.scales[name].max];
    const along = (name, from, to) => (number) => {
      const [low, high] = range(name).map(log);
      return from + ((log(number) - low) / (high - low || 1)) * (to - from);
    };
    const [toX, toY] = [along("x", left, right), along("y", bottom, top)];
    const image = document.createElementNS("http://www.w3.org/2000/svg", "svg");
    image.setAttribute("xmlns", "http://www.w3.org/2000/svg");
    const put = (tag, attributes, words = "") => {
      const part = document.createElementNS("http://www.w3.org/2000/svg", tag);
      Object.entries(attributes).forEach(([name, value]) => part.setAttribute(name, value));
      part.textContent = words;
      image.append(part);
    };
    image.setAttribute("viewBox", `0 0 ${width} ${height}`);
    image.setAttribute("font-family", "sans-serif");
    image.setAttribute("font-size", 12);
    put("rect", { x: 0, y: 0, width, height, fill: "white" });
    put("rect", { x: left, y: top, width: right - left, height: bottom - top, fill: "none", stroke: "#777" });
    put("text", { x: left, y: 20, "font-size": 14, "font-weight": "bold" }, title);
    put("text", { x: (left + right) / 2, y: height - 22, "text-anchor": "middle" }, x.label);
    put("text", { transform: `translate(14 ${(top + bottom) / 2}) rotate(-90)`, "text-anchor": "middle" }, y);
    for (const tick of ticks(...range("x"), this.content.logarithmic)) {
      put("text", { x: toX(tick), y: bottom + 16, "text-anchor": "middle" }, shortNumber(tick));
    }
    for (const tick of ticks(...range("y"), this.content.logarithmic)) {
      put("text", { x: left - 6, y: toY(tick) + 4, "text-anchor": "end" }, shortNumber(tick));
    }
    const colours = ["#005cab", "#b35900", "#007a5a", "#8a3f91", "#a3123a", "#5c5c00"];
    lines.forEach((line, number) => {
      const stroke = line.front ? "#bbbbbb" : colours[(line.colour ?? number) % 6];
      const dashes = this.dash(line, number).join(" ");
      const points = Array.from(line.values, (value, i) => [x.values[i], value]).filter((point) => point[1] !== null);
      const places = points.map(([a, b]) => [toX(a), toY(b)]);
      const style = { fill: "none", stroke, "stroke-width": line.width ?? 2, "stroke-dasharray": dashes };
      put("polyline", { points: places.join(" "), ...style });
      put("text", { x: right - 4, y: top + 16 + 15 * number, fill: stroke, "text-anchor": "end" }, line.label);
    });
    return new XMLSerializer().serializeToString(image);
  }
}

/* About five round numbers between two; powers of ten on a logarithmic axis. */
function ticks(low, high, logarithmic) {
  if (!(high > low)) return [low];
  const found = [];
  if (logarithmic) {
    for (let power = Math.ceil(Math.log10(low)); 10 ** power <= high; power++) found.push(10 ** power);
    return found;
  }
  const rough = 10 ** Math.floor(Math.log10((high - low) / 4));
  const step = [1, 2, 5, 10].map((factor) => factor * rough).find((size) => (high - low) / size <= 6);
  for (let tick = Math.ceil(low / step); tick * step <= high; tick++) found.push(tick * step);
  return found;
}
