// Puts the page together: the stream fills the history, one animation loop draws it.
import {get, start} from "/web/api.js";
import {KIND} from "/web/frames.js";
import {History} from "/web/history.js";
import {byId, onLook} from "/web/look.js";
import {LapMap} from "/web/map.js";
import {Platform} from "/web/platform.js";
import {Plots} from "/web/plots.js";
import {Result} from "/web/result.js";
import {Rig} from "/web/rig.js";
import {Settings} from "/web/settings.js";
import {Setup} from "/web/setup.js";
import {Signals} from "/web/signals.js";
import {SoFar} from "/web/sofar.js";
import {bindStop, lampsOf, showLamps, showState, tellEvent} from "/web/state.js";
import {Stream} from "/web/stream.js";
import {bindTabs} from "/web/tabs.js";
import {Tools} from "/web/tools.js";
import {Tune} from "/web/tune.js";

const FRAME = 1000 / 30;  // [ms] least time between two drawings
const NUMBERS = 150;  // [ms] least time between two writings of numbers
const STALE = 0.5;  // [s] after which samples do not count as present

class Page {
  constructor(given) {
    this.given = given;
    this.history = new History([]);
    this.state = {running: false, lamps: {}, control: true, generation: null};
    Object.assign(this, {age: Infinity, dirty: false, unanswered: [], drawn: 0, written: 0, lost: null, heard: -1});
    this.plots = new Plots(byId("plots"));
    this.platform = new Platform();
    this.map = new LapMap(byId("map"));
    this.result = new Result(byId("result"), {tell: tellEvent});
    this.sofar = new SoFar(byId("sofar"));
    if (given.mode === "live") byId("tab-rig").remove();
    this.choose = bindTabs(document.querySelector("[role=tablist]"));
    this.form();
    if (given.mode === "live") byId("hint").textContent = "Plots open when the session sends samples.";
    this.stream = new Stream();
    this.signals = new Signals(this.stream);
    this.plots.addEventListener("changed", () => this.ask());
    bindStop(this.stream);
    this.listen();
    this.tools = new Tools(this);
    onLook(() => { this.dirty = true; });
    setInterval(() => this.judge(), 100);
    requestAnimationFrame((now) => this.draw(now));
  }

  form() {
    const {schema, values, choices, presets, mode} = this.given, {properties} = schema;
    if (mode === "offline") properties.log.enum = ["", ...choices.logs];
    this.settings = new Settings(properties, {tell: tellEvent, live: mode === "live", onChecks: (...checked) => this.setup.showChecks(...checked)});
    const shared = {fields: this.settings.fields, settings: this.settings, tell: tellEvent};
    this.setup = new Setup(byId("setup"), {...shared, choices, mode});
    this.tune = new Tune(byId("tune"), {...shared, properties, presets, mode});
    if (mode !== "live") this.rig = new Rig(byId("rig"), {...shared, setup: this.setup});
    this.settings.base(values);
    this.settings.set(values);
  }

  listen() {
    const on = (kind, act) => this.stream.addEventListener(kind, ({detail}) => act(detail));
    on("schema", (schema) => this.describe(schema));
    on("state", (state) => this.follow(state));
    on("event", (event) => this.happened(event));
    on("done", () => this.finished());
    on("refused", ({sentence}) => tellEvent({level: "warn", text: sentence}));
    on("rig", (told) => { this.rig?.hear(told); showState(this.rig?.word || this.state.state || "idle"); });
    on("frame", (frame) => this.take(frame));
    on("closed", (pause) => { this.lost ??= performance.now(); this.next = performance.now() + 1000 * pause; });
    on("open", () => { this.lost = null; });
    document.addEventListener("visibilitychange", () => { if (document.hidden) this.answer(); else this.dirty = true; });
    addEventListener("unhandledrejection", ({reason}) => tellEvent({level: "fault", text: `this page: ${reason?.message ?? reason}`}));
  }

  /** Take the signals of a run; a new generation is a new run, and its history begins empty. */
  async describe({offered: columns, columns: came, generation, values}) {
    this.signals.describe({offered: columns, columns: came});
    if (generation === this.generation) return this.ask();  // the same run: other signals of it
    Object.assign(this, {generation, history: new History(columns)});
    this.plots.describe(columns, this.history, (values ?? this.settings.values()).dofs);
    if (values) this.settings.show(values);
    this.result.clear();
    this.result.effort.describe(columns);
    this.sofar.describe(columns);
    this.tools.hold(false);
    await this.platform.describe(columns);
    this.map.describe(await get("/api/map"));
    this.dirty = true;
  }

