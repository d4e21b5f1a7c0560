"use strict";
// DATA is { machines, records, series }: see series.rs. Charts have records on x, one series a line.

const COLORS = ["#3b7dd8", "#d8703b", "#3ba55d", "#a05bd6", "#c9a227", "#d64a7b", "#2aa5a5", "#777777"];
const STAGES = ["generate", "extend", "sort", "shade", "connect", "order", "accumulate"];
const estimate = (name) => (point) => point[name];
const METRICS = {
  mrays: { label: "Mrays/s", of: estimate("mrays") },
  msamples: { label: "Msamples/s", of: estimate("msamples") },
  cycle: { label: "paths a million clock cycles", of: (point) => scaled(point.cycle, 1e6) },
  speedup: { label: "times as fast as scalar", of: estimate("speedup") },
  seconds: { label: "seconds of the render", of: estimate("seconds") },
};
const COUNTERS = ["node_visits", "leaf_tests", "lanes_issued", "lanes_active"];

const byId = (id) => document.getElementById(id);
const unique = (values) => [...new Set(values)];
function scaled(e, by) {
  return e && { median: e.median * by, lo: e.lo * by, hi: e.hi * by };
}
function element(parent, tag, text, attributes = {}) {
  const made = document.createElement(tag);
  if (text !== undefined) made.textContent = text;
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  parent.append(made);
  return made;
}

// Filters.

function options(select, names) {
  names.forEach(([value, label]) => element(select, "option", label, { value }));
  select.addEventListener("change", draw);
}
function boxes(fieldset, name, values) {
  values.forEach((value) => {
    const label = element(fieldset, "label");
    const box = element(label, "input", undefined, { type: "checkbox", name, value });
    box.checked = true;
    box.addEventListener("change", draw);
    label.append(" " + value);
  });
}
const checked = (name) => [...document.querySelectorAll(`input[name=${name}]:checked`)].map((box) => box.value);

function shown() {
  const machine = Number(byId("machine").value);
  const [scenes, engines, threads] = ["scene", "engine", "thread"].map(checked);
  return DATA.series.filter((series) => series.machine === machine && scenes.includes(series.scene)
    && engines.includes(series.engine) && threads.includes(String(series.threads)));
}

// Charts.

function name(series, all) {
  const base = `${series.engine} ${series.threads}`;
  const alike = all.filter((other) => other.engine === series.engine && other.threads === series.threads);
  return alike.length > 1 ? `${base} (${series.settings})` : base;
}
// The records that any of these series has, in order: what stands on x.
const recordsOf = (all) => unique(all.flatMap((s) => s.points.map((p) => p.record))).sort((a, b) => a - b);
const commit = (record) => DATA.records[record].commit.slice(0, 7) + (DATA.records[record].commit.endsWith("-dirty") ? "+" : "");
const column = (series, records, of) => records.map((record) => {
  const point = series.points.find((point) => point.record === record);
  const value = point && of(point);
  return value === undefined ? null : value;
});

