"use strict";
/* Runs of a study as lines across parallel axes of inputs and results, coloured by the first result. */

const AXES = { step: 150, height: 260, top: 34, side: 70 };

function svgPart(tag, attributes, parent, words = "") {
  const part = document.createElementNS("http://www.w3.org/2000/svg", tag);
  Object.entries(attributes).forEach(([name, value]) => part.setAttribute(name, value));
  part.textContent = words;
  parent.append(part);
  return part;
}

/* Lowest and highest number of an axis. */
function rangeOf(axis) {
  const known = axis.values.filter((value) => value !== null);
  return known.reduce(([low, high], value) => [Math.min(low, value), Math.max(high, value)], [Infinity, -Infinity]);
}

function shareOf(axis, value) {
  const [low, high] = rangeOf(axis);
  return high > low ? (value - low) / (high - low) : 0.5;
}

function textOf(axis, value) {
  return axis.words ? axis.words[value] : shortNumber(value);
}

/* Of the map viridis, without its ends, which do not stand out on a dark or a light page. */
const SHADES = [[70, 50, 126], [54, 92, 141], [39, 127, 142], [31, 161, 135], [74, 193, 109], [160, 218, 57]];

function shade(share) {
  const place = share * (SHADES.length - 1);
  const [lower, upper] = [SHADES[Math.floor(place)], SHADES[Math.ceil(place)]];
  const mixed = lower.map((part, i) => Math.round(part + (place % 1) * (upper[i] - part)));
  return `rgb(${mixed.join(" ")})`;
}

function drawAxis(axis, number, image) {
  const x = AXES.side + AXES.step * number;
  svgPart("line", { x1: x, x2: x, y1: AXES.top, y2: AXES.top + AXES.height, class: "axis" }, image);
  const marks = axis.words ? axis.words.map((_, i) => i) : rangeOf(axis);
  for (const value of new Set(marks)) {
    const y = AXES.top + AXES.height * (1 - shareOf(axis, value));
    svgPart("text", { x: x + 5, y: y + 4, class: "mark" }, image, textOf(axis, value));
  }
  const [name, unit] = axis.heading.split(" [");
  const words = name.split(".").slice(-2).join(".") + (unit ? ` [${unit}` : "");
  const label = svgPart("text", { x, y: AXES.top + AXES.height + (number % 2 ? 38 : 20), "text-anchor": "middle" }, image, words);
  svgPart("title", {}, label, axis.heading);
}

/* Lines of the runs; a call to read the next one or the one before, which then stands in front. */
function drawRuns(axes, runs, scale, image, words) {
  const lines = runs.map((name, run) => {
    const places = axes.map((axis, i) => [AXES.side + AXES.step * i, axis.values[run], axis]).filter((one) => one[1] !== null);
    const points = places.map(([x, value, axis]) => `${x},${AXES.top + AXES.height * (1 - shareOf(axis, value))}`).join(" ");
    const stroke = scale.values[run] === null ? "grey" : shade(shareOf(scale, scale.values[run]));
    const line = svgPart("polyline", { points, stroke, class: "run" }, image);
    const said = `${name}: ${places.map(([, value, axis]) => `${axis.heading} ${textOf(axis, value)}`).join(", ")}`;
    line.addEventListener("pointerenter", () => show(run));
    return { line, said };
  });
  let shown = -1;
  function show(run) {
    shown = run;
    lines.forEach(({ line }, i) => line.classList.toggle("shown", i === run));
    lines.at(run).line.parentNode.append(lines.at(run).line);
    words.textContent = lines.at(run).said;
  }
  return (by) => show(shown < 0 && by < 0 ? runs.length - 1 : (shown + by + runs.length) % runs.length);
}

function drawParallel(parent, { axes, runs, of, coloured }) {
  const width = 2 * AXES.side + AXES.step * (axes.length - 1);
  const frame = make("div", "", parent);
  frame.className = "scroll";
  frame.tabIndex = 0;
  const attributes = { viewBox: `0 0 ${width} ${AXES.top + AXES.height + 48}`, role: "img", width };
  const image = svgPart("svg", { ...attributes, "aria-label": "Each run as a line across its inputs and results" }, frame);
  const words = make("p", "Point at a line to read its run, or press the up and down keys.", parent);
  words.className = "note";
  words.setAttribute("aria-live", "polite");
  words.id = "shown-run";
  const scale = axes[Math.min(coloured, axes.length - 1)];
  const step = drawRuns(axes, runs, scale, svgPart("g", {}, image), words);
  frame.addEventListener("keydown", (event) => {
    const by = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    if (!by) return;
    event.preventDefault();
    step(by);
  });
  axes.forEach((axis, number) => drawAxis(axis, number, image));
  const thinned = runs.length < of ? `${runs.length} of ${of} runs are drawn. ` : "";
  make("p", `${thinned}Lines are coloured by ${scale.heading}, dark for little, light for much.`, parent).className = "note";
}
