// What a run gave: measures, where the driver was misled, files, and the command that repeats it.
import {get, Refused} from "/web/api.js";
import {Effort} from "/web/effort.js";
import {element, shown} from "/web/look.js";

const worst = (record) => (record && typeof record === "object" ? Math.max(...Object.values(record)) : record);
const MEASURES = [  // name, unit, value in a summary, and whether less is better
  ["error of felt force, RMS", "m/s²", (s) => s.rmse, true],
  ["the same as perceived", "m/s²", (s) => worst(s.perceived_rmse), true],
  ["correlation, least", "", (s) => (s.correlation ? Math.min(...Object.values(s.correlation)) : NaN), false],
  ["delay, largest", "s", (s) => worst(s.delay_s), true],
  ["reach used, largest", "%", (s) => (s.workspace ? 100 * Math.max(...Object.values(s.workspace).map(({largest}) => largest)) : NaN)],
  ["false cues", "s", (s) => falseSeconds(s.false_cues), true],
  ["limits passed", "", (s) => s.violations, true, 0],
  ["step time, median", "µs", (s) => s.step_time_us?.median, true],
];

function falseSeconds(axes) {
  if (!axes) return NaN;
  return Object.values(axes).flatMap((kinds) => Object.values(kinds)).reduce((sum, {duration_s: seconds}) => sum + seconds, 0);
}

const FILES = {"report.html": "Report", "run.h5": "Run (HDF5)", "summary.json": "Summary (JSON)", "samples.csv": "Samples (CSV)"};

export class Result {
  constructor(root, {tell}) {
    this.tell = tell;
    const canvas = element("canvas", {width: 600, height: 170, role: "img", "aria-label": "Histogram of step times"}), text = element("p", {className: "about"});
    this.effort = new Effort(canvas, text);
    this.measures = element("div", {id: "measures"}, element("p", {className: "about"}, "The measures come when the run has ended."));
    this.files = element("div", {className: "files"});
    this.command = element("code");
    this.copy = element("button", {type: "button", hidden: true}, "Copy");
    this.copy.addEventListener("click", () => navigator.clipboard.writeText(this.command.textContent));
    this.export = element("section", {hidden: true}, element("h2", {}, "Export"), this.files, element("h2", {}, "The same as a command"), this.command, this.copy);
    root.append(element("section", {}, element("h2", {}, "Measures"), this.measures), this.export, element("section", {}, element("h2", {}, "Solver effort"), canvas, text));
  }

  /** Forget the last run. */
  clear() {
    this.measures.replaceChildren(element("p", {className: "about"}, "The measures come when the run has ended."));
    this.export.hidden = true;
  }

  /** Fetch and show what the last run gave; return it, or null if there is none. */
  async fetch() {
    let result;
    try {
      result = await get("/api/result");
    } catch (error) {
      if (!(error instanceof Refused)) throw error;
      if (error.status !== 404) this.tell({level: "warn", text: error.message});
      return null;
    }
    if (!result?.summary) return null;
    this.show(result);
    return result;
  }

  show({summary, second, files, command}) {
    const runs = second ? [["A", summary], ["B", second]] : [["", summary]];
    const rows = MEASURES.map(([title, unit, of, less, digits]) => ({title, unit, less, digits, values: runs.map(([, run]) => of(run))})).filter(({values}) => values.some(Number.isFinite));
    this.measures.replaceChildren(element("table", {className: "plain"},
      element("thead", {}, element("tr", {}, element("td"), ...runs.map(([letter, run]) => element("th", {scope: "col"}, letter ? `${letter} ${run.cueing}` : run.cueing)))),
      element("tbody", {}, ...rows.map((row) => element("tr", {}, element("th", {scope: "row"}, row.title, row.unit ? element("small", {}, ` [${row.unit}]`) : ""),
        ...row.values.map((value) => element("td", {className: better(row, value) ? "best" : ""}, (better(row, value) ? "★ " : "") + shown(value, row.digits))))))));
    this.files.replaceChildren(...files.map((name) => link(name)));
    this.command.textContent = command;
    this.copy.hidden = !navigator.clipboard;
    this.export.hidden = false;
  }
}

/** Return a link to a file of the result: a report opens beside this page, all others are saved. */
function link(name) {
  const made = element("a", {href: `/api/result/${encodeURIComponent(name)}`}, FILES[name] ?? name);
  return Object.assign(made, name.endsWith(".html") ? {target: "_blank", rel: "noopener"} : {download: name});
}

/** Whether a value is the better one of two. */
function better({values, less}, value) {
  if (less === undefined || values.length < 2 || values[0] === values[1]) return false;
  return value === (less ? Math.min(...values) : Math.max(...values));
}
