"use strict";
/* Puts a page to work: decodes the runs, draws their curves and views, and links the controls to them. */

const $ = (id) => document.getElementById(id);
const PLAY_MS = 250;

async function decodeRuns() {
  const runs = JSON.parse($("runs").textContent);
  for (const run of runs) {
    run.prefix = runs.length > 1 ? run.name : "";
    run.history = await decodeAll(run.history, decodeNumbers);
    run.whyNot = run.model.why_not;
    run.model = await decodeModel(run.model);
  }
  return runs;
}

/* The views of all runs, under one set of controls: steps are matched by their share of the run's time. */
class Views {
  constructor(runs, history) {
    this.runs = runs.filter((run) => run.model !== null);
    this.history = history;
    this.frames = [...document.querySelectorAll(".view")].slice(0, this.runs.length);
    const colours = Uint8Array.from(atob($("colour-map").textContent), (letter) => letter.charCodeAt(0));
    this.views = this.frames.map((frame, i) => new View(frame.querySelector("canvas"), this.runs[i].model, colours));
    this.profiles = this.views.map((view, i) => new Profiles($("curves"), this.runs[i], view));
    this.paintBar(colours);
    this.longest = this.runs.map((run) => run.model).reduce((a, b) => (b.times.length > a.times.length ? b : a));
    this.state = { step: this.longest.times.length - 1, scale: 1, apart: 0 };
    this.size = Math.max(...[0, 1].map((axis) => this.views[0].extent(axis)).map(([low, high]) => high - low));
    this.setUpControls();
    this.views.forEach((view, i) => this.listen(view, this.frames[i], i));
  }

  paintBar(colours) {
    const paint = $("colours").getContext("2d");
    paint.putImageData(new ImageData(new Uint8ClampedArray(colours), colours.length / 4, 1), 0, 0);
  }

  setUpControls() {
    const fields = new Map(this.runs.flatMap((run) => [...run.model.fields]));
    for (const [name, { label }] of fields) make("option", label, $("field")).setAttribute("value", name);
    $("step").max = this.longest.times.length - 1;
    $("step").value = this.state.step;
    $("step").oninput = () => this.go(Number($("step").value));
    $("field").onchange = $("range").onchange = () => this.show();
    $("scale").oninput = () => this.set("scale", Number($("scale").value));
    $("apart").oninput = () => {
      this.set("apart", (Number($("apart").value) / 100) * this.size);
      this.fit();
    };
    $("cut-axis").onchange = $("cut").oninput = () => this.cutSoon();
    $("side").onchange = () => this.fit();
    $("edges").checked = this.views.every((view) => view.edged);
    $("edges").onchange = () => this.views.forEach((view) => view.edges($("edges").checked));
    $("rigid").onchange = () => this.views.forEach((view) => view.rigid($("rigid").checked));
    $("mirror").disabled = this.runs.every((run) => run.model.mirrors.length === 0);
    $("mirror").onchange = () => {
      this.views.forEach((view) => view.mirror($("mirror").checked));
      this.fit();
    };
    $("reset").onclick = () => this.fit();
    $("play").onclick = () => this.play();
    $("thinned").textContent = this.runs.map(whatIsLeftOut).filter(Boolean).join(" ");
  }

  listen(view, frame, number) {
    const canvas = view.canvas;
    frame.view = view;
    frame.querySelector(".name").textContent = this.runs[number].prefix;
    view.onmove = () => this.views.forEach((other) => other !== view && other.follow(view));
    canvas.onkeydown = (event) => this.key(event, view, frame, number);
    let waiting = 0;
    canvas.onpointermove = (event) => {
      if (waiting) return;
      waiting = requestAnimationFrame(() => {
        waiting = 0;
        this.tell(frame, view, ...this.place(event, canvas));
      });
    };
    canvas.onclick = (event) => this.choose(number, event.shiftKey, ...this.place(event, canvas));
  }

