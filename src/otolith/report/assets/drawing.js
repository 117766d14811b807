// A platform on legs on a 2D canvas: reports hold this text, and the Commander's page loads it as a module.
class Drawing {
  /**
   * `base` and `points` [m] are all that must fit; `ink` returns the value of a CSS variable; `zoom` fills the canvas.
   * `cranks` {zero, quarter, radius, rod, push} are on the base's points; null for legs that extend.
   */
  constructor(canvas, base, points, ink, zoom, cranks = null) {
    Object.assign(this, { canvas, pen: canvas.getContext("2d"), base, ink, zoom, cranks, turn: -0.9, tilt: 0.3 });
    const heights = [...base, ...points].map((point) => point[2]), mean = (k) => base.reduce((sum, p) => sum + p[k], 0) / base.length;
    this.middle = [mean(0), mean(1), (Math.min(...heights) + Math.max(...heights)) / 2];
    this.size = Math.max(...base.map((p) => Math.hypot(p[0] - this.middle[0], p[1] - this.middle[1])));
  }

  /** Turn the view by angles [rad]. */
  look(turn, tilt) {
    this.turn += turn;
    this.tilt = Math.min(1.5, Math.max(-0.2, this.tilt + tilt));
  }

  /** World to canvas: x right, y down on the picture, depth away from the eye. */
  seen(point) {
    const [x, y, z] = point.map((value, k) => value - this.middle[k]);
    const c = Math.cos(this.turn), s = Math.sin(this.turn);
    const right = -s * x + c * y, near = c * x + s * y;
    const up = Math.cos(this.tilt) * z - Math.sin(this.tilt) * near;
    const depth = 6.5 * this.size - Math.cos(this.tilt) * near - Math.sin(this.tilt) * z;
    const zoom = this.zoom * this.canvas.height / depth;
    return [this.canvas.width / 2 + zoom * right, this.canvas.height / 2 - zoom * up, depth];
  }

  line(points, colour, width, fill) {
    const pen = this.pen;
    pen.beginPath();
    points.map((point) => this.seen(point)).forEach(([x, y], k) => (k ? pen.lineTo(x, y) : pen.moveTo(x, y)));
    if (fill) { pen.closePath(); pen.fillStyle = fill; pen.fill(); }
    pen.strokeStyle = colour; pen.lineWidth = width; pen.lineCap = "round"; pen.stroke();
  }

  /** Begin a picture: the floor. */
  begin() {
    this.pen.clearRect(0, 0, this.canvas.width, this.canvas.height);
    const floor = Math.min(...this.base.map((point) => point[2]));
    for (let g = -2; g <= 2; g += 1) {
      const at = (a, b) => [this.middle[0] + a * this.size, this.middle[1] + b * this.size, floor];
      this.line([at(g, -2), at(g, 2)], this.ink("--line"), 1);
      this.line([at(-2, g), at(2, g)], this.ink("--line"), 1);
    }
  }

  /** Return what a leg's drive shows for a joint [m] in world, length [m] or crank angle [deg], and the knee to draw. */
  leg(k, joint) {
    const foot = this.base[k], way = foot.map((value, i) => joint[i] - value);
    if (!this.cranks) return [Math.hypot(...way), foot.map((value, i) => value + 0.5 * way[i])];
    const {zero, quarter, radius, rod, push} = this.cranks, dot = (a, b) => a.reduce((sum, value, i) => sum + value * b[i], 0);
    const along = dot(way, zero[k]), across = dot(way, quarter[k]);
    const share = (dot(way, way) + radius ** 2 - rod ** 2) / (2 * radius * Math.hypot(along, across));
    let angle = Math.atan2(across, along) - push * Math.acos(share);  // NaN where the rod does not reach
    angle -= 2 * Math.PI * Math.round(angle / (2 * Math.PI));
    const tip = foot.map((value, i) => value + radius * (Math.cos(angle) * zero[k][i] + Math.sin(angle) * quarter[k][i]));
    return [angle * 180 / Math.PI, tip];
  }

  /** Draw base and legs to joints [m] in world, the farthest first; `colour` is a function of what a drive shows. */
  legs(joints, colour) {
    this.line([...this.base, this.base[0]], this.ink("--soft"), 3, "rgba(128,128,128,0.18)");
    const legs = this.base.map((foot, k) => [foot, joints[k], ...this.leg(k, joints[k])]);
    legs.sort((one, two) => this.seen(two[0])[2] - this.seen(one[0])[2]);
    for (const [foot, joint, value, knee] of legs) {
      this.line([foot, knee], this.ink("--soft"), 9);
      this.line([knee, joint], colour(value), 5);
    }
  }
}
