// What a run gave: measures, where the driver was misled, files, and the command that repeats it.
import {get, Refused} from "/web/api.js";
import {Effort} from "/web/effort.js";
import {element} from "/web/look.js";
import {table} from "/web/measures.js";

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
    const all = element("a", {href: "/web/runs.html", className: "all-runs", target: "_blank"}, "All runs");
    root.append(element("section", {}, element("h2", {}, "Measures"), this.measures, all), this.export, element("section", {}, element("h2", {}, "Solver effort"), canvas, text));
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
    this.measures.replaceChildren(table(runs.map(([letter, run]) => [letter ? `${letter} ${run.cueing}` : run.cueing, run])));
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