  follow(told) {
    const state = {...told, busy: told.busy ?? told.running, control: told.control || told.controlled === false, here: told.control};
    this.state = state;
    this.settings.running = state.busy;
    if (state.busy) this.watched = state.generation;
    if (state.moving && state.generation === this.generation && this.history.know(state.moving)) this.plots.begin();
    if (state.parameters) this.settings.follow(state.parameters);
    byId("hint").hidden = this.history.length > 0 || state.busy;
    showState(this.rig?.word || state.state, state.text);
    this.setup.follow(state);
    this.tune.follow(state);
    this.rig?.follow(state);
    this.tools.follow(state, this.given.mode);
    if (!state.running && Number.isFinite(state.time)) this.clock(state.time);
  }

  happened(event) {
    if (event.number <= this.heard) return;  // told again after the line broke
    this.heard = event.number ?? this.heard;
    tellEvent(event);
    if (event.level === "parameter" && event.generation === this.generation) {
      this.plots.marks.push({at: event.time});
      this.dirty = true;
    }
  }

  async finished() {
    const result = await this.result.fetch();
    if (!result) return;
    this.plots.spans = result.false_cues ?? [];
    this.dirty = true;
    if (this.watched === this.generation) this.choose("result");  // a page that is opened later begins at the start
  }

  take({sequence, age, signals, kind}) {
    this.age = age;
    this.unanswered.push(sequence);
    if (signals.length === this.signals.came.length) {
      const first = !this.history.length, fresh = this.history.newer(this.signals.spread(signals));
      if (this.history.append(fresh) || first) this.plots.begin();
      this.result.effort.take(fresh);
      this.sofar.take(fresh, kind === KIND.ENVELOPE);
      this.dirty = true;
    }
    if (document.hidden || !this.dirty) this.answer();
  }

  ask() { this.signals.ask(this.plots.plotted, this.history.awake); }

  answer() {
    for (const sequence of this.unanswered.splice(0)) this.stream.acknowledge(sequence);
  }

  draw(now) {
    requestAnimationFrame((next) => this.draw(next));
    if (!this.dirty || document.hidden || now - this.drawn < FRAME - 4) return;
    this.dirty = false;
    const numbers = now - this.written > NUMBERS;
    this.drawn = now;
    if (numbers) this.written = now; else this.late = true;
    if (this.history.length) {
      this.plots.draw();
      this.showAt(this.cursor ?? this.tools.time ?? this.history.last, numbers);
      if (this.state.running) this.clock(this.history.last);
      if (numbers) for (const part of [this.result.effort, this.sofar]) part.draw();
    }
    this.answer();
  }

  showAt(time, numbers) {
    const row = Math.max(0, this.history.at(time));
    this.platform.show(this.history, row, numbers);
    this.map.draw(time);
    if (numbers) this.plots.write(row);
  }

  clock(time) { byId("clock").textContent = time.toFixed(1); }

  /** Say what is not known, and put the lamps out; never show the last value as if it were the present. */
  judge() {
    const now = performance.now(), silent = (now - this.stream.heard) / 1000, age = Math.max(this.age, silent);
    let text = "";
    if (this.lost) {
      const soon = Math.max(0, (this.next - now) / 1000);
      text = `No connection for ${((now - this.lost) / 1000).toFixed(1)} s; trying again in ${soon.toFixed(1)} s`;
      showState("no connection");
    } else if (this.state.state === "preparing") {
      text = this.state.text.replace(/^./, (letter) => letter.toUpperCase());
    } else if (this.state.running && age > STALE) {
      text = `No data for ${(Number.isFinite(age) ? age : silent).toFixed(1)} s`;
    }
    const veil = byId("veil");
    if (veil.textContent !== text) veil.textContent = text;
    veil.hidden = !text;
    document.body.classList.toggle("stale", Boolean(text));
    if (this.state.state) showLamps(lampsOf({...this.state, control: this.state.here}, age, this.given.mode), Boolean(text));
    if (this.late && now - this.written > NUMBERS) [this.late, this.dirty] = [false, true];
  }
}

try {
  new Page(await start());
} catch (error) {
  showState("no connection", error.message);
  tellEvent({level: "fault", text: `${error.message}: load this page again`});
  throw error;
}
