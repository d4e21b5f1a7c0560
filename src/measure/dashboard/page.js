"use strict";
// DATA is { machines, records, series }, see series.rs. Charts have records on x and one line per series.

const COLORS = ["#3b7dd8", "#d8703b", "#3ba55d", "#a05bd6", "#c9a227", "#d64a7b", "#2aa5a5", "#777777"];
const STAGES = ["generate", "extend", "sort", "shade", "connect", "order", "accumulate"];
const estimate = (name) => (point) => point[name];
const METRICS = {
  mrays: { label: "Mrays/s", of: estimate("mrays") },
  msamples: { label: "Msamples/s", of: estimate("msamples") },
  cycle: { label: "paths per million clock cycles", of: (point) => scaled(point.cycle, 1e6) },
  speedup: { label: "speed relative to scalar", of: estimate("speedup") },
  seconds: { label: "seconds per render", of: estimate("seconds") },
};
const COUNTERS = ["node_visits", "leaf_tests", "lanes_issued", "lanes_active"];

const byId = (id) => document.getElementById(id);
const unique = (values) => [...new Set(values)];
const keyOf = (series) => `${series.engine} ${series.threads}`;
// Each engine and number of threads keeps its colour, whatever the filters show.
const KEYS = unique(DATA.series.map(keyOf));
function scaled(e, by) {
  return e && { median: e.median * by, lo: e.lo * by, hi: e.hi * by };
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

const label = (series) => `${series.engine}, ${series.threads} ${series.threads === 1 ? "thread" : "threads"}`;
function name(series, all) {
  const alike = all.filter((other) => keyOf(other) === keyOf(series));
  return alike.length > 1 ? `${label(series)} (${series.settings})` : label(series);
}
function color(series, all) {
  const alike = all.filter((other) => keyOf(other) === keyOf(series));
  return COLORS[(KEYS.indexOf(keyOf(series)) + KEYS.length * alike.indexOf(series)) % COLORS.length];
}
// The records of any of these series in order, which are the positions on x.
const recordsOf = (all) => unique(all.flatMap((s) => s.points.map((p) => p.record))).sort((a, b) => a - b);
const commit = (record) => DATA.records[record].commit.slice(0, 7) + (DATA.records[record].commit.endsWith("-dirty") ? "+" : "");
const column = (series, records, of) => records.map((record) => {
  const point = series.points.find((point) => point.record === record);
  const value = point && of(point);
  return value === undefined ? null : value;
});

function speeds(all) {
  const metric = METRICS[byId("metric").value];
  for (const scene of unique(all.map((s) => s.scene))) {
    const of = all.filter((s) => s.scene === scene && s.points.some((p) => metric.of(p)));
    if (of.length === 0) continue;
    const records = recordsOf(of);
    const lines = of.map((series) => ({
      label: name(series, of),
      color: color(series, of),
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
      show(of[near[0][1]], records[plot.cursor.idx]);
    };
    chart(byId("speeds"), `${scene}: ${metric.label}`, records.map(commit), lines, { click });
    numbers(byId("speeds").lastChild, of, records, metric);
  }
}

// A table of the same numbers, with a button that does the same as a click on a point.
function numbers(box, all, records, metric) {
  const details = element(box, "details");
  element(details, "summary", "as a table");
  const table = element(details, "table");
  for (const record of records) {
    for (const series of all) {
      const point = series.points.find((point) => point.record === record);
      const value = point && metric.of(point);
      if (!value) continue;
      const row = element(table, "tr");
      [commit(record), name(series, all), `${shortened(value.median)} (${shortened(value.lo)} to ${shortened(value.hi)})`]
        .forEach((text) => element(row, "td", text));
      const button = element(element(row, "td"), "button", "how to repeat", { type: "button" });
      button.addEventListener("click", () => show(series, record));
    }
  }
}

function show(series, record) {
  const point = series.points.find((point) => point.record === record);
  if (!point) return;
  const { file, time, commit, rustc, flags, os } = DATA.records[record];
  const section = byId("point");
  section.replaceChildren();
  section.hidden = false;
  element(section, "h3", `${series.scene}, ${name(series, [series])}, commit ${commit}`);
  const { median, lo, hi } = point.mrays;
  element(section, "div", `${median.toFixed(2)} Mrays/s (${lo.toFixed(2)} to ${hi.toFixed(2)}), ${point.blocks} blocks, ${point.contaminated} contaminated; ${series.settings}`);
  element(section, "div", `${time}, ${rustc}, ${flags}, ${os}, ${file}`);
  element(section, "pre", point.bench);
  element(section, "pre", point.render);
  section.scrollIntoView({ block: "nearest" });
}

// The newest figures of each series.
function latest(all) {
  const table = byId("latest");
  const head = element(table, "tr");
  ["scene", "engine, threads", "commit", "Mrays/s", "Msamples/s", "speed relative to scalar"].forEach((text) => element(head, "th", text));
  const text = (e) => (e ? `${shortened(e.median)} (${shortened(e.lo)} to ${shortened(e.hi)})` : "");
  for (const series of all) {
    const point = series.points.at(-1);
    const row = element(table, "tr");
    [series.scene, name(series, [series]), commit(point.record), text(point.mrays), text(point.msamples), text(point.speedup)]
      .forEach((cell) => element(row, "td", cell));
  }
}

function changes(all) {
  const table = byId("changes");
  const head = element(table, "tr");
  ["commit", "time", "scene", "engine", "threads", "speed ratio", ""].forEach((text) => element(head, "th", text));
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

// Exact counts that differ from those of the record before.
function countChanges(all) {
  const table = byId("countchanges");
  const head = element(table, "tr");
  ["commit", "scene", "engine", "threads", "count ratio"].forEach((text) => element(head, "th", text));
  for (const series of all) {
    const counted = series.points.filter((p) => p.counters.lanes_issued > 0);
    counted.slice(1).forEach((point, i) => {
      const before = counted[i].counters;
      const other = COUNTERS.filter((counter) => point.counters[counter] !== before[counter]);
      if (other.length === 0) return;
      const ratio = (counter) => `${counter.replace("_", " ")} ${(point.counters[counter] / before[counter]).toFixed(4)}`;
      const row = element(table, "tr");
      [commit(point.record), series.scene, series.engine, series.threads, other.map(ratio).join(", ")]
        .forEach((text) => element(row, "td", text));
    });
  }
  if (table.rows.length === 1) element(element(table, "tr"), "td", "none", { colspan: 5 });
}

function stages(all) {
  const timed = (p) => Object.values(p.stages).some((seconds) => seconds > 0);
  for (const series of all.filter((s) => s.points.some(timed))) {
    const records = recordsOf([series]);
    const used = STAGES.filter((stage) => series.points.some((p) => p.stages[stage] > 0));
    const sum = (p) => used.reduce((all, stage) => all + (p.stages[stage] || 0), 0);
    // The lines are drawn from the top of the stack down, each over the lower part of the one before.
    const lines = used.map((_, i) => ({
      label: used[i],
      color: COLORS[i % COLORS.length],
      fill: COLORS[i % COLORS.length],
      shown: column(series, records, (p) => (sum(p) > 0 ? (100 * (p.stages[used[i]] || 0)) / sum(p) : null)),
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

// The counters of series in which any of them changed.
function counters(all) {
  for (const series of all) {
    const counted = series.points.filter((p) => p.counters.lanes_issued > 0);
    const changed = (counter) => counted.some((p) => p.counters[counter] !== counted[0].counters[counter]);
    if (!COUNTERS.some(changed)) continue;
    const records = recordsOf([series]);
    const lines = COUNTERS.map((counter, i) => ({
      label: counter.replace("_", " "),
      color: COLORS[i],
      values: column(series, records, (p) => (p.counters.lanes_issued > 0 ? p.counters[counter] / p.rays : null)),
    }));
    const title = `${series.scene}, ${name(series, [series])}: per ray`;
    chart(byId("counters"), title, records.map(commit), lines, { y: { distr: 3 } });
  }
}

function draw() {
  plots.splice(0).forEach((plot) => plot.destroy());
  byId("point").hidden = true;
  for (const id of ["latest", "speeds", "changes", "stages", "lanes", "counters", "countchanges"]) byId(id).replaceChildren();
  const all = shown();
  latest(all);
  speeds(all);
  changes(all);
  stages(all);
  lanes(all);
  counters(all);
  countChanges(all);
  // The columns have their final width only after all charts are added.
  plots.forEach((plot) => plot.setSize({ width: plot.root.parentElement.clientWidth - 24, height: HEIGHT }));
}

options(byId("machine"), DATA.machines.map((label, i) => [i, label]));
options(byId("metric"), Object.entries(METRICS).map(([value, { label }]) => [value, label]));
boxes(byId("scenes"), "scene", unique(DATA.series.map((s) => s.scene)));
boxes(byId("engines"), "engine", unique(DATA.series.map((s) => s.engine)));
boxes(byId("threads"), "thread", unique(DATA.series.map((s) => String(s.threads))));
// The machine of the newest record is selected first.
byId("machine").value = DATA.series.reduce((best, s) => (s.points.at(-1).record >= best.record ? { record: s.points.at(-1).record, machine: s.machine } : best), { record: -1, machine: 0 }).machine;
draw();
let resizing;
addEventListener("resize", () => { clearTimeout(resizing); resizing = setTimeout(draw, 200); });
