// The start chain: input, platform, algorithm, checks, and then the button that begins.
import {post, Refused} from "/web/api.js";
import {element} from "/web/look.js";
import {opener} from "/web/opened.js";

const LIVE = [["arm", "Arm"], ["engage", "Engage"], ["return", "Return"], ["park", "Park"], ["rearm", "Rearm"]];
const LIVE_HINT = "A live session is set up on the command line. Arm checks and connects, Engage lifts the platform and follows the drive, Return comes back to neutral, Park lowers it; Rearm takes back a fault once its cause is gone.";
const STEPS = [["1 Input", ["scenario", "log"]], ["2 Platform", ["platform", "dofs", "plant"]], ["3 Algorithm", ["cueing", "second"]]];

const STALE = 0.5;  // [s] after which telemetry does not arrive

/** Return a line of a list of checks; `more` stands below its sentence. */
export function check(name, ok, sentence, ...more) {
  return element("li", {className: ok ? "ok" : "bad"}, element("i", {"aria-label": ok ? "passed" : "failed"}, ok ? "✓" : "✗"),
    element("span", {}, element("b", {}, name), sentence ? ` ${sentence}` : "", ...more));
}

/** Names of the settings that are chosen here; all others are tuned. */
export const CHAIN = STEPS.flatMap(([, names]) => names);

export class Setup {
  constructor(root, {fields, choices, mode, settings, tell}) {
    Object.assign(this, {fields, settings, tell, mode});
    const texts = {scenario: choices.scenarios, platform: choices.platforms, cueing: choices.cueing, plant: choices.plants, second: choices.cueing};
    const steps = STEPS.map(([title, names]) => this.step(title, names.filter((name) => name in fields), texts));
    this.inputs = [];  // beside those of the fields
    if (mode !== "live") {
      this.offer(choices.scenarios);
      this.file();
    }
    this.checks = element("ul", {className: "checks"});
    this.command = element("code");
    this.verdict = element("p", {className: "verdict", role: "status"});
    const last = element("section", {}, element("h2", {}, "4 Checks"), this.checks);
    if (mode === "live") root.append(element("p", {className: "about"}, LIVE_HINT), this.checks, this.buttons());
    else root.append(...steps, last, element("details", {}, element("summary", {}, "The same as a command"), this.command), this.buttons());
  }

  /** Offer a platform file of the user's own, or a changed one; `text` describes it. */
  platform(name, text) {
    const {input} = this.fields.platform;
    if (![...input.options].some(({value}) => value === name)) input.append(element("option", {value: name}, name));
    this.platforms.set(name, text);
  }

  /** Offer a platform file no more; the first one takes its place. */
  async without(name) {
    const {input} = this.fields.platform, chosen = input.value === name;
    [...input.options].find(({value}) => value === name)?.remove();
    if (chosen) await this.settings.set({platform: input.options[0].value});
  }

  step(title, names, texts) {
    const parts = names.map((name) => {
      const field = this.fields[name], about = element("p", {className: "about", id: `about-${name}`});
      const entries = new Map((texts[name] ?? []).map((entry) => [entry.name, entry.text]));
      if (name === "platform") this.platforms = entries;
      const tell = () => { about.textContent = entries.get(field.input.value) ?? ""; };
      field.input.addEventListener("change", tell);
      field.told = tell;
      return element("div", {className: "choice"}, element("label", {htmlFor: field.input.id}, field.property.title ?? name), field.input, about, field.error);
    });
    return element("section", {}, element("h2", {}, title), ...parts);
  }

