// A rig from nothing, step by step: machine, device, telemetry, this computer, every axis alone, the first ride.
import {get, post, Refused} from "/web/api.js";
import {Field} from "/web/form.js";
import {byId, element} from "/web/look.js";
import {Machine} from "/web/machine.js";
import {opener} from "/web/opened.js";
import {check} from "/web/setup.js";
import {Trial} from "/web/trial.js";
import {Wizard} from "/web/wizard.js";

const PREFIX = "rig-";
const ABOUT = {
  check: "A session with a platform in software, which shows whether the output wakes in time. No session arms without it.",
  axis: "Nobody aboard or in reach, a hand at the emergency stop. Each moves by 10 mm or 1 degree, out and back, when you let it; then you say what you saw. No session arms without it.",
  ride: "When all is ticked, end this Commander, run the command, and open the address that it prints: Arm, then Engage. Begin with a small scale.",
};

export class Rig {
  constructor(root, {settings, setup, tell}) {
    Object.assign(this, {settings, setup, tell, fields: {}, running: false, told: {}});
    this.machine = new Machine({tell, saved: (name, text) => this.saved(name, text), dropped: (name) => this.dropped(name)});
    this.wizard = new Wizard(byId("wizard"), {order: (word, values) => this.order(word, values)});
    this.trial = new Trial(byId("trial"), {order: (word) => this.order(word)});
    this.places = Object.fromEntries(["Platform", "Device", "Telemetry", "First ride"].map((group) => [group, element("div")]));
    this.verdict = element("p", {className: "judged", role: "status", id: "rig-verdict"});
    this.learn = this.button("Learn the axes …", () => this.order("learn"), "learn");
    this.check = this.button("Test this computer (60 s)", () => this.order("check"), "check");
    this.what = element("select", {id: "rig-what", "aria-label": "What is moved"}, element("option", {value: "axes"}, "every axis"), element("option", {value: "legs"}, "every leg"));
    this.axis = this.button("Begin", () => this.order("axis", {what: this.what.value}), "axis");
    this.heard = Object.fromEntries(["learn", "check", "axis"].map((errand) => [errand, element("p", {className: "note", role: "status"})]));
    this.lacks = element("ul", {className: "checks lacks"});
    this.command = element("code");
    this.steps = {};
    const section = (name, title, ...parts) => (this.steps[name] = element("details", {open: name === "machine"}, element("summary", {}, element("h2", {}, title)), ...parts));
    root.append(section("machine", "1 Your machine", this.machine.root), section("device", "2 Platform and device", this.places.Platform, this.places.Device),
      section("telemetry", "3 Telemetry", this.places.Telemetry, this.learn, this.heard.learn),
      section("check", "4 This computer", element("p", {className: "about"}, ABOUT.check), this.check, this.heard.check),
      section("axis", "5 Every axis alone", element("p", {className: "about"}, ABOUT.axis), element("div", {className: "row"}, this.what, this.axis), this.heard.axis),
      section("ride", "6 First ride", this.lacks, this.places["First ride"], element("p", {className: "about"}, ABOUT.ride), this.command), this.verdict);
    byId("tab-rig").addEventListener("click", () => this.attempt(() => this.begin()), {once: true});
  }

  button(text, act, id) {
    const made = element("button", {type: "button", id: `rig-${id}`}, text);
    made.addEventListener("click", () => this.attempt(act));
    return made;
  }

  async attempt(act) {
    try {
      await act();
    } catch (error) {
      if (!(error instanceof Refused)) throw error;
      this.tell({level: "warn", text: error.message});
    }
  }

  async order(word, values = {}) { await this.attempt(() => post("/api/errand", {word, ...values})); }

  /** Ask for what there is when the tab is opened for the first time. */
  async begin() {
    await this.machine.begin();
    await this.describe();
  }

