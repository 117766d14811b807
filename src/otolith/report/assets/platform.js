// Draws a six-legged platform in motion on the canvas of the figure that this script stands in.
const figure = document.currentScript.parentElement;
const data = JSON.parse(figure.querySelector('script[type="application/json"]').textContent);
const canvas = figure.querySelector("canvas");
const button = figure.querySelector("button"), slider = figure.querySelector("input");
const output = figure.querySelector("output");
slider.max = data.time.length - 1;
const ink = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim() || "#888";
const drawing = new Drawing(canvas, data.anchors, [...data.joints, data.head], ink, 1.75, data.cranks);

// R q: the quaternion (w, x, y, z) turns v, then the place moves it.
function placed(place, v) {
  const [px, py, pz, w, x, y, z] = place;
  const tx = 2 * (y * v[2] - z * v[1]), ty = 2 * (z * v[0] - x * v[2]), tz = 2 * (x * v[1] - y * v[0]);
  return [
    px + v[0] + w * tx + y * tz - z * ty,
    py + v[1] + w * ty + z * tx - x * tz,
    pz + v[2] + w * tz + x * ty - y * tx,
  ];
}

// The base carries everything: it turns a point about the vertical, then moves it.
const reach = Math.max(0, ...data.bases.map(([x, y]) => Math.hypot(x, y)));
drawing.size += 0.5 * reach;
function carried(k, v) {
  if (!data.bases.length) return v;
  const [x, y, yaw] = data.bases[k], c = Math.cos(yaw), s = Math.sin(yaw);
  return [x + c * v[0] - s * v[1], y + s * v[0] + c * v[1], v[2]];
}

// The rails that the base moves along: the way it took on the floor, and a beam across it through the base.
function rails(k, floor) {
  const span = (axis) => [Math.min(...data.bases.map((b) => b[axis])), Math.max(...data.bases.map((b) => b[axis]))];
  const [x, y] = data.bases[k], [left, right] = span(0), [near, far] = span(1), margin = 0.5 * drawing.size;
  drawing.line([[left - margin, y, floor], [right + margin, y, floor]], ink("--soft"), 4);
  if (far > near) drawing.line([[x, near - margin, floor], [x, far + margin, floor]], ink("--soft"), 4);
}

function colour(value) {
  const [low, high] = data.stroke;
  const share = Math.min(1, Math.max(0, (value - low) / (high - low)));
  return `hsl(${210 - 195 * share}, 85%, 45%)`;
}

function draw() {
  const k = Number(slider.value), place = data.places[k], pen = drawing.pen;
  const at = (point) => carried(k, placed(place, point));
  const joints = data.joints.map(at);
  drawing.base = data.anchors.map((anchor) => carried(k, anchor));
  drawing.begin();
  if (data.bases.length) rails(k, Math.min(...data.anchors.map((anchor) => anchor[2])));
  drawing.legs(joints, colour);
  drawing.line([...joints, joints[0]], "#0072b2", 3, "rgba(0,114,178,0.35)");
  const centre = data.joints.reduce((sum, p) => sum.map((v, i) => v + p[i] / 6), [0, 0, 0]);
  const nose = [centre[0] + 0.8 * drawing.size, centre[1], centre[2]];
  drawing.line([at(centre), at(nose)], "#0072b2", 3);
  const [x, y] = drawing.seen(at(data.head));
  pen.beginPath(); pen.arc(x, y, 7, 0, 7); pen.fillStyle = "#e69f00"; pen.fill();
  output.textContent = `${data.time[k].toFixed(2)} s  ${data.captions[k] || ""}`;
}

let started = null;
function tick(now) {
  if (started === null) return;
  const t = (now - started) / 1000;
  let k = data.time.findIndex((value) => value - data.time[0] >= t);
  if (k < 0) { k = 0; started = now; }
  slider.value = k;
  draw();
  requestAnimationFrame(tick);
}
button.addEventListener("click", () => {
  const playing = started !== null;
  button.textContent = playing ? "Play" : "Pause";
  started = playing ? null : performance.now() - 1000 * (data.time[slider.value] - data.time[0]);
  if (!playing) requestAnimationFrame(tick);
});
slider.addEventListener("input", draw);
canvas.addEventListener("pointermove", (event) => {
  if (!event.buttons) return;
  drawing.look(event.movementX / 200, event.movementY / 200);
  draw();
});
draw();
