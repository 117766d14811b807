// The measures of runs, side by side: a star marks the better of two.
import {element, shown} from "/web/look.js";

const worst = (record) => (record && typeof record === "object" ? Math.max(...Object.values(record)) : record);

function falseSeconds(axes) {
  if (!axes) return NaN;
  return Object.values(axes).flatMap((kinds) => Object.values(kinds)).reduce((sum, {duration_s: seconds}) => sum + seconds, 0);
}

export const MEASURES = [  // name, unit, value in a summary, whether less is better, digits
  ["error of felt force, RMS", "m/s²", (s) => s.rmse, true],
  ["the same as perceived", "m/s²", (s) => worst(s.perceived_rmse), true],
  ["correlation, least", "", (s) => (s.correlation ? Math.min(...Object.values(s.correlation)) : NaN), false],
  ["delay, largest", "s", (s) => worst(s.delay_s), true],
  ["reach used, largest", "%", (s) => (s.workspace ? 100 * Math.max(...Object.values(s.workspace).map(({largest}) => largest)) : NaN)],
  ["false cues", "s", (s) => falseSeconds(s.false_cues), true],
  ["limits passed", "", (s) => s.violations, true, 0],
  ["step time, median", "µs", (s) => s.step_time_us?.median, true],
];

/** Return a table of runs, each [title, summary]. */
export function table(runs) {
  const rows = MEASURES.map(([title, unit, of, less, digits]) => ({title, unit, less, digits, values: runs.map(([, run]) => of(run))})).filter(({values}) => values.some(Number.isFinite));
  return element("table", {className: "plain"},
    element("thead", {}, element("tr", {}, element("td"), ...runs.map(([title]) => element("th", {scope: "col"}, title)))),
    element("tbody", {}, ...rows.map((row) => element("tr", {}, element("th", {scope: "row"}, row.title, row.unit ? element("small", {}, ` [${row.unit}]`) : ""),
      ...row.values.map((value) => element("td", {className: better(row, value) ? "best" : ""}, (better(row, value) ? "★ " : "") + shown(value, row.digits)))))));
}

/** Whether a value is the better one of two. */
function better({values, less}, value) {
  if (less === undefined || values.length < 2 || values[0] === values[1]) return false;
  return value === (less ? Math.min(...values) : Math.max(...values));
}
