"use strict";
/* Undoes ncf_fenicsx/report/encoding.py: base64, deflate, bytes sorted by significance, differences, whole numbers. */

async function inflate(text) {
  const packed = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

function gathered(planes, bytes) {
  const count = planes.length / bytes;
  const values = new Uint8Array(planes.length);
  for (let byte = 0; byte < bytes; byte++) {
    for (let i = 0; i < count; i++) values[bytes * i + byte] = planes[byte * count + i];
  }
  return values.buffer;
}

function summed(values, columns) {
  for (let i = columns; i < values.length; i++) values[i] += values[i - columns];
  return values;
}

async function decodeNumbers(encoded) {
  const bytes = encoded.bits / 8;
  const buffer = gathered(await inflate(encoded.data), bytes);
  return encoded.bits === 64 ? new Float64Array(buffer) : new Float32Array(buffer);
}

async function decodeTable(encoded) {
  return summed(new Int32Array(gathered(await inflate(encoded.data), 4)), encoded.shape[1]);
}

async function decodeSeries(encoded) {
  const [, places] = encoded.shape;
  const whole = summed(new Uint16Array(gathered(await inflate(encoded.data), 2)), places);
  return { low: encoded.low, step: encoded.step, places, whole };
}

async function decodeAll(encodedByName, decode) {
  const names = Object.keys(encodedByName);
  const decoded = await Promise.all(names.map((name) => decode(encodedByName[name])));
  return Object.fromEntries(names.map((name, i) => [name, decoded[i]]));
}

async function decodeModel(model) {
  if (model.why_not) return null;
  const [points, cells, neighbours, layer, nodes, byCell, nodeNumbers] = await Promise.all([
    decodeNumbers(model.points),
    decodeTable(model.cells),
    decodeTable(model.neighbours),
    decodeTable(model.layer),
    decodeAll(model.nodes, decodeSeries),
    decodeAll(model.by_cell, decodeSeries),
    model.node_numbers && decodeTable(model.node_numbers),
  ]);
  return { ...model, points, cells, neighbours, layer, nodes, byCell, nodeNumbers, fields: namedFields(nodes, byCell) };
}

/* A field: its label, factor from SI to its unit, whether of cells, and its value at a step and a place. */
const LABELS = {
  volume_fraction: ["Fibre volume fraction", "", 1],
  stress_33: ["Stress across the layer", "kPa", 1e-3],
  contact_pressure: ["Contact pressure", "kPa", 1e-3],
  gap: ["Gap between layers", "mm", 1e3],
  slip: ["Slip of layers", "mm", 1e3],
  permeability_along: ["Permeability along the fibres", "m2", 1],
  permeability_across: ["Permeability across the fibres", "m2", 1],
  displacement_x: ["Displacement along x", "mm", 1e3],
  displacement_y: ["Displacement along y", "mm", 1e3],
  displacement_z: ["Displacement along z", "mm", 1e3],
  displacement: ["Displacement, size", "mm", 1e3],
};

function valueOf(series, step, place) {
  return series.low + series.step * series.whole[step * series.places + place];
}

function field(name, series, ofCells) {
  const [label, unit, factor] = LABELS[name] ?? [name, "SI", 1];
  const at = (step, place) => factor * valueOf(series, step, place);
  return { name, label, unit, ofCells, at, places: series.places, rounding: factor * series.step / 2 };
}

function namedFields(nodes, byCell) {
  const found = Object.entries(byCell).map(([name, series]) => field(name, series, true));
  found.push(...Object.entries(nodes).map(([name, series]) => field(name, series, false)));
  const parts = ["x", "y", "z"].map((axis) => nodes[`displacement_${axis}`]);
  const at = (step, place) => 1e3 * Math.hypot(...parts.map((part) => valueOf(part, step, place)));
  const rounding = 1e3 * Math.hypot(...parts.map((part) => part.step / 2));
  found.push({ ...field("displacement", parts[0], false), at, rounding });
  const order = Object.keys(LABELS);
  found.sort((a, b) => order.indexOf(a.name) - order.indexOf(b.name));
  return new Map(found.map((one) => [one.name, one]));
}

function shortNumber(value) {
  if (value === 0 || value === null || !Number.isFinite(value)) return value === 0 ? "0" : "–";
  const size = Math.abs(value);
  const rounded = Number(value.toPrecision(4));
  return size >= 1e6 || size < 1e-4 ? rounded.toExponential() : String(rounded);
}