  place(event, canvas) {
    const { left, top, width, height } = canvas.getBoundingClientRect();
    return [(2 * (event.clientX - left)) / width - 1, 1 - (2 * (event.clientY - top)) / height];
  }

  key(event, view, frame, number) {
    const turns = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] };
    const actions = { "+": () => view.zoom(0.9), "-": () => view.zoom(1.1), 0: () => this.fit() };
    actions.Enter = () => {
      this.tell(frame, view, 0, 0);
      this.choose(number, event.shiftKey, 0, 0);
    };
    if (turns[event.key]) view.turn(...turns[event.key]);
    else if (actions[event.key]) actions[event.key]();
    else return;
    event.preventDefault();
  }

  tell(frame, view, x, y) {
    const found = view.read(x, y);
    const { field: shown } = view.shown;
    const where = found && placeInWords(view.model, shown, found);
    const unit = shown.unit ? ` ${shown.unit}` : "";
    const read = frame.querySelector(".read");
    read.dataset.value = found ? found.value : "";
    read.textContent = found
      ? `${shown.label} ${shortNumber(found.value)}${unit}, layer ${found.layer}, ${where}`
      : "";
  }

  choose(number, beside, x, y) {
    const view = this.views[number];
    const found = view.read(x, y);
    if (!found) return;
    this.profiles[number].choose([view.centre(found.cell, 0), view.centre(found.cell, 1)], beside);
    this.profiles[number].show(this.stepOf(view.model), $("field").value);
  }

  set(name, value) {
    this.state[name] = value;
    this.show();
  }

  /* At most once a frame, so that the plane follows the slider. */
  cutSoon() {
    this.cutting ??= requestAnimationFrame(() => {
      this.cutting = null;
      this.cut();
    });
  }

  cut() {
    const axis = $("cut-axis").value === "" ? null : Number($("cut-axis").value);
    $("cut").disabled = axis === null;
    const places = this.views.map((view) => view.cutAt(axis, Number($("cut").value) / 100));
    $("shown-cut").textContent = axis === null ? "" : `${shortNumber(Number((1e3 * places[0]).toFixed(4)))} mm`;
    this.show();
  }

  play() {
    if (this.timer) {
      clearInterval(this.timer);
      this.timer = 0;
    } else {
      this.timer = setInterval(() => this.go((this.state.step + 1) % this.longest.times.length), PLAY_MS);
    }
    $("play").textContent = this.timer ? "Pause" : "Play";
  }

  go(step) {
    this.state.step = step;
    $("step").value = step;
    this.show();
  }

  /* The step of a run nearest in time to the one of the run with most steps. */
  stepOf(model) {
    if (model === this.longest) return this.state.step;
    const time = this.longest.times[this.state.step];
    const away = model.times.map((one) => Math.abs(one - time));
    return away.indexOf(Math.min(...away));
  }

  show() {
    const shown = this.runs.map((run) => run.model.fields.get($("field").value) ?? run.model.fields.values().next().value);
    const limits = this.limits(shown);
    this.views.forEach((view, i) => {
      view.show(this.stepOf(view.model), shown[i], ...limits, this.state.scale, this.state.apart);
      this.profiles[i].show(this.stepOf(view.model), $("field").value);
    });
    const unit = shown[0].unit ? ` ${shown[0].unit}` : "";
    $("low").textContent = shortNumber(limits[0]) + unit;
    $("high").textContent = shortNumber(limits[1]) + unit;
    $("range-note").textContent = `Values of ${shown[0].ofCells ? "cells" : "nodes"}, rounded by ${shown[0].rounding.toExponential(1)}${unit} at most.`;
    const time = this.longest.times[this.state.step];
    $("shown-time").textContent = `${shortNumber(time)} s, step ${this.state.step + 1} of ${this.longest.times.length}`;
    $("step").setAttribute("aria-valuetext", $("shown-time").textContent);
    $("shown-scale").textContent = `x ${this.state.scale}`;
    $("summary").textContent = this.summary(shown, unit);
    this.history.mark(time);
  }

  limits(shown) {
    const ranges = this.runs.map((run, i) => {
      const steps = $("range").value === "all" ? run.model.times.map((_, step) => step) : [this.stepOf(run.model)];
      return steps.map((step) => extremes(shown[i], step));
    });
    const flat = ranges.flat();
    return [Math.min(...flat.map((range) => range[0])), Math.max(...flat.map((range) => range[1]))];
  }

  summary(shown, unit) {
    const words = this.runs.map((run, i) => {
      const [low, high] = extremes(shown[i], this.stepOf(run.model));
      return `${run.prefix ? `${run.prefix}: ` : ""}${shortNumber(low)} to ${shortNumber(high)}${unit}`;
    });
    return `${shown[0].label} at this step: ${words.join("; ")}`;
  }

  fit() {
    this.views.forEach((view) => view.fit($("side").value));
  }

  resize() {
    this.views.forEach((view) => view.resize());
  }

  theme() {
    this.views.forEach((view) => view.theme(cssValue("--back"), cssValue("--edge")));
  }
}