  /** List the scenarios above the text of the one that is chosen, which may also be a formula. */
  offer(scenarios) {
    const field = this.fields.scenario, names = scenarios.filter(({name}) => !name.endsWith("…"));
    const pick = element("select", {"aria-label": "Scenarios", id: "scenarios"}, element("option", {value: ""}, "a formula:"), ...names.map(({name}) => element("option", {value: name}, name)));
    const formulas = scenarios.filter(({name}) => name.endsWith("…")).map(({name, text}) => name.replace("…", text.split("; ").pop()));
    this.inputs.push(pick);
    field.input.setAttribute("list", "formulas");
    pick.addEventListener("change", () => this.settings.set({scenario: pick.value || formulas[0], log: ""}));
    const tell = field.told, about = field.input.parentElement.querySelector(".about");
    field.told = () => {
      tell();
      pick.value = names.some(({name}) => name === field.input.value) ? field.input.value : "";
      if (this.fields.log.read()) about.textContent = "not used: a recorded drive is cued";
    };
    field.input.addEventListener("change", field.told);
    field.input.before(pick, element("datalist", {id: "formulas"}, ...formulas.map((value) => element("option", {value}))));
    pick.after(field.input);
  }

  /** Put the input for a file of a drive beside the list of drives; the server keeps it in one folder. */
  file() {
    const {log, scenario} = this.fields;
    this.inputs.push(opener(log, {id: "file", accept: ".csv,.tsv,.txt,.json", title: "A drive of your own", chosen: (name) => this.settings.set({log: name})}));
    log.told = () => scenario.told();
    log.input.addEventListener("change", log.told);
  }

  buttons() {
    this.run = element("button", {type: "button", className: "go", id: "run"}, "▶ Run");
    this.run.addEventListener("click", () => this.settings.run());
    this.take = element("button", {type: "button", id: "control"}, "Take control");
    this.take.addEventListener("click", () => this.word("control"));
    this.words = this.mode === "live" ? LIVE.map(([word, label]) => {
      const button = element("button", {type: "button", id: `word-${word}`, className: word === "engage" ? "go" : "", disabled: true}, label);
      button.addEventListener("click", () => this.word(word));
      return button;
    }) : [];
    return element("div", {className: "go-row"}, this.verdict, ...(this.words.length ? this.words : [this.run]), this.take);
  }

  async word(word) {
    try {
      await post("/api/word", {word});
    } catch (error) {
      if (!(error instanceof Refused)) throw error;
      this.tell({level: "warn", text: error.message});
    }
  }

  /** Show what was checked: [{name, ok, sentence}]. */
  showChecks(checks, command) {
    this.ready = checks.every(({ok}) => ok);
    this.checks.replaceChildren(...checks.map(({name, ok, sentence}) => check(name, ok, sentence)));
    const bad = checks.filter(({ok}) => !ok), said = bad.length ? `✗ ${bad[0].sentence || bad[0].name}` : `✓ ${checks.length} checks passed`;
    if (this.verdict.textContent !== said) this.verdict.textContent = said;
    this.verdict.classList.toggle("bad", bad.length > 0);
    this.command.textContent = command ?? "";
    this.enable();
  }

  /** Show what a live session still lacks before it may be armed and engaged. */
  showLacks(forbids, age) {
    const arrives = Number.isFinite(age) && age < STALE, rig = "; end this session, and do so under Rig of otolith commander";
    const checks = [["tests", !forbids, forbids ? forbids + rig : "this computer and the axes are tested"], ["telemetry", arrives, arrives ? "arrives" : "nothing arrives: does the game send to this port?"]];
    const said = JSON.stringify(checks);
    if (said === this.lacked) return;
    this.lacked = said;
    this.checks.replaceChildren(...checks.map(([name, ok, sentence]) => check(name, ok, sentence)));
  }

  /** Follow the state: what is possible now. */
  follow({busy: running, control, words, forbids, lamps}) {
    Object.assign(this, {running, control});
    if (this.mode === "live" && forbids !== undefined) this.showLacks(forbids, lamps.telemetry_age_s);
    for (const input of this.inputs) input.disabled = running;
    this.take.hidden = control;
    if (words) this.words.forEach((button, k) => { button.disabled = !control || !words.includes(LIVE[k][0]); });
    this.enable();
  }

  enable() {
    this.run.disabled = Boolean(this.running) || this.control === false || !this.ready;
    this.run.textContent = this.running ? "busy …" : this.control === false ? "controlled elsewhere" : "▶ Run";
  }
}
