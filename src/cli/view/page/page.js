// The page: shows pictures and what is known about them.
const byId = (id) => document.getElementById(id);
const canvas = byId("picture");
const context = canvas.getContext("2d", { alpha: false });
const times = [];

function show(about, codes) {
  notice(about.error);
  if (about.width === 0) return;
  if (canvas.width !== about.width || canvas.height !== about.height) {
    Object.assign(canvas, { width: about.width, height: about.height });
  }
  const [outputWidth, outputHeight] = about.size;
  canvas.style.width = `${outputWidth}px`;
  canvas.style.aspectRatio = `${outputWidth} / ${outputHeight}`;
  context.putImageData(new ImageData(codes, about.width, about.height), 0, 0);
  const now = performance.now();
  times.push(now);
  while (times[0] < now - 1000) times.shift();
  byId("fps").textContent = times.length;
  byId("traced").textContent = `${Math.round(100 * about.traced)}% (${about.width} × ${about.height})`;
  byId("speed").textContent = (about.rays / about.seconds / 1e6).toFixed(1);
  byId("samples").textContent = about.samples === 0 ? "1 per frame" : about.samples;
  byId("hash").textContent = about.hash ?? "–";
  const values = { spp: about.spp, fov: about.fov, cone: about.lens[0], command: about.command };
  for (const [id, value] of Object.entries(values)) {
    if (document.activeElement !== byId(id)) byId(id).value = value;
  }
  const cameras = ["", ...about.cameras];
  if (byId("camera").options.length !== cameras.length) {
    byId("camera").replaceChildren(...cameras.map((name) => new Option(name || "of the scene", name)));
  }
  lens = about.lens;
  draw(about.path);
}

// Draws a path over the picture.
function draw(path) {
  const overlay = byId("overlay");
  const { offsetLeft, offsetTop, clientWidth, clientHeight } = canvas;
  const place = { left: offsetLeft, top: offsetTop, width: clientWidth, height: clientHeight };
  for (const [side, pixels] of Object.entries(place)) overlay.style[side] = `${pixels}px`;
  byId("path").hidden = !path;
  byId("path").textContent = path?.lines.join("\n") ?? "";
  overlay.replaceChildren(...(path?.rays ?? []).map(([isShadow, [x1, y1, x2, y2]]) => {
    const line = document.createElementNS("http://www.w3.org/2000/svg", "line");
    for (const [name, value] of Object.entries({ x1, y1, x2, y2 })) line.setAttribute(name, value);
    line.classList.toggle("shadow", isShadow);
    return line;
  }));
}

function notice(text) {
  byId("notice").hidden = !text;
  byId("notice").textContent = text ?? "";
}

let lens = [0, 1];
const connection = new Connection(show, (isOpen) => notice(isOpen ? null : "ptfast has ended, or cannot be reached."));
new Controls(canvas, connection);
const inputs = {
  camera: (value) => value,
  fov: Number,
  exposure: Number,
  tonemap: (value) => value,
  spp: Number,
  rate: Number,
  layer: (value) => value,
};
for (const [id, read] of Object.entries(inputs)) {
  byId(id).addEventListener(id === "spp" ? "change" : "input", () => connection.ask(id, read(byId(id).value)));
}
byId("cone").addEventListener("input", () => {
  connection.ask("lens", { angle: Number(byId("cone").value), distance: lens[1] });
});
canvas.focus();
