"use strict";
/* Profiles of a run at the shown step: through the stack at a chosen place, and pressure along lines under tools. */

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

function throughStack(model, column, step, name) {
  const shown = model.fields.get(name);
  return {
    title: `${shown.label} through the stack, at the chosen place`,
    x: { label: "undeformed height in mm", values: column.map((one) => 1e3 * one.z) },
    y: shown.unit,
    lines: [{ label: shown.label, values: column.map((one) => shown.at(step, one.cell)) }],
  };
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
    this.choose(this.model.place);
    const last = this.model.times.length - 1;
    const prefix = run.prefix ? `${run.prefix}: ` : "";
    this.named = (content) => ({ ...content, title: prefix + content.title });
    this.columns = this.through.map((name) => new Curve(parent, this.named(throughStack(this.model, this.column, last, name))));
    this.lines = this.model.lines.map((line) => new Curve(parent, this.named(alongLine(this.model, line, last))));
    this.axes = [0, 1].filter((axis) => this.rows[axis].some((row) => row.size > 2));
    this.along = this.axes.map((axis) => new Curve(parent, this.named(alongAxis(view, axis, this.rows[axis], last, this.name))));
    this.all = [...this.columns, ...this.along, ...this.lines];
  }

  choose(place) {
    this.column = columnAt(this.view, place);
    this.rows = [0, 1].map((axis) => rowsAlong(this.view, axis, place));
  }

  /* At a step; sections along x and y follow the field that the view shows, if it is one of cells. */
  show(step, name) {
    if (this.through.includes(name)) this.name = name;
    this.along.forEach((curve, i) => {
      curve.update(this.named(alongAxis(this.view, this.axes[i], this.rows[this.axes[i]], step, this.name)));
    });
    this.columns.forEach((curve, i) => {
      curve.update(this.named(throughStack(this.model, this.column, step, this.through[i])));
    });
    this.lines.forEach((curve, i) => curve.update(this.named(alongLine(this.model, this.model.lines[i], step))));
  }
}
