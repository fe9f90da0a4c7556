"use strict";
/* Profiles of a run at the shown step: through the stack at a chosen place, and pressure along lines under tools. */

const MOST_PLACES = 4;

/* Cells of the column nearest to a place (x, y) in m, from the bottom up. */
function columnAt(view, place) {
  const { cells } = view.model;
  const found = new Map();
  for (let cell = 0; cell < cells.length / 8; cell++) {
    const [x, y, z] = [0, 1, 2].map((axis) => view.centre(cell, axis));
    const level = `${view.model.layer[cell]} ${z.toFixed(7)}`;
    const distance = Math.hypot(x - place[0], y - place[1]);
    if (!(found.get(level)?.distance <= distance)) found.set(level, { cell, distance, z });
  }
  const nearest = Math.min(...[...found.values()].map((one) => one.distance));
  const [low, high] = view.extent(0);
  const near = [...found.values()].filter((one) => one.distance <= nearest + 1e-3 * (high - low));
  return near.sort((a, b) => a.z - b.z);
}

/* A field of cells over the height, a line for each chosen place. */
function throughStack(model, columns, step, name) {
  const shown = model.fields.get(name);
  const level = (one) => one.z.toFixed(7);
  const heights = [...new Set(columns.flatMap(({ cells }) => cells.map(level)))].sort((a, b) => a - b);
  const lines = columns.map(({ label, cells }) => {
    const known = new Map(cells.map((one) => [level(one), one.cell]));
    return { label, values: heights.map((height) => (known.has(height) ? shown.at(step, known.get(height)) : null)) };
  });
  const x = { label: "undeformed height in mm", values: heights.map((height) => 1e3 * height) };
  return { title: `${shown.label} through the stack`, x, y: shown.unit, lines };
}

/* Cells that the line along an axis through a place (x, y) in m goes through, by layer, in the order of the axis. */
function rowsAlong(view, axis, place) {
  const { cells, points, layer, layers } = view.model;
  const across = 1 - axis;
  const [start, end] = view.extent(across);
  const at = Math.min(Math.max(place[across], start), end - 1e-9 * (end - start));
  const rows = Array.from({ length: layers }, () => new Map());
  for (let cell = 0; cell < cells.length / 8; cell++) {
    let [low, high] = [Infinity, -Infinity];
    for (let corner = 0; corner < 8; corner++) {
      const value = points[3 * cells[8 * cell + corner] + across];
      if (value < low) low = value;
      if (value > high) high = value;
    }
    if (low > at || high <= at) continue;
    const where = view.centre(cell, axis).toFixed(7);
    const row = rows[layer[cell] - 1];
    row.set(where, [...(row.get(where) ?? []), cell]);
  }
  return rows;
}

/* A field of cells along an axis, a line for each layer: means through the layer. */
function alongAxis(view, axis, rows, step, name) {
  const shown = view.model.fields.get(name);
  const places = [...new Set(rows.flatMap((row) => [...row.keys()]))].sort((a, b) => a - b);
  const mean = (cells) => cells && cells.reduce((sum, cell) => sum + shown.at(step, cell), 0) / cells.length;
  return {
    title: `${shown.label} along ${"xy"[axis]}, through the chosen place`,
    x: { label: `undeformed ${"xy"[axis]} in mm`, values: places.map((place) => 1e3 * place) },
    y: shown.unit,
    lines: rows.map((row, i) => ({ label: `layer ${i + 1}`, values: places.map((place) => mean(row.get(place)) ?? null) })),
  };
}

function alongLine(model, line, step) {
  const pressure = model.fields.get("contact_pressure");
  return {
    title: line.title,
    x: { label: `${"xy"[line.axis]} in mm`, values: line.nodes.map((node) => 1e3 * model.points[3 * node + line.axis]) },
    y: pressure.unit,
    lines: [{ label: "contact pressure", values: line.nodes.map((node) => pressure.at(step, node)) }],
  };
}

class Profiles {
  constructor(parent, run, view) {
    this.model = run.model;
    this.view = view;
    const known = ["volume_fraction", "stress_33", "permeability_along", "permeability_across"];
    this.through = known.filter((name) => this.model.fields.has(name));
    this.name = this.through[0];
    this.places = [];
    this.choose(this.model.place, false);
    const last = this.model.times.length - 1;
    const prefix = run.prefix ? `${run.prefix}: ` : "";
    this.named = (content) => ({ ...content, title: prefix + content.title });
    this.columns = this.through.map((name) => new Curve(parent, this.named(throughStack(this.model, this.chosen, last, name))));
    this.lines = this.model.lines.map((line) => new Curve(parent, this.named(alongLine(this.model, line, last))));
    this.axes = [0, 1].filter((axis) => this.rows[axis].some((row) => row.size > 2));
    this.along = this.axes.map((axis) => new Curve(parent, this.named(alongAxis(view, axis, this.rows[axis], last, this.name))));
    this.all = [...this.columns, ...this.along, ...this.lines];
  }

  /* Takes a place (x, y) in m alone, or beside those before; sections along x and y go through the last one. */
  choose(place, beside) {
    this.places = [...(beside ? this.places : []), place].slice(-MOST_PLACES);
    this.chosen = this.places.map((one) => {
      const cells = columnAt(this.view, one);
      const middle = [0, 1].map((axis) => shortNumber(1e3 * this.view.centre(cells[0].cell, axis)));
      return { label: `at ${middle.join(", ")} mm`, cells };
    });
    this.rows = [0, 1].map((axis) => rowsAlong(this.view, axis, place));
  }

  /* At a step; sections along x and y follow the field that the view shows, if it is one of cells. */
  show(step, name) {
    if (this.through.includes(name)) this.name = name;
    this.along.forEach((curve, i) => {
      curve.update(this.named(alongAxis(this.view, this.axes[i], this.rows[this.axes[i]], step, this.name)));
    });
    this.columns.forEach((curve, i) => {
      curve.update(this.named(throughStack(this.model, this.chosen, step, this.through[i])));
    });
    this.lines.forEach((curve, i) => curve.update(this.named(alongLine(this.model, this.model.lines[i], step))));
  }
}
