// The platform on a 2D canvas. Dragging or the arrow keys turn the view.
import {Drawing} from "/web/drawing.js";
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
    this.drawing.look(turn, tilt);
    this.draw();
  }

  /** Take the geometry of six legs {base, platform, stroke, cranks} in m, or null: then only a plate is drawn. */
  describe(legs) {
    this.known = legs;
    this.base = legs?.base ?? PLATE.map(([x, y]) => [1.5 * x, 1.5 * y, -1]);
    this.plate = legs?.platform ?? PLATE;
    const {turn, tilt} = this.drawing ?? {};
    this.drawing = new Drawing(this.canvas, this.base, this.plate, css, 2.6, legs?.cranks ?? null);
    if (turn !== undefined) Object.assign(this.drawing, {turn, tilt});
    this.draw();
  }

  /** Return the length [m], or crank angle [deg], of every leg at a pose; none where no legs are known. */
  lengths() {
    if (!this.known) return [];
    return this.base.map((_, k) => this.drawing.leg(k, placed(this.pose, this.plate[k]))[0]);
  }

  draw(pose = this.pose) {
    this.pose = pose;
    const {drawing, plate} = this, joints = plate.map((point) => placed(pose, point));
    drawing.begin();
    if (this.known) {
      const [low, high] = this.known.stroke;
      drawing.legs(joints, (value) => css(colour((value - low) / (high - low))));
    }
    drawing.line([...joints, joints[0]], css("--s0"), 4, css("--plate"));
    const centre = plate.reduce((sum, p) => sum.map((v, i) => v + p[i] / plate.length), [0, 0, 0]);
    const reach = Math.hypot(plate[0][0] - centre[0], plate[0][1] - centre[1]);
    const ahead = (share) => placed(pose, [centre[0] + share * reach, centre[1], centre[2]]);
    drawing.line([placed(pose, centre), ahead(1.2)], css("--s0"), 4);
    this.label(ahead(1.4), "front");
    if (this.known) this.base.forEach((foot, k) => this.label(foot.map((value, i) => value + 0.3 * (joints[k][i] - value)), String(k + 1)));
  }

  label(point, text) {
    const [x, y] = this.drawing.seen(point), {pen} = this.drawing;
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
