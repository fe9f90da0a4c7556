"use strict";
/* Panels of a study: points of each method over one axis, the best front as a thick line, a name for each point. */

function panelContent(panel) {
  const places = [...new Set(panel.lines.flatMap((line) => line.points.map((point) => point[0])))].sort((a, b) => a - b);
  const lines = panel.lines.map((line) => {
    const known = new Map(line.points.map(([x, y]) => [x, y]));
    const values = places.map((x) => known.get(x) ?? null);
    return { label: line.label, values, width: line.front ? 7 : 1.5, points: !line.front, front: line.front };
  });
  return { title: panel.title, x: { label: panel.x, values: places }, y: panel.y, lines, logarithmic: panel.logarithmic };
}

function namePoints(curve, panel) {
  const words = make("p", "", curve.figure);
  words.className = "note point";
  words.setAttribute("aria-live", "polite");
  const all = panel.lines.filter((line) => !line.front).flatMap((line) => line.points.map((point) => [line.label, ...point]));
  curve.plot.addEventListener("pointermove", () => {
    const { left, top } = curve.drawn.cursor;
    const away = ([, x, y]) => Math.hypot(curve.drawn.valToPos(x, "x") - left, curve.drawn.valToPos(y, "y") - top);
    const [label, x, y, name] = all.reduce((best, one) => (away(one) < away(best) ? one : best));
    words.textContent = `${label} ${name}: ${shortNumber(x)}, ${shortNumber(y)}`;
  });
}

function startStudy() {
  const panels = JSON.parse(document.getElementById("panels").textContent);
  const curves = panels.map((panel) => {
    const curve = new Curve(document.getElementById("curves"), panelContent(panel));
    namePoints(curve, panel);
    return curve;
  });
  followTheme(() => curves.forEach((curve) => curve.draw()));
  addEventListener("resize", () => curves.forEach((curve) => curve.draw()));
  document.documentElement.dataset.ready = "true";
}

startStudy();
