// How large the error of the felt force is while the run goes on.
import {element, shown} from "/web/look.js";

const AXES = {x: "forward", y: "sideways", z: "vertical"};

/** Root mean squares over all samples that came: in an envelope the middle of each pair stands for its samples. */
export class SoFar {
  constructor(table) {
    this.table = table;
    this.describe([]);
  }

  describe(columns) {
    const at = (name) => columns.findIndex((column) => column.name === name);
    this.errors = ["felt", "felt2"].flatMap((kind) => Object.keys(AXES).map((axis) => ({
      title: `${AXES[axis]}${kind === "felt2" ? ", B" : ""}`, wanted: at(`wanted_${axis}`), felt: at(`${kind}_${axis}`), sum: 0, number: 0,
    }))).filter(({wanted, felt}) => wanted >= 0 && felt >= 0);
    this.table.hidden = true;
  }

  take(signals, paired) {
    const step = paired ? 2 : 1;
    for (const error of this.errors) {
      const wanted = signals[error.wanted], felt = signals[error.felt];
      if (!wanted || !felt) continue;
      for (let k = 0; k + step <= wanted.length; k += step) {
        const difference = 0.5 * (wanted[k] - felt[k] + wanted[k + step - 1] - felt[k + step - 1]);
        if (Number.isNaN(difference)) continue;
        error.sum += difference * difference;
        error.number += 1;
      }
    }
  }

  draw() {
    const moving = this.errors.filter(({sum}) => sum > 0);
    this.table.hidden = !moving.length;
    if (this.rows?.length !== moving.length) {
      this.rows = moving.map(() => element("td"));
      this.table.tBodies[0].replaceChildren(...moving.map(({title}, k) => element("tr", {}, element("th", {scope: "row"}, title), this.rows[k])));
    }
    moving.forEach(({sum, number}, k) => { this.rows[k].textContent = `${shown(Math.sqrt(sum / number))} m/s²`; });
  }
}
