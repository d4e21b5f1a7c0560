"use strict";
// Charts: lines with bands for intervals, over labelled positions on x.

function element(parent, tag, text, attributes = {}) {
  const made = document.createElement(tag);
  if (text !== undefined) made.textContent = text;
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  parent.append(made);
  return made;
}
const shortened = (value) => (Math.abs(value) >= 1000 ? Math.round(value).toLocaleString("en") : value.toPrecision(4));

const plots = [];
const HEIGHT = 260;
// Draws `lines`, each { label, values, lo, hi, color, fill, shown, changes }, over the `labels` of x.
function chart(parent, title, labels, lines, more = {}) {
  const box = element(parent, "div", undefined, { class: "chart", "data-title": title });
  element(box, "h3", title);
  const series = [{ label: more.x || "commit", value: (_, i) => labels[i] ?? "" }];
  const columns = [labels.map((_, i) => i)];
  const bands = [];
  for (const line of lines) {
    const at = columns.length;
    const values = line.shown || line.values;
    const digits = (_, value, s, i) => (values[i] === null || values[i] === undefined ? "" : shortened(values[i]));
    const style = { stroke: line.color, width: 2, points: { show: true, size: 6 } };
    series.push({ label: line.label, value: digits, fill: line.fill, ...style });
    columns.push(line.values);
    if (line.hi) {
      // With a single record the band would be invisible, so its ends are drawn as points.
      const points = { show: labels.length === 1, size: 4, stroke: line.color };
      const edge = { stroke: "transparent", points, class: "edge" };
      series.push({ ...edge, label: "hi" }, { ...edge, label: "lo" });
      columns.push(line.hi, line.lo);
      bands.push({ series: [at + 1, at + 2], fill: line.color + "40" });
    }
  }
  const changes = lines.flatMap((line) => (line.changes || []).map((change) => ({ ...change, color: line.color })));
  const every = Math.ceil(labels.length / 40);
  const splits = labels.map((_, i) => i).filter((i) => i % every === 0);
  const ink = matchMedia("(prefers-color-scheme: dark)").matches ? "#ccc" : "#333";
  const crowded = labels.length > (innerWidth < 700 ? 5 : 12);
  const axis = { stroke: ink, grid: { stroke: "#8883" }, ticks: { stroke: "#8883" } };
  const plot = new uPlot({
    width: 320, height: HEIGHT, series, bands,
    scales: { x: { time: false, range: [-0.5, labels.length - 0.5] }, y: more.y || { range: range } },
    axes: [
      { ...axis, splits: () => splits, values: () => splits.map((i) => String(labels[i])), rotate: crowded ? -60 : 0, size: crowded ? 70 : 40 },
      { ...axis, size: 60 },
    ],
    legend: { live: true },
    hooks: { draw: [(u) => changes.forEach((change) => dashed(u, change))] },
  }, columns, box);
  plot.root.querySelectorAll(".u-series").forEach((row, i) => { row.hidden = i > 0 && series[i].class === "edge"; });
  plot.over.setAttribute("role", "img");
  plot.over.setAttribute("aria-label", `${title}: ${lines.map((line) => line.label).join(", ")}`);
  plots.push(plot);
  if (more.click) plot.over.addEventListener("click", () => plot.cursor.idx !== null && more.click(plot));
  return plot;
}
// The range from a little below the smallest value to a little above the largest, with at least 5% of the
// largest as a margin on either side.
function range(_, lo, hi) {
  if (lo === null || hi === null) return [0, 1];
  const room = Math.max((hi - lo) * 0.15, Math.abs(hi) * 0.05, 1e-9);
  return [Math.max(0, lo - room), hi + room];
}
function dashed(u, { at, color, confirmed }) {
  const x = Math.round(u.valToPos(at, "x", true));
  const { ctx, bbox } = u;
  ctx.save();
  ctx.setLineDash(confirmed ? [6, 5] : [2, 6]);
  ctx.strokeStyle = color;
  ctx.lineWidth = confirmed ? 2 : 1;
  ctx.beginPath();
  ctx.moveTo(x, bbox.top);
  ctx.lineTo(x, bbox.top + bbox.height);
  ctx.stroke();
  ctx.restore();
}
