// The top bar: what the system does, how healthy it is, and STOP. Below the plots: what happened, and when.
import {post, Refused} from "/web/api.js";
import {byId, element} from "/web/look.js";

const SHAPES = {run: "▶", idle: "○", ready: "●", wait: "◆", halt: "■", fault: "✖"};
const LOOKS = {  // of the states of a run, and of a live session; any other looks idle
  running: "run", engaged: "run", done: "ready", ready: "ready", stopped: "halt", failed: "fault", fault: "fault",
  "axis test": "run", testing: "wait", learning: "wait", preparing: "wait", paused: "wait", writing: "wait", checking: "wait", engaging: "wait", holding: "wait",
  returning: "wait", parking: "wait", "no connection": "fault",
};
const KEPT = 200;  // events
const HELD = 500;  // [ms] for which the space bar is held to stop

/** Return the lamps of a state message as [name, value, level, what it means]; the level is ok, warn, fault or off. */
export function lampsOf({lamps, running, control, controlled}, age, mode = "offline") {
  const {telemetry_age_s: telemetry, missed, gate_refused: refused, clock, log} = lamps;
  const {missed_lately: lately = missed, refused_lately: refusedLately = refused} = lamps;
  const level = (value, warn, fault) => (!Number.isFinite(value ?? NaN) ? "off" : value > fault ? "fault" : value > warn ? "warn" : "ok");
  const milliseconds = (value) => (Number.isFinite(value ?? NaN) ? `${Math.round(1000 * value)} ms` : "–");
  const input = mode === "offline" ? "file" : milliseconds(telemetry), logged = log ? "trouble" : "written";
  const all = [
    ["data", running ? milliseconds(age) : "no run", running ? level(age, 0.2, 0.5) : "off", "age of the newest sample on this page"],
    ["input", input, level(telemetry, 0.1, 0.5), "age of the telemetry that the latest plan answers"],
    ["clock", milliseconds(clock), level(clock, 0.05, 0.5), mode === "offline" ? "how far the run is behind real time" : "how late the newest packet came, by the sender's clock, against the quickest"],
    ["gate", refused === null ? "–" : refused ? `${refused} refused` : "clear", level(refusedLately, 0, 100), "decisions that were refused or failed since the beginning; the colour is of the last 10 s"],
    ["misses", missed ?? "–", level(lately, 0, 10), "decisions that came too late since the beginning; the colour is of the last 10 s"],
    ["log", logged, log ? "fault" : "ok", log || "the log of the session is written"],
    ["control", control ? "here" : controlled ? "elsewhere" : "nobody", control ? "ok" : controlled ? "warn" : "off", "which page may say words other than STOP"],
  ];
  return all.map((one) => (one[0] === "log" && (log ?? null) === null ? ["log", "none", "off", "nothing is logged"] : one));
}

const LIGHTS = {ok: "●", warn: "▲", fault: "■", off: "○"};

/** Show lamps; with `dark` all are off, because nothing is known. */
export function showLamps(lamps, dark = false) {
  const list = byId("lamps");
  if (list.children.length !== lamps.length) {
    list.replaceChildren(...lamps.map(([name]) => element("li", {}, element("small", {}, name), element("span"))));
  }
  lamps.forEach(([, value, level, about], k) => {
    const item = list.children[k], text = dark ? "○ –" : `${LIGHTS[level]} ${value}`;
    if (item.title !== about) item.title = about;
    item.dataset.level = dark ? "off" : level;
    if (item.lastChild.textContent !== text) item.lastChild.textContent = text;
  });
}

export function showState(word, text = "") {
  const state = byId("state"), look = LOOKS[word] ?? "idle";
  if (state.dataset.word === word && state.title === text) return;
  Object.assign(state.dataset, {word, look});
  state.title = text;
  state.firstElementChild.textContent = SHAPES[look];
  state.lastElementChild.textContent = word;
}

/** Append an event to the list at the bottom; `level` is info, warn, fault or parameter. */
export function tellEvent({time, level, text}) {
  const list = byId("events"), sign = {warn: "▲", fault: "■", parameter: "◆"}[level] ?? "●";
  const following = !list.matches(":hover, :focus");  // whoever reads further up is left alone
  const stamp = element("time", {}, Number.isFinite(time) ? `${time.toFixed(2)} s` : "");
  list.append(element("li", {className: level}, stamp, element("i", {"aria-hidden": "true"}, sign), text));
  while (list.children.length > KEPT) list.firstChild.remove();
  if (following) list.scrollTop = list.scrollHeight;
}

addEventListener("resize", () => { byId("events").scrollTop = byId("events").scrollHeight; });

/** Send STOP by both ways, again and again until one has arrived. */
export async function stop(stream) {
  const button = byId("stop");
  button.classList.add("pressed");
  stream.send({word: "stop"});
  for (let attempt = 0; attempt < 40; attempt += 1) {
    try {
      await post("/api/word", {word: "stop"});
      button.classList.remove("pressed");
      return;
    } catch (error) {
      if (!(error instanceof Refused)) throw error;
      if (attempt === 0) tellEvent({level: "fault", text: `STOP has not arrived: ${error.message}. Use the emergency stop of the platform. Trying again.`});
      await new Promise((resume) => setTimeout(resume, 250));
      stream.send({word: "stop"});
    }
  }
  tellEvent({level: "fault", text: "STOP has not arrived for 10 s. Use the emergency stop of the platform."});
  button.classList.remove("pressed");
}

const typing = (target) => target.matches?.("input:not([type=checkbox], [type=range]), textarea, [contenteditable]");

/** Bind STOP to its button, to Escape, and to the space bar held down; nothing on the page comes before them. */
export function bindStop(stream) {
  let timer = null, stopped = false;
  byId("stop").addEventListener("click", () => stop(stream));
  addEventListener("keydown", (event) => {
    if (event.key === "Escape" && !event.repeat) {
      event.preventDefault();
      stop(stream);
    } else if (event.key === " " && !typing(event.target)) {
      if (event.repeat) event.preventDefault();
      timer ??= setTimeout(() => { stopped = true; stop(stream); }, HELD);
    }
  }, true);
  addEventListener("keyup", (event) => {
    if (event.key !== " ") return;
    if (stopped) event.preventDefault();  // the button under the focus is not pressed as well
    clearTimeout(timer);
    [timer, stopped] = [null, false];
  }, true);
  addEventListener("blur", () => { clearTimeout(timer); timer = null; });
}
