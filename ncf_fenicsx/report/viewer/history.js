"use strict";
/* Curves of the history, those of all runs with one title over each other. */
class HistoryCurves {
  constructor(parent, runs) {
    this.runs = runs;
    const titles = [...new Set(runs.flatMap((run) => run.curves.map((curve) => curve.title)))];
    this.titles = titles.filter((title) => runs.some((run) => this.isDrawn(run, title)));
    const flat = titles.filter((title) => !this.titles.includes(title));
    flat.forEach((title) => document.getElementById(this.idOf(title))?.remove());
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
    return curve.lines.some((line) => columns[line.column]?.some((value) => value !== 0));
  }

  /* Of the figure that the page keeps for a curve of its one run. */
  idOf(title) {
    return this.runs.length > 1 ? "" : this.runs[0].curves.find((curve) => curve.title === title).id;
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
    const notes = [];
    let unit = "";
    for (const [pattern, run] of this.runs.entries()) {
      const curve = run.curves.find((one) => one.title === title);
      if (!this.isDrawn(run, title)) continue;
      unit = curve.unit;
      const columns = curve.table === "history" ? run.history : run.model.snapshot_columns;
      const named = (label) => (run.prefix ? `${run.prefix}: ${label}` : label);
      const styled = this.runs.length > 1 ? (colour) => ({ colour, pattern }) : () => ({});
      const values = [];
      curve.lines.forEach((line, number) => {
        const ends = endsOf(curve, line.column, columns);
        values.push(...[columns[line.column], ...ends].map((column) => scaled(column, curve.scale)));
        lines.push({ label: named(line.label), hasEnds: ends.length > 0, ...styled(number) });
      });
      tables.push([this.places(run, curve.table), ...values]);
      if (curve.note) notes.push(named(curve.note));
    }
    const [x, ...values] = tables.length > 1 ? vendor.uPlot.join(tables) : tables[0];
    for (const line of lines) {
      line.values = values.shift();
      if (line.hasEnds) [line.low, line.high] = values.splice(0, 2);
    }
    const axis = { label: `${this.over.label} in ${this.over.unit}`, values: x };
    return { title, id: this.idOf(title), note: notes.join(" "), x: axis, y: unit === "1" ? "" : unit, lines };
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

/* Lower and upper ends of the errors of a column: none, of all its rows, or of the one that has a bar. */
function endsOf({ bands, bar }, column, columns) {
  const values = columns[column];
  const half = columns[bands?.[column]];
  if (half) {
    return [values.map((value, i) => value - half[i]), values.map((value, i) => value + half[i])];
  }
  if (bar?.column !== column) return [];
  const alone = (end) => values.map((_, i) => (i === bar.row ? end : NaN));
  return [alone(values[bar.row] - bar.half), alone(values[bar.row] + bar.half)];
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