  /** Build the fields of the rig. */
  async describe() {
    const {schema, values, ports} = await get("/api/rig");
    this.ports = ports;
    for (const place of Object.values(this.places)) place.replaceChildren();
    for (const [name, property] of Object.entries(schema.properties)) {
      const field = new Field(PREFIX + name, property, () => { field.mark(); this.attempt(() => this.changed(name)); });
      this.fields[name] = field;
      field.base(values[name]);
      field.write(values[name]);
      this.places[property["x-group"]].append(field.root);
    }
    const {channels, source} = this.fields;
    opener(channels, {id: "channels-file", accept: ".json,.xml", title: "The file that the game wrote, or that you gave to it", path: "/api/channels", more: () => ({source: source.read()}), chosen: (name) => { channels.write(name); return this.keep(); }});
    await this.keep();
  }

  values() { return Object.fromEntries(Object.entries(this.fields).map(([name, field]) => [name, field.read()])); }

  async changed(name) {
    const {source, listen} = this.fields;
    if (name === "source") listen.write(listen.read().replace(/\d+$/, this.ports[source.read()]));  // the game's own port
    await this.keep();
  }

  /** Keep the rig as it stands, if it is in order; only the latest answer counts. */
  async keep() {
    const number = this.asked = (this.asked ?? 0) + 1, kinds = [this.fields.device.read(), this.fields.source.read()];
    for (const {root, property} of Object.values(this.fields)) root.hidden = property["x-of"].length > 0 && !property["x-of"].some((one) => kinds.includes(one));
    this.wizard.suggested = this.fields.map.read().replace(/\.toml$/, "") || this.fields.source.read();
    const {field, sentence} = await post("/api/rig", this.values());
    if (number !== this.asked) return;
    this.sound = !sentence;
    this.verdict.textContent = sentence ? `✗ ${sentence}` : "✓ kept as rig.toml";
    this.verdict.classList.toggle("bad", Boolean(sentence));
    for (const [name, one] of Object.entries(this.fields)) one.refuse(name === field ? sentence : "");
    this.enable();
    await this.look();
  }

  /** Show what is still lacking before a ride, each with the button that leads to it. */
  async look() {
    const {checks, command} = await get("/api/rig/lacks");
    this.lacks.replaceChildren(...checks.map(({name, ok, sentence, leads}) => {
      const button = element("button", {type: "button"}, `To ${this.steps[leads].querySelector("h2").textContent}`);
      button.addEventListener("click", () => this.go(leads));
      return check(name, ok, sentence, ...(ok ? [] : [element("br"), button]));
    }));
    this.command.textContent = checks.every(({ok}) => ok) ? command : "";
    this.command.hidden = !this.command.textContent;
  }

  /** Open a step, close the others, and go there. */
  go(name) {
    for (const [one, step] of Object.entries(this.steps)) step.open = one === name;
    this.steps[name].querySelector("summary").focus();
    this.steps[name].scrollIntoView({block: "start"});
  }

  /** Follow the errand of the rig's process. */
  async hear(told) {
    const before = this.told;
    this.told = told;
    this.word = {learn: "learning", check: "testing", axis: "axis test"}[told.busy] ?? "";  // in the top bar, in place of idle
    this.wizard.follow(told);
    this.trial.follow(told);
    this.enable();
    if (!before.busy || told.busy) return;
    this.tell({level: told.phase === "failed" ? "fault" : told.phase === "stopped" ? "warn" : "info", text: told.sentence});
    this.heard[told.errand].textContent = told.sentence;
    if (told.errand === "learn") await this.learned(told);
    await this.attempt(() => this.look());
  }

  async learned({phase, shown}) {
    if (phase !== "done") return;
    const name = shown.map, {map} = this.fields;
    if (![...map.input.options].some(({value}) => value === name)) map.input.append(element("option", {value: name}, name));
    map.write(name);
    await this.attempt(() => this.keep());
  }

  /** Offer a saved platform file for runs and for the rig, and choose it unless a run goes on. */
  async saved(name, text) {
    this.setup.platform(name, text);
    await this.describe();
    this.fields.platform.write(name);
    await this.keep();
    if (!this.running) await this.settings.set({platform: name});
  }

  async dropped(name) {
    await this.setup.without(name);
    await this.describe();
  }

  follow({busy, control}) {
    Object.assign(this, {running: busy, control});
    this.enable();
  }

  enable() {
    const free = this.control !== false && !this.told.busy && this.sound === true;
    this.learn.disabled = !free;
    for (const one of [this.check, this.axis]) one.disabled = !free || this.running;
  }
}
