// How long decisions took and how much work they were, while the run goes on.
import {css, shown} from "/web/look.js";

const EDGES = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10000];  // [µs]

/** Counts of step times, made from the samples as they come. */
export class Effort {
  constructor(canvas, text) {
    Object.assign(this, {canvas, text});
    this.describe([]);
  }

  describe(columns) {
    this.at = Object.fromEntries(["step_us", "changes", "residual"].map((name) => [name, columns.findIndex((column) => column.name === name)]));
    Object.assign(this, {counts: EDGES.map(() => 0), number: 0, slowest: 0, changes: 0, residual: 0});
  }

  take(signals) {
    if (!signals[this.at.step_us]) return;
    const steps = signals[this.at.step_us], changes = signals[this.at.changes], residual = signals[this.at.residual];
    for (let k = 0; k < steps.length; k += 1) {
      if (Number.isNaN(steps[k])) continue;
      const above = EDGES.findIndex((edge) => steps[k] < edge);
      this.counts[above < 0 ? EDGES.length - 1 : Math.max(0, above - 1)] += 1;
      this.number += 1;
      this.slowest = Math.max(this.slowest, steps[k]);
      if (changes?.[k] > 0) this.changes = Math.max(this.changes, changes[k]);
      if (residual?.[k] > 0) this.residual = Math.max(this.residual, residual[k]);
    }
  }

  draw() {
    const {canvas} = this, pen = canvas.getContext("2d"), {width, height} = canvas, wide = width / EDGES.length;
    const largest = Math.max(1, ...this.counts);
    pen.clearRect(0, 0, width, height);
    pen.font = "20px system-ui, sans-serif";
    pen.textAlign = "left";
    this.counts.forEach((count, k) => {
      const tall = (height - 34) * Math.sqrt(count / largest);
      pen.fillStyle = css("--s0");
      pen.fillRect(k * wide + 2, height - 28 - tall, wide - 4, tall);
      pen.fillStyle = css("--soft");
      if (k % 3 === 0) pen.fillText(EDGES[k] >= 1000 ? `${EDGES[k] / 1000} ms` : `${EDGES[k]} µs`, k * wide + 2, height - 6);
    });
    this.text.textContent = this.number
      ? `slowest step ${shown(this.slowest, 1)} µs, most changes ${shown(this.changes, 0)}, largest residual ${this.residual.toExponential(1)}; height of a bar: root of the share`
      : "no step yet";
  }
}
