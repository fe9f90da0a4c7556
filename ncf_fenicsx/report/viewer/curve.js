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
  /* content: title, id (of a figure that is there; else one is made), note (below the curves), x {label, values, names
     (of the places 1, 2 and so on), range (with margins)}, y label, logarithmic ("x" or "both" axes), lines [{label,
     values, low and high (ends of their errors), bars (errors are of each place alone), and for other than their order
     has it: colour and pattern (numbers), width (0 for points alone), points, front (a best front), traced (points that
     the line goes through in their order)}]. */
  constructor(parent, content) {
    this.figure = (content.id && document.getElementById(content.id)) || make("figure", "", parent);
    this.figure.curve = this;
    this.caption = make("figcaption", content.title, this.figure);
    this.plot = make("div", "", this.figure);
    this.note = make("p", content.note ?? "", this.figure);
    this.note.className = "note";
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

  /* What has a value under the pointer: the lines, then the ends of their errors. */
  columns() {
    const { lines } = this.content;
    const ends = lines.filter((line) => line.low).flatMap((line) => [
      { label: `${line.label}, lower end`, values: line.low, isEnd: true },
      { label: `${line.label}, upper end`, values: line.high, isEnd: true },
    ]);
    return [...lines, ...ends];
  }

  data() {
    return [this.content.x.values, ...this.columns().map((line) => line.values)].map((values) => Array.from(values));
  }

  draw() {
    this.drawn?.destroy();
    const { x, y, logarithmic } = this.content;
    const [font, labelFont] = (document.documentElement.dataset.printing ? [9, 8] : [12, 12]).map((size) => `${size}px system-ui`);
    const text = { stroke: cssValue("--text"), font, labelFont, labelSize: 20 };
    const rule = { grid: { stroke: cssValue("--rule"), width: 1 }, ticks: { stroke: cssValue("--rule"), width: 1 } };
    const [along, up] = [Boolean(logarithmic), logarithmic === "both"].map((so) => (so ? { distr: 3 } : {}));
    const values = (plot, ticks) => ticks.map((tick) => (tick === null ? "" : shortNumber(tick)));
    const names = x.names && this.namesAlong(x.names);
    const marks = logarithmic ? { splits: (plot, axis, low, high) => ticks(low, high, true) } : {};
    const across = { ...along, ...(x.range ? { range: (plot, low, high) => this.rangeOf(low, high) } : {}) };
    const options = {
      ...this.size(),
      scales: { x: { time: false, ...across }, y: up },
      axes: [
        { ...text, ...rule, label: x.label, values, ...marks, ...names },
        { ...text, ...rule, label: y, size: 58, values, ...(logarithmic === "both" ? marks : {}) },
      ],
      series: [{ label: x.label, value: (plot, shown) => shortNumber(shown) }, ...this.columns().map((one, i) => this.drawnAs(one, i))],
      hooks: { drawClear: [(plot) => this.drawErrors(plot)], draw: [(plot) => this.drawMark(plot)] },
      cursor: { drag: { x: true, y: true } },
    };
    this.drawn = new vendor.uPlot(options, this.data(), this.plot);
  }

  /* All names below their places; leaning where they are too long to stand beside each other. */
  namesAlong(names) {
    const leans = 8 * Math.max(...names.map((name) => name.length)) > (this.size().width - 90) / names.length;
    const shown = { splits: () => names.map((_, i) => i + 1), values: () => names };
    return leans ? { ...shown, rotate: -40, size: 26 + 4.5 * Math.max(...names.map((name) => name.length)) } : shown;
  }

  /* The whole range with its margins, or what a reader has zoomed in on. */
  rangeOf(low, high) {
    const { values, range } = this.content.x;
    return low === values[0] && high === values[values.length - 1] ? range : [low, high];
  }

  drawnAs(line, number) {
    const value = (plot, shown) => shortNumber(shown);
    if (line.isEnd) return { label: line.label, value, width: 0, points: { show: false }, class: "end" };
    const points = { show: line.points ?? this.content.x.values.length < 40, size: 5 };
    const stroke = this.colour(line, number);
    const paths = line.traced ? { paths: (plot) => traceOf(plot, line.traced) } : line.width === 0 ? { paths: () => null } : {};
    return { label: line.label, value, stroke, width: line.width ?? 2, dash: this.dash(line, number), points, spanGaps: true, ...paths };
  }

  update(content) {
    const written = () => [this.content.y, ...this.content.lines.map((line) => line.label)].join("|");
    const before = written();
    this.content = { ...this.content, ...content };
    if (written() !== before) this.draw();
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

  /* Errors as parts: those of a line together, for a band; of a line with bars, or with only one, each alone. */
  errors() {
    const { x, lines } = this.content;
    return lines.flatMap((line, number) => {
      const all = Array.from(x.values, (place, i) => [place, line.low?.[i] ?? null, line.high?.[i] ?? null]);
      const known = all.filter(([, low, high]) => low !== null && high !== null);
      if (line.bars) return known.map((one) => ({ number, places: [one] }));
      return known.length ? [{ number, places: known }] : [];
    });
  }

  drawErrors(plot) {
    const { ctx } = plot;
    const at = ([x, low, high]) => [plot.valToPos(x, "x", true), plot.valToPos(low, "y", true), plot.valToPos(high, "y", true)];
    for (const { number, places } of this.errors()) {
      const corners = places.map(at);
      ctx.save();
      ctx.strokeStyle = ctx.fillStyle = this.colour(this.content.lines[number], number);
      ctx.lineWidth = 1.5 * devicePixelRatio;
      ctx.beginPath();
      if (corners.length > 1) {
        ctx.globalAlpha = 0.25;
        corners.forEach(([x, low]) => ctx.lineTo(x, low));
        corners.reverse().forEach(([x, , high]) => ctx.lineTo(x, high));
        ctx.fill();
      } else {
        const [[x, low, high]] = corners;
        const cap = 5 * devicePixelRatio;
        for (const [a, b, c, d] of [[x, low, x, high], [x - cap, low, x + cap, low], [x - cap, high, x + cap, high]]) {
          ctx.moveTo(a, b);
          ctx.lineTo(c, d);
        }
        ctx.stroke();
      }
      ctx.restore();
    }
  }

  svg() {
    return pictureOf(this);
  }

  csv() {
    const { x, y } = this.content;
    const quoted = (words) => `"${words.replaceAll('"', '""')}"`;
    const unit = y ? `, ${y}` : "";
    const head = [quoted(x.label), ...this.columns().map((line) => quoted(`${line.label}${unit}`))];
    const rows = this.data()[0].map((_, row) => this.data().map((column) => column[row] ?? "").join(","));
    return `${head.join(",")}\n${rows.join("\n")}\n`;
  }
}

/* A line through points in their order: a loop has places that come more than once. */
function traceOf(plot, points) {
  const stroke = new Path2D();
  for (const [x, y] of points) stroke.lineTo(plot.valToPos(x, "x", true), plot.valToPos(y, "y", true));
  return { stroke, fill: null, clip: null };
}
