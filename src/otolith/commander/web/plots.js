// All plots: which there are, which are open, and what time they show.
import {onLook} from "/web/look.js";
import {Panel} from "/web/panel.js";

const HEIGHT = 118;  // [px] least height of a panel
const ALONG = {surge: "x", sway: "y", heave: "z"};
const ORDER = ["Force forward", "Force sideways", "Tilt rate", "Position", "Angle", "Vertical force"];

/** Return the panels that a schema's columns make: those of one group and unit share one. */
export function panelsOf(columns) {
  const found = new Map();
  columns.forEach((column, k) => {
    if (column.name === "time") return;
    const title = column.group;
    if (!found.has(title)) found.set(title, {title, unit: column.unit, columns: []});
    found.get(title).columns.push({...column, index: k});
  });
  return [...found.values()];
}

export class Plots extends EventTarget {
  constructor(root) {
    super();
    this.root = root;
    this.open = new Map();
    this.marks = [];  // {at} [s] of changed parameters
    this.spans = [];  // {start, end, axis} of false cues
    this.span = 20;
    this.held = null;  // the time [s] that is replayed, or null
    this.all = [];
    this.touched = false;  // whether the user chose plots
    this.fixed = null;  // the range that the user chose, or null: follow
    new ResizeObserver(() => this.fit()).observe(root);
    onLook(() => this.redraw());
  }

  /** Take the columns of a schema; `dofs` is what is cued, such as surge-pitch,heave. */
  describe(columns, history, dofs) {
    const cued = dofs.split(/[-,]/), axes = cued.map((axis) => ALONG[axis] ?? axis);
    this.wanted = this.touched ? [...this.open.keys()] : null;
    this.clear();
    Object.assign(this, {every: panelsOf(columns), all: [], history, axes, marks: [], spans: [], fixed: null});
    if (history.length) this.begin();
    this.changed();
  }

  /** Open the plots that the user chose, or else those that matter most, of the signals that are cued or move. */
  begin() {
    const {awake, seen} = this.history, known = ({index}) => seen[index];
    const moves = ({index, axis}) => awake[index] || (this.axes.includes(axis) && known({index}));
    this.all = this.every.filter(({columns}) => columns.some(moves)).map((panel) => ({
      ...panel, columns: panel.columns.filter((column) => moves(column) || (column.name.startsWith("felt_") && known(column))),
    }));
    const cued = ({columns}) => columns.some(({axis}) => this.axes.includes(axis));
    const best = ORDER.flatMap((title) => this.all.filter((panel) => panel.title === title && cued(panel))).slice(0, 4);
    const titles = this.touched ? this.wanted ?? [...this.open.keys()] : best.map(({title}) => title);
    this.wanted = null;
    this.clear();
    for (const title of titles) if (this.all.some((panel) => panel.title === title)) this.put(title);
    this.changed();
  }

  put(title) { this.open.set(title, new Panel(this, this.all.find((panel) => panel.title === title))); }

  clear() {
    for (const panel of this.open.values()) panel.close();
    this.open.clear();
  }

  add(title) {
    this.touched = true;
    this.put(title);
    this.changed();
    this.open.get(title).root.scrollIntoView({block: "nearest"});
  }

  remove(title) {
    this.touched = true;
    this.open.get(title).close();
    this.open.delete(title);
    this.changed();
  }

  /** Return the columns of all open plots. */
  get plotted() { return [...this.open.values()].flatMap(({panel}) => panel.columns); }

  changed() {
    this.fit();
    this.dispatchEvent(new Event("changed"));
  }

  /** Share the height among the panels; where it is too little, the list scrolls. */
  fit() {
    const height = Math.max(HEIGHT, Math.floor(this.root.clientHeight / Math.max(1, this.open.size)) - 8);
    for (const panel of this.open.values()) panel.resize(height);
  }

  range() {
    if (this.fixed) return this.fixed;
    const last = this.history?.last || 0;
    return [Math.max(0, last - this.span), Math.max(this.span, last)];
  }

  /** Return the least and the largest value in sight of a signal; NaN does not count. */
  extremes(index) {
    const {history} = this, [from, to] = this.range(), last = history.at(to), x = history.view(index);
    let [low, high] = [Infinity, -Infinity];
    for (let k = Math.max(0, history.at(from)); k <= last; k += 1) {
      if (x[k] < low) low = x[k];
      if (x[k] > high) high = x[k];
    }
    return [low, high];
  }

  follow() { this.fixed = null; this.dispatchEvent(new Event("moved")); }
  zoom(low, high) { this.fixed = [Math.max(0, low), high]; this.dispatchEvent(new Event("moved")); }
  point(time) { this.dispatchEvent(new CustomEvent("point", {detail: time})); }
  spansOf({columns}) { return this.spans.filter(({axis}) => columns.some((column) => column.axis === axis && column.name.startsWith("felt"))); }

  draw() { for (const panel of this.open.values()) panel.show(this.history); }
  redraw() { for (const panel of this.open.values()) panel.chart.redraw(); }
  write(row) { for (const panel of this.open.values()) panel.write(this.history, row); }
}
