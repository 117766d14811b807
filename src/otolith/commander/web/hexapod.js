// The platform on a 2D canvas. Dragging or the arrow keys turn the view.
import {css} from "/web/look.js";

const RADIANS = Math.PI / 180;
const PLATE = [[0.6, 0.4], [0.6, -0.4], [-0.6, -0.4], [-0.6, 0.4]].map(([x, y]) => [x, y, 0]);  // where no legs are known

/** Return the point of the world [m] of a point of the platform; pose in m and degrees, intrinsic z-y-x. */
export function placed(pose, [x, y, z]) {
  const [roll, pitch, yaw] = pose.slice(3).map((angle) => angle * RADIANS);
  [y, z] = [Math.cos(roll) * y - Math.sin(roll) * z, Math.sin(roll) * y + Math.cos(roll) * z];
  [x, z] = [Math.cos(pitch) * x + Math.sin(pitch) * z, Math.cos(pitch) * z - Math.sin(pitch) * x];
  [x, y] = [Math.cos(yaw) * x - Math.sin(yaw) * y, Math.sin(yaw) * x + Math.cos(yaw) * y];
  return [pose[0] + x, pose[1] + y, pose[2] + z];
}

export class HexapodView {
  constructor(canvas) {
    this.canvas = canvas;
    this.pen = canvas.getContext("2d");
    this.turn = -0.9;
    this.tilt = 0.3;
    this.pose = [0, 0, 0, 0, 0, 0];
    this.describe(null);
    canvas.addEventListener("pointermove", (event) => {
      if (event.buttons) this.look(event.movementX / 200, event.movementY / 200);
    });
    const keys = {ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1]};
    canvas.addEventListener("keydown", (event) => {
      if (!(event.key in keys)) return;
      event.preventDefault();
      this.look(...keys[event.key]);
    });
  }

  look(turn, tilt) {
    this.turn += turn;
    this.tilt = Math.min(1.5, Math.max(-0.2, this.tilt + tilt));
    this.draw();
  }

  /** Take the geometry of six legs {base, platform, stroke} in m, or null: then only a plate is drawn. */
  describe(legs) {
    this.legs = legs;
    this.base = legs?.base ?? PLATE.map(([x, y]) => [1.5 * x, 1.5 * y, -1]);
    this.plate = legs?.platform ?? PLATE;
    const heights = [...this.base, ...this.plate].map((point) => point[2]);
    this.middle = [0, 1].map((k) => this.base.reduce((sum, point) => sum + point[k], 0) / this.base.length);
    this.middle.push((Math.min(...heights) + Math.max(...heights)) / 2 + 0.1);
    this.size = Math.max(...this.base.map((point) => Math.hypot(point[0] - this.middle[0], point[1] - this.middle[1])));
    this.draw();
  }

  /** Return canvas coordinates and depth of a point of the world: x right, y down. */
  seen(point) {
    const [x, y, z] = point.map((value, k) => value - this.middle[k]);
    const c = Math.cos(this.turn), s = Math.sin(this.turn);
    const right = -s * x + c * y, near = c * x + s * y;
    const up = Math.cos(this.tilt) * z - Math.sin(this.tilt) * near;
    const depth = 6.5 * this.size - Math.cos(this.tilt) * near - Math.sin(this.tilt) * z;
    const zoom = 2.75 * this.canvas.height / depth;
    return [this.canvas.width / 2 + zoom * right, this.canvas.height / 2 - zoom * up, depth];
  }

  line(points, colour, width, fill) {
    const pen = this.pen;
    pen.beginPath();
    points.map((point) => this.seen(point)).forEach(([x, y], k) => (k ? pen.lineTo(x, y) : pen.moveTo(x, y)));
    if (fill) { pen.closePath(); pen.fillStyle = fill; pen.fill(); }
    pen.strokeStyle = colour;
    pen.lineWidth = width;
    pen.lineCap = "round";
    pen.stroke();
  }

  /** Return the length [m] of every leg at a pose; none where no legs are known. */
  lengths() {
    if (!this.legs) return [];
    return this.base.map((foot, k) => Math.hypot(...placed(this.pose, this.plate[k]).map((value, i) => value - foot[i])));
  }

  draw(pose = this.pose) {
    this.pose = pose;
    const {pen, canvas, base, middle, size} = this;
    pen.clearRect(0, 0, canvas.width, canvas.height);
    const floor = Math.min(...base.map((point) => point[2]));
    for (let g = -2; g <= 2; g += 1) {
      const at = (a, b) => [middle[0] + 0.75 * a * size, middle[1] + 0.75 * b * size, floor];
      this.line([at(g, -2), at(g, 2)], css("--line"), 1);
      this.line([at(-2, g), at(2, g)], css("--line"), 1);
    }
    const joints = this.plate.map((point) => placed(pose, point));
    if (this.legs) this.struts(joints);
    this.line([...joints, joints[0]], css("--s0"), 4, css("--plate"));
    const n = this.plate.length, centre = this.plate.reduce((sum, p) => sum.map((v, i) => v + p[i] / n), [0, 0, 0]);
    const reach = Math.hypot(this.plate[0][0] - centre[0], this.plate[0][1] - centre[1]);
    this.line([placed(pose, centre), placed(pose, [centre[0] + 1.2 * reach, centre[1], centre[2]])], css("--s0"), 4);
    this.label(placed(pose, [centre[0] + 1.4 * reach, centre[1], centre[2]]), "front");
  }

  struts(joints) {
    this.line([...this.base, this.base[0]], css("--soft"), 3, css("--floor"));
    const [low, high] = this.legs.stroke;
    const order = this.base.map((_, k) => k).sort((one, two) => this.seen(this.base[two])[2] - this.seen(this.base[one])[2]);
    const lengths = this.lengths();
    for (const k of order) {
      const half = this.base[k].map((value, i) => value + 0.5 * (joints[k][i] - value));
      this.line([this.base[k], half], css("--soft"), 9);
      this.line([half, joints[k]], css(colour((lengths[k] - low) / (high - low))), 6);
    }
    order.forEach((k) => this.label(this.base[k].map((value, i) => value + 0.3 * (joints[k][i] - value)), String(k + 1)));
  }

  label(point, text) {
    const [x, y] = this.seen(point), {pen} = this;
    pen.font = "bold 22px system-ui, sans-serif";
    pen.textAlign = "center";
    pen.lineWidth = 5;
    pen.strokeStyle = css("--paper");
    pen.strokeText(text, x, y + 8);
    pen.fillStyle = css("--ink");
    pen.fillText(text, x, y + 8);
  }
}

/** Return the name of the colour of a leg that uses a share of its stroke: the ends are the danger. */
export function colour(share) {
  const use = Math.abs(2 * share - 1);
  return use > 0.9 ? "--fault" : use > 0.7 ? "--warn" : "--good";
}