const plots = [];
const HEIGHT = 260;
// `lines`: { label, values, lo, hi, color, fill, tell, changes }. `labels` are those of x.
function chart(parent, title, labels, lines, more = {}) {
  const box = element(parent, "div", undefined, { class: "chart", "data-title": title });
  element(box, "h3", title);
  const series = [{ label: more.x || "commit", value: (_, i) => labels[i] ?? "" }];
  const columns = [labels.map((_, i) => i)];
  const bands = [];
  for (const line of lines) {
    const at = columns.length;
    const told = line.tell || line.values;
    const digits = (_, value, s, i) => (told[i] === null || told[i] === undefined ? "" : told[i].toPrecision(4));
    const style = { stroke: line.color, width: 2, points: { show: true, size: 6 } };
    series.push({ label: line.label, value: digits, fill: line.fill, ...style });
    columns.push(line.values);
    if (line.hi) {
      // A band of one record would be nothing: its ends are points.
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
  const axis = { stroke: ink, grid: { stroke: "#8883" }, ticks: { stroke: "#8883" } };
  const plot = new uPlot({
    width: 320, height: HEIGHT, series, bands,
    scales: { x: { time: false, range: [-0.5, labels.length - 0.5] }, y: more.y || { range: range } },
    axes: [
      { ...axis, splits: () => splits, values: () => splits.map((i) => String(labels[i])), rotate: labels.length > 12 ? -60 : 0, size: labels.length > 12 ? 70 : 40 },
      { ...axis, size: 60 },
    ],
    legend: { live: true },
    hooks: { draw: [(u) => changes.forEach((change) => dashed(u, change))] },
  }, columns, box);
  plot.root.querySelectorAll(".u-series").forEach((row, i) => { row.hidden = i > 0 && series[i].class === "edge"; });
  plots.push(plot);
  if (more.click) plot.over.addEventListener("click", () => plot.cursor.idx !== null && more.click(plot));
  return plot;
}
// From a little below the least to a little above the greatest, and at least 10% of it.
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

function speeds(all) {
  const metric = METRICS[byId("metric").value];
  for (const scene of unique(all.map((s) => s.scene))) {
    const of = all.filter((s) => s.scene === scene && s.points.some((p) => metric.of(p)));
    if (of.length === 0) continue;
    const records = recordsOf(of);
    const lines = of.map((series, i) => ({
      label: name(series, of),
      color: COLORS[i % COLORS.length],
      values: column(series, records, (p) => metric.of(p)?.median),
      lo: column(series, records, (p) => metric.of(p)?.lo),
      hi: column(series, records, (p) => metric.of(p)?.hi),
      changes: series.points.filter((p) => p.change)
        .map((p) => ({ at: records.indexOf(p.record), confirmed: p.change.confirmed })),
    }));
    const click = (plot) => {
      const y = plot.posToVal(plot.cursor.top, "y");
      const near = lines.map((line, i) => [Math.abs((line.values[plot.cursor.idx] ?? Infinity) - y), i]);
      near.sort((a, b) => a[0] - b[0]);
      tell(of[near[0][1]], records[plot.cursor.idx]);
    };
    chart(byId("speeds"), `${scene}: ${metric.label}`, records.map(commit), lines, { click });
  }
}

function tell(series, record) {
  const point = series.points.find((point) => point.record === record);
  if (!point) return;
  const { file, time, commit, rustc, flags, os } = DATA.records[record];
  const section = byId("point");
  section.replaceChildren();
  section.hidden = false;
  element(section, "h3", `${series.scene}, ${name(series, [series])} threads, commit ${commit}`);
  const { median, lo, hi } = point.mrays;
  element(section, "div", `${median.toFixed(2)} Mrays/s (${lo.toFixed(2)} to ${hi.toFixed(2)}), ${point.blocks} blocks, ${point.contaminated} contaminated; ${series.settings}`);
  element(section, "div", `${time}, ${rustc}, ${flags}, ${os}, ${file}`);
  element(section, "pre", point.bench);
  element(section, "pre", point.render);
}

function changes(all) {
  const table = byId("changes");
  const head = element(table, "tr");
  ["commit", "time", "scene", "engine", "threads", "times as fast", ""].forEach((text) => element(head, "th", text));
  for (const series of all) {
    for (const point of series.points.filter((p) => p.change)) {
      const { ratio, confirmed } = point.change;
      const row = element(table, "tr", undefined, { class: ratio.median < 1 ? "slower" : "faster" });
      const { time } = DATA.records[point.record];
      const speed = `${ratio.median.toFixed(3)} (${ratio.lo.toFixed(3)} to ${ratio.hi.toFixed(3)})`;
      [commit(point.record), time, series.scene, series.engine, series.threads, speed,
        confirmed ? "" : "not yet confirmed"].forEach((text) => element(row, "td", text));
    }
  }
  if (table.rows.length === 1) element(element(table, "tr"), "td", "none", { colspan: 7 });
}

function stages(all) {
  const timed = (p) => Object.values(p.stages).some((seconds) => seconds > 0);
  for (const series of all.filter((s) => s.points.some(timed))) {
    const records = recordsOf([series]);
    const used = STAGES.filter((stage) => series.points.some((p) => p.stages[stage] > 0));
    const sum = (p) => used.reduce((all, stage) => all + (p.stages[stage] || 0), 0);
    // Drawn from the top: each covers what lies above the next.
    const lines = used.map((_, i) => ({
      label: used[i],
      color: COLORS[i % COLORS.length],
      fill: COLORS[i % COLORS.length],
      tell: column(series, records, (p) => (sum(p) > 0 ? (100 * (p.stages[used[i]] || 0)) / sum(p) : null)),
      values: column(series, records, (p) => {
        const upTo = used.slice(0, i + 1).reduce((all, stage) => all + (p.stages[stage] || 0), 0);
        return sum(p) > 0 ? (100 * upTo) / sum(p) : null;
      }),
    })).reverse();
    const title = `${series.scene}, ${name(series, [series])}: % of the time, stacked`;
    chart(byId("stages"), title, records.map(commit), lines, { y: { range: [0, 100] } });
  }
}

function lanes(all) {
  for (const series of all) {
    const newest = series.points.filter((p) => p.lanes.length > 0).at(-1);
    if (!newest || series.engine === "scalar") continue;
    const used = STAGES.filter((stage) => newest.lanes.some((segment) => stage in segment));
    const lines = used.map((stage, i) => ({
      label: stage,
      color: COLORS[i % COLORS.length],
      values: newest.lanes.map((segment) => (stage in segment ? 100 * segment[stage] : null)),
    }));
    const title = `${series.scene}, ${name(series, [series])}, ${commit(newest.record)}: % of lanes`;
    chart(byId("lanes"), title, newest.lanes.map((_, i) => i + 1), lines, { x: "segment", y: { range: [0, 100] } });
  }
}

function counters(all) {
  for (const series of all.filter((s) => s.points.some((p) => p.counters.lanes_issued > 0))) {
    const records = recordsOf([series]);
    const lines = COUNTERS.map((counter, i) => ({
      label: counter.replace("_", " "),
      color: COLORS[i],
      values: column(series, records, (p) => (p.counters.lanes_issued > 0 ? p.counters[counter] / p.rays : null)),
    }));
    const title = `${series.scene}, ${name(series, [series])}: a ray`;
    chart(byId("counters"), title, records.map(commit), lines, { y: { distr: 3 } });
  }
}

function draw() {
  plots.splice(0).forEach((plot) => plot.destroy());
  byId("point").hidden = true;
  for (const id of ["speeds", "changes", "stages", "lanes", "counters"]) byId(id).replaceChildren();
  const all = shown();
  speeds(all);
  changes(all);
  stages(all);
  lanes(all);
  counters(all);
  // Once all are there, the columns have their width.
  plots.forEach((plot) => plot.setSize({ width: plot.root.parentElement.clientWidth - 24, height: HEIGHT }));
}

options(byId("machine"), DATA.machines.map((label, i) => [i, label]));
options(byId("metric"), Object.entries(METRICS).map(([value, { label }]) => [value, label]));
boxes(byId("scenes"), "scene", unique(DATA.series.map((s) => s.scene)));
boxes(byId("engines"), "engine", unique(DATA.series.map((s) => s.engine)));
boxes(byId("threads"), "thread", unique(DATA.series.map((s) => String(s.threads))));
// The machine of the newest record first.
byId("machine").value = DATA.series.reduce((best, s) => (s.points.at(-1).record >= best.record ? { record: s.points.at(-1).record, machine: s.machine } : best), { record: -1, machine: 0 }).machine;
draw();
let resizing;
addEventListener("resize", () => { clearTimeout(resizing); resizing = setTimeout(draw, 200); });
