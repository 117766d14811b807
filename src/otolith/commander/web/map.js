// The lap from above, and where the car is.
import {css} from "/web/look.js";

export class LapMap {
  constructor(canvas) {
    this.canvas = canvas;
    this.path = null;
  }

  /** Take a path {x, y, time} in m and s, or null: then there is no map. */
  describe(path) {
    this.path = path?.x?.length ? path : null;
    this.canvas.hidden = !this.path;
    if (!this.path) return;
    const {x, y} = this.path, {width, height} = this.canvas, room = 24;
    const [west, east, south, north] = [Math.min(...x), Math.max(...x), Math.min(...y), Math.max(...y)];
    const scale = Math.min((width - 2 * room) / Math.max(east - west, 1), (height - 2 * room) / Math.max(north - south, 1));
    this.seen = (px, py) => [width / 2 + scale * (px - (west + east) / 2), height / 2 - scale * (py - (south + north) / 2)];
    this.draw(0);
  }

  /** Return where the car was [m]: between two points of the path in proportion to the time, at an end beyond it. */
  placeAt(time) {
    const {x, y, time: times} = this.path, after = times.findIndex((value) => value >= time);
    if (after <= 0) return after ? [x.at(-1), y.at(-1)] : [x[0], y[0]];
    const share = (time - times[after - 1]) / (times[after] - times[after - 1]);
    return [x, y].map((of) => of[after - 1] + share * (of[after] - of[after - 1]));
  }

  /** Draw the car where it was at a time [s] of the run. */
  draw(time) {
    if (!this.path) return;
    const {x, y, time: times} = this.path, pen = this.canvas.getContext("2d");
    pen.clearRect(0, 0, this.canvas.width, this.canvas.height);
    pen.beginPath();
    x.forEach((px, k) => pen.lineTo(...this.seen(px, y[k])));
    pen.strokeStyle = css("--soft");
    pen.lineWidth = 5;
    pen.lineJoin = "round";
    pen.stroke();
    if (!times || !Number.isFinite(time)) return;
    pen.beginPath();
    pen.arc(...this.seen(...this.placeAt(time)), 10, 0, 7);
    pen.fillStyle = css("--s1");
    pen.fill();
  }
}
