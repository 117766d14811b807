// Draws a six-legged platform in motion on the canvas of the figure that this script stands in.
(() => {
  const figure = document.currentScript.parentElement;
  const data = JSON.parse(figure.querySelector('script[type="application/json"]').textContent);
  const canvas = figure.querySelector("canvas"), pen = canvas.getContext("2d");
  const button = figure.querySelector("button"), slider = figure.querySelector("input");
  const output = figure.querySelector("output");
  const last = data.time.length - 1;
  slider.max = last;
  const view = { turn: -0.9, tilt: 0.3 };
  const ink = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim() || "#888";

  // Centre and size of everything that is ever shown.
  const heights = data.anchors.concat(data.joints, [data.head]).map((p) => p[2]);
  const middle = [0, 1].map((k) => data.anchors.reduce((sum, p) => sum + p[k], 0) / 6);
  middle.push((Math.min(...heights) + Math.max(...heights)) / 2);
  const size = Math.max(...data.anchors.map((p) => Math.hypot(p[0] - middle[0], p[1] - middle[1])));

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

  // World to canvas: x right, y up on the picture, depth away from the eye.
  function seen(p) {
    const [x, y, z] = p.map((value, k) => value - middle[k]);
    const c = Math.cos(view.turn), s = Math.sin(view.turn);
    const right = -s * x + c * y, near = c * x + s * y;
    const up = Math.cos(view.tilt) * z - Math.sin(view.tilt) * near;
    const depth = 6.5 * size - Math.cos(view.tilt) * near - Math.sin(view.tilt) * z;
    const zoom = 1.75 * canvas.height / depth;
    return [canvas.width / 2 + zoom * right, canvas.height / 2 - zoom * up, depth];
  }

  function line(points, colour, width, fill) {
    pen.beginPath();
    points.map(seen).forEach(([x, y], k) => (k ? pen.lineTo(x, y) : pen.moveTo(x, y)));
    if (fill) { pen.closePath(); pen.fillStyle = fill; pen.fill(); }
    pen.strokeStyle = colour; pen.lineWidth = width; pen.lineCap = "round"; pen.stroke();
  }

  function colour(length) {
    const [low, high] = data.stroke;
    const share = Math.min(1, Math.max(0, (length - low) / (high - low)));
    return `hsl(${210 - 195 * share}, 85%, 45%)`;
  }

  function draw() {
    const k = Number(slider.value), place = data.places[k];
    const joints = data.joints.map((joint) => placed(place, joint));
    pen.clearRect(0, 0, canvas.width, canvas.height);
    const floor = Math.min(...data.anchors.map((p) => p[2]));
    for (let g = -2; g <= 2; g += 1) {
      const at = (a, b) => [middle[0] + a * size, middle[1] + b * size, floor];
      line([at(g, -2), at(g, 2)], ink("--line"), 1);
      line([at(-2, g), at(2, g)], ink("--line"), 1);
    }
    line([...data.anchors, data.anchors[0]], ink("--soft"), 3, "rgba(128,128,128,0.18)");
    const legs = data.anchors.map((a, i) => [a, joints[i]]);
    legs.sort((one, two) => seen(two[0])[2] - seen(one[0])[2]);
    for (const [a, b] of legs) {
      const length = Math.hypot(...a.map((value, i) => b[i] - value));
      const half = a.map((value, i) => value + 0.5 * (b[i] - value));
      line([a, half], ink("--soft"), 9);
      line([half, b], colour(length), 5);
    }
    line([...joints, joints[0]], "#0072b2", 3, "rgba(0,114,178,0.35)");
    const centre = data.joints.reduce((sum, p) => sum.map((v, i) => v + p[i] / 6), [0, 0, 0]);
    const nose = [centre[0] + 0.8 * size, centre[1], centre[2]];
    line([placed(place, centre), placed(place, nose)], "#0072b2", 3);
    const [x, y] = seen(placed(place, data.head));
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
    view.turn += event.movementX / 200;
    view.tilt = Math.min(1.5, Math.max(-0.2, view.tilt + event.movementY / 200));
    draw();
  });
  draw();
})();
