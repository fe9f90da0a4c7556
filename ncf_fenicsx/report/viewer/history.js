"use strict";
/* Curves of the history, those of all runs with one title over each other. */
class HistoryCurves {
  constructor(parent, runs) {
    this.runs = runs;
    const titles = [...new Set(runs.flatMap((run) => run.curves.map((curve) => curve.title)))];
    this.titles = titles.filter((title) => runs.some((run) => this.isDrawn(run, title)));
    const flat = titles.filter((title) => !this.titles.includes(title));
    $("flat").textContent = flat.length ? `Zero throughout: ${flat.join(", ")}.` : "";
    const known = runs.map((run) => run.abscissae.map((one) => one.column));
    this.abscissae = (runs[0]?.abscissae ?? []).filter((one) => known.every((names) => names.includes(one.column)));
    this.abscissae.forEach((one, number) => make("option", one.label, $("over")).setAttribute("value", number));
    $("over").onchange = () => this.curves.forEach((curve, i) => this.redraw(curve, this.titles[i]));
    this.curves = this.abscissae.length ? this.titles.map((title) => new Curve(parent, this.content(title))) : [];
  }

  isDrawn(run, title) {
    const curve = run.curves.find((one) => one.title === title);
    if (!curve || (curve.table === "snapshots" && !run.model)) return false;
    const columns = curve.table === "history" ? run.history : run.model.snapshot_columns;
    return curve.lines.some((line) => columns[line.column].some((value) => value !== 0));
  }

  get over() {
    return this.abscissae[Number($("over").value)];
  }

  redraw(curve, title) {
    curve.content = this.content(title);
    curve.mark = null;
    curve.draw();
  }

  content(title) {
    const tables = [];
    const lines = [];
    let unit = "";
    for (const [pattern, run] of this.runs.entries()) {
      const curve = run.curves.find((one) => one.title === title);
      if (!this.isDrawn(run, title)) continue;
      unit = curve.unit;
      const columns = curve.table === "history" ? run.history : run.model.snapshot_columns;
      tables.push([this.places(run, curve.table), ...curve.lines.map((line) => scaled(columns[line.column], curve.scale))]);
      const named = (label) => (run.prefix ? `${run.prefix}: ${label}` : label);
      const styled = this.runs.length > 1 ? (colour) => ({ colour, pattern }) : () => ({});
      lines.push(...curve.lines.map((line, number) => ({ label: named(line.label), ...styled(number) })));
    }
    const [x, ...values] = tables.length > 1 ? vendor.uPlot.join(tables) : tables[0];
    lines.forEach((line, i) => Object.assign(line, { values: values[i] }));
    return { title, x: { label: `${this.over.label} in ${this.over.unit}`, values: x }, y: unit === "1" ? "" : unit, lines };
  }

  places(run, table) {
    const values = scaled(run.history[this.over.column], this.over.scale);
    return table === "history" ? values : run.model.times.map((time) => interpolated(run.history.time, values, time));
  }

  mark(time) {
    const { history } = this.runs[0];
    const place = interpolated(history.time, scaled(history[this.over.column], this.over.scale), time);
    this.curves.forEach((curve) => curve.markAt(place));
  }
}

function scaled(values, factor) {
  return Array.from(values, (value) => (Number.isFinite(value) ? factor * value : null));
}

function interpolated(x, y, at) {
  let i = 1;
  while (i < x.length - 1 && x[i] < at) i++;
  if (x.length < 2 || x[i] === x[i - 1]) return y[0];
  return y[i - 1] + ((at - x[i - 1]) / (x[i] - x[i - 1])) * (y[i] - y[i - 1]);
}
