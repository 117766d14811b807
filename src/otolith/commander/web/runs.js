// The page of all stored runs: their measures in a table that can be sorted, and two of them side by side.
import {get, start} from "/web/api.js";
import {byId, element, shown} from "/web/look.js";
import {MEASURES, table} from "/web/measures.js";
import {bindStop, showState, tellEvent} from "/web/state.js";
import {Stream} from "/web/stream.js";

const day = new Intl.DateTimeFormat("sv-SE", {dateStyle: "short", timeStyle: "medium"});  // as in ISO 8601
const TEXTS = [["when", ({time}) => time, ({time}) => day.format(1000 * time)], ...[["drive", "scenario"], ["platform", "platform"], ["algorithm", "cueing"]].map(([title, name]) => [title, (run) => run[name], (run) => run[name]])];
const NUMBERS = MEASURES.map(([title, unit, of, , digits]) => [unit ? `${title} [${unit}]` : title, ({summary}) => of(summary) ?? NaN, ({summary}) => shown(of(summary), digits)]);
const COLUMNS = [...TEXTS, ...NUMBERS];  // title, what is sorted by, text

class Runs {
  constructor({runs, refused, left_out: left}) {
    Object.assign(this, {runs, chosen: [], by: 0, down: true});
    const more = left ? `; ${left} older ones are not shown` : "";
    byId("note").textContent = runs.length ? `${runs.length} runs${more}. Choose two to compare them.` : "No run is stored yet.";
    for (const text of refused) tellEvent({level: "warn", text});
    this.heads = COLUMNS.map(([title], k) => {
      const button = element("button", {type: "button"}, title);
      button.addEventListener("click", () => this.sort(k));
      return element("th", {scope: "col", className: k < TEXTS.length ? "text" : ""}, button);
    });
    byId("runs").tHead.append(element("tr", {}, element("td"), ...this.heads, element("th", {scope: "col"}, "report")));
    this.rows = new Map(runs.map((run) => [run, this.row(run)]));
    this.show();
  }

  row(run) {
    const box = element("input", {type: "checkbox", "aria-label": `Compare ${run.folder} ${run.cueing}`});
    box.addEventListener("change", () => this.choose(run, box.checked));
    const report = run.files.includes("report.html") ? [element("a", {href: `/api/runs/${encodeURIComponent(run.folder)}/report.html`, target: "_blank", rel: "noopener"}, "Report")] : [];
    const made = element("tr", {}, element("td", {}, box), ...COLUMNS.map(([, , text], k) => element("td", {className: k < TEXTS.length ? "text" : ""}, text(run))), element("td", {}, ...report));
    return Object.assign(made, {box});
  }

  /** Sort by a column, or the other way round; what is unknown comes last. */
  sort(k) {
    this.down = this.by === k ? !this.down : false;
    this.by = k;
    this.show();
  }

  show() {
    const [, of] = COLUMNS[this.by], way = this.down ? -1 : 1, unknown = (value) => value === undefined || Number.isNaN(value);
    const order = [...this.runs].sort((one, other) => {
      const [a, b] = [of(one), of(other)];
      if (unknown(a) || unknown(b)) return unknown(a) - unknown(b);
      return way * (a < b ? -1 : a > b ? 1 : 0);
    });
    this.heads.forEach((head, k) => head.setAttribute("aria-sort", k !== this.by ? "none" : this.down ? "descending" : "ascending"));
    byId("runs").tBodies[0].replaceChildren(...order.map((run) => this.rows.get(run)));
  }

  /** Choose a run; of more than two the one that was chosen first goes. */
  choose(run, on) {
    this.chosen = this.chosen.filter((one) => one !== run);
    if (on) this.chosen.push(run);
    if (this.chosen.length > 2) this.rows.get(this.chosen.shift()).box.checked = false;
    const pair = this.chosen, about = pair.length < 2 ? "Choose two." : pair[0].scenario === pair[1].scenario ? "" : "They are of different drives.";
    const titled = pair.map((one, k) => [`${"AB"[k]} ${one.cueing}, ${day.format(1000 * one.time)}`, one.summary]);
    byId("compared").replaceChildren(element("h2", {}, "Two runs compared"), element("p", {className: "about"}, about), ...(pair.length === 2 ? [table(titled)] : []));
  }
}

/** Show the state, and keep STOP within reach, here too; of the signals only the time is asked for. */
function watch() {
  const stream = new Stream();
  bindStop(stream);
  stream.addEventListener("state", ({detail}) => showState(detail.state, detail.text));
  stream.addEventListener("schema", ({detail}) => { if (detail.columns.length > 1) stream.choose(["time"]); });
  stream.addEventListener("frame", ({detail}) => stream.acknowledge(detail.sequence));
  stream.addEventListener("closed", () => showState("no connection"));
}

try {
  await start();
  watch();
  new Runs(await get("/api/runs"));
} catch (error) {
  showState("no connection", error.message);
  tellEvent({level: "fault", text: `${error.message}: load this page again`});
  throw error;
}
