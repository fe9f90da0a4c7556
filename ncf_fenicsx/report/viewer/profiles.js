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
    this.through = ["volume_fraction", "stress_33"].filter((name) => this.model.fields.has(name));
    this.choose(this.model.place);
    const last = this.model.times.length - 1;
    const prefix = run.prefix ? `${run.prefix}: ` : "";
    this.named = (content) => ({ ...content, title: prefix + content.title });
    this.columns = this.through.map((name) => new Curve(parent, this.named(throughStack(this.model, this.column, last, name))));
    this.lines = this.model.lines.map((line) => new Curve(parent, this.named(alongLine(this.model, line, last))));
    this.all = [...this.columns, ...this.lines];
  }

  choose(place) {
    this.column = columnAt(this.view, place);
  }

  show(step) {
    this.columns.forEach((curve, i) => {
      curve.update(this.named(throughStack(this.model, this.column, step, this.through[i])));
    });
    this.lines.forEach((curve, i) => curve.update(this.named(alongLine(this.model, this.model.lines[i], step))));
  }
}
