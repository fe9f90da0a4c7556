"use strict";
/* Panels of a study: points under names, best fronts and means as thick lines, a name for each point. */

/* Places along x, each as often as a line has points there, and the points of each line by place. */
function tableOf(lines) {
  const counts = new Map();
  for (const { points } of lines) {
    const own = new Map();
    for (const [x] of points) own.set(x, (own.get(x) ?? 0) + 1);
    own.forEach((count, x) => counts.set(x, Math.max(count, counts.get(x) ?? 0)));
  }
  const places = [...counts.keys()].sort((a, b) => a - b).flatMap((x) => Array(counts.get(x)).fill(x));
  const rows = lines.map(({ points }) => {
    const waiting = new Map();
    for (const point of points) waiting.set(point[0], [...(waiting.get(point[0]) ?? []), point]);
    return places.map((x) => waiting.get(x)?.shift() ?? null);
  });
  return { places, rows };
}

/* So that the outermost points are whole; half a place beside names. */
function rangeWithMargins({ names, logarithmic }, places) {
  if (names) return [0.5, names.length + 0.5];
  const [low, high] = [places[0], places[places.length - 1]];
  if (logarithmic) return [low / (high / low) ** 0.06 / 1.02, high * (high / low) ** 0.06 * 1.02];
  const margin = 0.05 * (high - low) || 0.5 * Math.abs(low) || 1;
  return [low - margin, high + margin];
}

function panelContent(panel) {
  const { places, rows } = tableOf(panel.lines);
  const lines = panel.lines.map((line, number) => {
    const part = (index) => rows[number].map((point) => point?.[index] ?? null);
    const width = line.apart ? 0 : line.front ? 7 : 1.5;
    const ends = line.points.some((point) => point.length > 3) ? { low: part(3), high: part(4), bars: line.bars } : {};
    const look = { width, points: !line.front && !line.traced, front: line.front, ...(line.colour === undefined ? {} : { colour: line.colour }) };
    return { label: line.label, values: part(1), ...look, traced: line.traced && line.points, ...ends };
  });
  const x = { label: panel.x, values: places, names: panel.names, range: rangeWithMargins(panel, places) };
  return { title: panel.title, x, y: panel.y, lines, logarithmic: panel.logarithmic, note: panel.note };
}

function namePoints(curve, panel) {
  const words = make("p", "", curve.figure);
  words.className = "note point";
  words.setAttribute("aria-live", "polite");
  const all = panel.lines.flatMap((line) => line.points.filter((point) => point[2]).map((point) => [line.label, ...point]));
  if (!all.length) return;
  curve.plot.addEventListener("pointermove", () => {
    const { left, top } = curve.drawn.cursor;
    const away = ([, x, y]) => Math.hypot(curve.drawn.valToPos(x, "x") - left, curve.drawn.valToPos(y, "y") - top);
    const [label, x, y, name] = all.reduce((best, one) => (away(one) < away(best) ? one : best));
    const where = panel.names ? "" : `${shortNumber(x)}, `;
    words.textContent = `${label} ${name}: ${where}${shortNumber(y)}`;
  });
}

/* Panels of one group at a time, where there are several. */
function chooseGroup(curves, panels) {
  const groups = [...new Set(panels.map((panel) => panel.group).filter(Boolean))];
  if (groups.length < 2) return;
  const label = make("label", "Result ", document.getElementById("groups"));
  const choice = make("select", "", label);
  choice.id = "group";
  for (const group of groups) make("option", group, choice);
  choice.onchange = () => {
    curves.forEach((curve, i) => {
      curve.figure.hidden = panels[i].group !== choice.value;
      if (!curve.figure.hidden) curve.draw();
    });
  };
  choice.onchange();
}

function startStudy() {
  const panels = JSON.parse(document.getElementById("panels").textContent);
  const across = JSON.parse(document.getElementById("across").textContent);
  const curves = panels.map((panel) => {
    const curve = new Curve(document.getElementById("curves"), panelContent(panel));
    namePoints(curve, panel);
    return curve;
  });
  curves.forEach((curve) => curve.draw()); // the width of each is known once all are there
  chooseGroup(curves, panels);
  if (document.getElementById("parallel")) drawParallel(document.getElementById("parallel"), across);
  followTheme(() => curves.forEach((curve) => curve.draw()));
  addEventListener("resize", () => curves.forEach((curve) => curve.draw()));
  document.documentElement.dataset.ready = "true";
}

startStudy();