const known = new WeakMap();

/* Smallest and largest value of a field at a step; looked for once. */
function extremes(shown, step) {
  if (!known.has(shown)) known.set(shown, []);
  const found = known.get(shown);
  if (!found[step]) {
    let low = Infinity;
    let high = -Infinity;
    for (let place = 0; place < shown.places; place++) {
      const value = shown.at(step, place);
      if (value < low) low = value;
      if (value > high) high = value;
    }
    found[step] = [low, high];
  }
  return found[step];
}

/* What a page has not of a run, for the sake of its size. */
function whatIsLeftOut({ prefix, model }) {
  const parts = [];
  if (model.times.length < model.steps_of_run) parts.push(`${model.times.length} of ${model.steps_of_run} steps`);
  if (model.merged > 1) {
    parts.push(`one cell in place of ${model.merged} x ${model.merged}, with their mean, and the nodes at its corners`);
  }
  return parts.length ? `${prefix ? `${prefix}: ` : ""}To keep the page small the view has ${parts.join("; ")}.` : "";
}

/* The cell or the node as the field files number it; a cell that stands for several has no number. */
function placeInWords(model, shown, { cell, node }) {
  if (!shown.ofCells) return `node ${model.nodeNumbers ? model.nodeNumbers[node] : node}`;
  return model.merged > 1 ? `mean of ${model.merged} x ${model.merged} cells` : `cell ${cell}`;
}

function whyNoView(runs) {
  if (runs.every((run) => run.model === null)) return [...new Set(runs.map((run) => run.whyNot))].join(" ");
  const context = document.createElement("canvas").getContext("webgl2");
  return context ? "" : "This browser has no WebGL 2, so the stack in 3-D is left out. The picture shows sections of it.";
}

async function start() {
  if (typeof DecompressionStream === "undefined") {
    $("no-view").textContent = "This browser is older than 2023 and cannot unpack the page's data. The tables are complete.";
    return;
  }
  const runs = await decodeRuns();
  const history = new HistoryCurves($("curves"), runs.filter((run) => run.curves.length));
  const missing = whyNoView(runs);
  let views = null;
  if (missing) {
    $("no-view").textContent = missing;
  } else {
    $("fallback").hidden = true;
    $("view").hidden = false;
    views = new Views(runs, history);
    views.resize();
    views.theme();
    views.show();
    views.fit();
  }
  const curves = () => [...history.curves, ...(views?.profiles ?? []).flatMap((profiles) => profiles.all)];
  const redraw = () => {
    views?.theme();
    curves().forEach((curve) => curve.draw());
  };
  followTheme(redraw);
  let width = innerWidth;
  addEventListener("resize", () => {
    views?.resize();
    if (innerWidth !== width) curves().forEach((curve) => curve.draw());
    width = innerWidth;
  });
  document.documentElement.dataset.ready = "true";
}

start();
