"use strict";
/* A figure of curves as an SVG file, as uPlot shows it: with its scales and marks of the axes. */

const FRAME = { width: 640, height: 400, left: 70, top: 36, right: 620, bottom: 340 };
const PAPER = ["#005cab", "#b35900", "#007a5a", "#8a3f91", "#a3123a", "#5c5c00"];

function isLogarithmic(curve, axis) {
  const { logarithmic } = curve.content;
  return logarithmic === "both" || logarithmic === axis;
}

/* Places in the picture of numbers along both axes. */
function placesOf(curve) {
  const along = (name, from, to) => (number) => {
    const log = isLogarithmic(curve, name) ? Math.log10 : (one) => one;
    const { min, max } = curve.drawn.scales[name];
    const [low, high] = [log(min), log(max)];
    return from + ((log(number) - low) / (high - low || 1)) * (to - from);
  };
  return [along("x", FRAME.left, FRAME.right), along("y", FRAME.bottom, FRAME.top)];
}

function pictureOf(curve) {
  const image = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  image.setAttribute("xmlns", "http://www.w3.org/2000/svg");
  const put = (tag, attributes, words = "") => {
    const part = document.createElementNS("http://www.w3.org/2000/svg", tag);
    Object.entries(attributes).forEach(([name, value]) => part.setAttribute(name, value));
    part.textContent = words;
    image.append(part);
  };
  image.setAttribute("viewBox", `0 0 ${FRAME.width} ${FRAME.height}`);
  image.setAttribute("font-family", "sans-serif");
  image.setAttribute("font-size", 12);
  const places = placesOf(curve);
  putAxes(curve, put, places);
  putErrors(curve, put, places);
  putLines(curve, put, places);
  return new XMLSerializer().serializeToString(image);
}

function putAxes(curve, put, [toX, toY]) {
  const { x, y, title } = curve.content;
  const { width, height, left, top, right, bottom } = FRAME;
  put("rect", { x: 0, y: 0, width, height, fill: "white" });
  put("rect", { x: left, y: top, width: right - left, height: bottom - top, fill: "none", stroke: "#777" });
  put("text", { x: left, y: 20, "font-size": 14, "font-weight": "bold" }, title);
  put("text", { x: (left + right) / 2, y: height - 22, "text-anchor": "middle" }, x.label);
  put("text", { transform: `translate(14 ${(top + bottom) / 2}) rotate(-90)`, "text-anchor": "middle" }, y);
  const marks = (name) => ticks(curve.drawn.scales[name].min, curve.drawn.scales[name].max, isLogarithmic(curve, name));
  const named = x.names?.map((name, i) => [i + 1, name]) ?? marks("x").map((tick) => [tick, shortNumber(tick)]);
  for (const [tick, name] of named) put("text", { x: toX(tick), y: bottom + 16, "text-anchor": "middle" }, name);
  for (const tick of marks("y")) put("text", { x: left - 6, y: toY(tick) + 4, "text-anchor": "end" }, shortNumber(tick));
}

function strokeOf(line, number) {
  return line.front ? "#bbbbbb" : PAPER[(line.colour ?? number) % 6];
}

function putErrors(curve, put, [toX, toY]) {
  for (const { number, places } of curve.errors()) {
    const colour = strokeOf(curve.content.lines[number], number);
    const low = places.map(([x, end]) => `${toX(x)},${toY(end)}`);
    const high = places.map(([x, , end]) => `${toX(x)},${toY(end)}`);
    if (places.length > 1) {
      put("polygon", { points: [...low, ...high.reverse()].join(" "), fill: colour, "fill-opacity": 0.25 });
    } else {
      put("path", { d: `M${low[0]} m-4,0 h8 m-4,0 L${high[0]} m-4,0 h8`, stroke: colour, fill: "none" });
    }
  }
}

function putLines(curve, put, [toX, toY]) {
  const { x, lines } = curve.content;
  lines.forEach((line, number) => {
    const stroke = strokeOf(line, number);
    const points = line.traced || Array.from(line.values, (value, i) => [x.values[i], value]).filter((point) => point[1] !== null);
    const places = points.map(([a, b]) => [toX(a), toY(b)]);
    const style = { fill: "none", stroke, "stroke-width": line.width ?? 2, "stroke-dasharray": curve.dash(line, number).join(" ") };
    if (line.width === 0) places.forEach(([cx, cy]) => put("circle", { cx, cy, r: 3, fill: stroke }));
    else put("polyline", { points: places.join(" "), ...style });
    put("text", { x: FRAME.right - 4, y: FRAME.top + 16 + 15 * number, fill: stroke, "text-anchor": "end" }, line.label);
  });
}

/* About five round numbers between two; powers of ten, or 1, 2 and 5, on a logarithmic axis. */
function ticks(low, high, logarithmic) {
  if (!(high > low)) return [low];
  const found = [];
  if (logarithmic) {
    for (let power = Math.floor(Math.log10(low)); 10 ** power <= high; power++) {
      found.push(...[1, 2, 5].map((first) => first * 10 ** power).filter((tick) => tick >= low && tick <= high));
    }
    return found.length > 6 ? found.filter((tick) => Number.isInteger(Math.log10(tick))) : found;
  }
  const rough = 10 ** Math.floor(Math.log10((high - low) / 4));
  const step = [1, 2, 5, 10].map((factor) => factor * rough).find((size) => (high - low) / size <= 6);
  for (let tick = Math.ceil(low / step); tick * step <= high; tick++) found.push(tick * step);
  return found;
}
