// One plot: its head with the values, and the curves with limits, changes and false cues beneath.
import uPlot from "/web/uplot.esm.js";
import {css, element, shown} from "/web/look.js";
import {segments, shade} from "/web/paths.js";

/** Return colour, width and dash of a signal: wanted is a broad grey line, B is dashed. */
function pen(name, k) {
  if (name.startsWith("wanted")) return {colour: "--wanted", width: 3};
  if (name.startsWith("felt2")) return {colour: "--s1", width: 1.6, dash: [6, 4]};
  if (name.startsWith("felt")) return {colour: "--s0", width: 1.6};
  return {colour: `--s${k % 6}`, width: 1.5};
}

/** Return the limits of a column, or where it is felt, as [low, high]; null if it has none. */
const boundsOf = ({limits, threshold}) => limits ?? (threshold ? [-threshold, threshold] : null);

/** Return the name of a column within its plot: the axis of a force stands in the title. */
const wordOf = ({label, name}) => (/^(wanted|felt)/.test(name) ? label.replace(/,? ?[xyz]$/, "").replace(", ", " ") : label);

const span = ([low, high]) => (low === -high ? `±${shown(high, 2)}` : `${shown(low, 2)} to ${shown(high, 2)}`);

/** One panel of signals {title, unit, columns}, each column with its index in the history. */
export class Panel {
  constructor(plots, panel) {
    this.plots = plots;
    this.panel = panel;
    this.lines = [];  // limits that are drawn
    this.values = panel.columns.map(() => element("output"));
    const legend = panel.columns.map((column, k) => {
      const swatch = element("i", {className: pen(column.name, k).dash ? "swatch dashed" : "swatch"});
      swatch.style.color = `var(${pen(column.name, k).colour})`;
      return element("span", {}, swatch, `${wordOf(column)} `, this.values[k]);
    });
    this.limits = element("small");
    const close = element("button", {type: "button", title: "Remove this plot", "aria-label": `Remove ${panel.title}`}, "×");
    close.addEventListener("click", () => plots.remove(panel.title));
    this.box = element("div");
    this.root = element("article", {className: "panel"}, element("header", {}, element("h3", {}, panel.unit ? `${panel.title} [${panel.unit}]` : panel.title), element("span", {className: "legend"}, ...legend), this.limits, close), this.box);
    plots.root.append(this.root);
    this.chart = new uPlot(this.options(), [[], ...panel.columns.map(() => [])], this.box);
  }

  options() {
    const axis = (more) => ({
      stroke: () => css("--soft"), font: "12px system-ui, sans-serif", ticks: {show: false},
      grid: {stroke: () => css("--line"), width: 1}, ...more,
    });
    return {
      width: 300, height: 100, legend: {show: false}, padding: [6, 12, 0, 0],
      scales: {x: {time: false, range: () => this.plots.range()}, y: {range: () => this.reach()}},
      series: [{}, ...this.panel.columns.map((column, k) => {
        const {colour, width, dash} = pen(column.name, k);
        return {stroke: () => css(colour), width, dash, auto: false, points: {show: false}, paths: segments};
      })],
      axes: [axis({size: 22, gap: 2}), axis({size: 54, gap: 4, space: 20, values: (_, ticks) => ticks.map((value) => String(+value.toPrecision(6)).replace("-", "−"))})],
      cursor: {
        sync: {key: "time"}, drag: {x: true, y: false, setScale: false}, points: {size: 6},
        bind: {dblclick: () => () => this.plots.follow()},
      },
      hooks: {
        drawAxes: [(chart) => this.under(chart)],
        setCursor: [(chart) => { if (chart.cursor.event) this.plots.point(chart.cursor.left < 0 ? null : chart.posToVal(chart.cursor.left, "x")); }],
        setSelect: [(chart) => {
          if (chart.select.width > 4) {
            this.plots.zoom(...[0, chart.select.width].map((more) => chart.posToVal(chart.select.left + more, "x")));
          }
          chart.setSelect({left: 0, width: 0, top: 0, height: 0}, false);
        }],
      },
    };
  }

  /** Return the range of the y axis: what is in sight, and those limits that it comes near. */
  reach() {
    let [low, high] = [Infinity, -Infinity];
    const said = [];
    this.lines = [];
    this.panel.columns.forEach((column, k) => {
      const [least, most] = this.plots.extremes(column.index), bounds = boundsOf(column);
      low = Math.min(low, least);
      high = Math.max(high, most);
      if (!bounds || !(least < most)) return;
      const near = most > 0.4 * bounds[1] || least < 0.4 * bounds[0];
      if (near) this.lines.push({values: bounds, colour: pen(column.name, k).colour});
      said.push(`${this.panel.columns.length > 1 ? `${column.label} ` : ""}${span(bounds)}${near ? "" : " (far)"}`);
    });
    for (const {values} of this.lines) [low, high] = [Math.min(low, values[0]), Math.max(high, values[1])];
    if (low > high) [low, high] = [-1, 1];
    this.name(said);
    const room = 0.08 * (high - low) || 0.5;
    return [low - room, high + room];
  }

  name(said) {
    const kind = this.panel.columns[0].threshold ? "threshold" : "limits", parts = said.length ? [`${kind} ${[...new Set(said)].join(", ")}`] : [];
    if (this.plots.spansOf(this.panel).length) parts.push("shaded: false cues");
    const text = parts.join("; ");
    if (this.limits.title === text) return;
    this.limits.title = this.limits.textContent = text;
  }

  /** Draw what lies under the curves: false cues, limits, changes of parameters, the time that is held. */
  under(chart) {
    shade(chart, this.plots.spansOf(this.panel), css("--shade"));
    for (const {values, colour} of this.lines) shade(chart, values.map((value) => ({value})), css(colour), [8, 5]);
    shade(chart, this.plots.marks, css("--warn"), [3, 3]);
    if (this.plots.held !== null) shade(chart, [{at: this.plots.held}], css("--ink"), []);
  }

  show(history) {
    this.chart.setData([history.view(0), ...this.panel.columns.map(({index}) => history.view(index))], false);
    const [min, max] = this.plots.range();
    this.chart.setScale("x", {min, max});
  }

  write(history, row) {
    this.panel.columns.forEach(({index}, k) => { this.values[k].textContent = shown(history.value(index, row)); });
  }

  resize(height) { this.chart.setSize({width: this.box.clientWidth, height: height - 26}); }

  close() {
    this.chart.destroy();
    this.root.remove();
  }
}
