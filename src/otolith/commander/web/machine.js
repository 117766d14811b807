// Platform files of the user's own: begun from a template, checked as the command line does, saved by name.
import {get, post, put, Refused, remove} from "/web/api.js";
import {Field} from "/web/form.js";
import {element} from "/web/look.js";

const PREFIX = "machine-", NEW = "";

export class Machine {
  /** `saved` and `dropped` are called with the name of a file. */
  constructor({tell, saved, dropped}) {
    Object.assign(this, {tell, saved, dropped, fields: {}, asked: 0});
    this.list = element("select", {id: "machine", "aria-label": "Platform file"});
    this.list.addEventListener("change", () => this.attempt(() => this.open(this.list.value)));
    this.kind = element("select", {id: "machine-kind", "aria-label": "Kind of machine"});
    this.kind.addEventListener("change", () => this.show(this.kind.value, this.kinds[this.kind.value].values));
    this.about = element("p", {className: "about"});
    this.name = element("input", {type: "text", id: "machine-name", value: "my-rig", maxLength: 50, spellcheck: false, "aria-describedby": "machine-verdict"});
    this.name.addEventListener("change", () => this.attempt(() => this.check()));
    this.groups = element("div");
    this.verdict = element("p", {className: "judged", id: "machine-verdict", role: "status"});
    this.reach = element("ul", {className: "reach"});
    this.save = this.button("Save", () => this.keep(), "go");
    this.drop = this.button("Delete", () => this.delete());
    const row = (label, input) => element("div", {className: "choice"}, element("label", {htmlFor: input.id}, label), input);
    this.root = element("div", {}, row("File", this.list), row("Kind", this.kind), this.about, row("Name", this.name), this.groups,
      this.verdict, element("div", {className: "row"}, this.save, this.drop), this.reach);
  }

  button(text, act, className = "") {
    const made = element("button", {type: "button", className}, text);
    made.addEventListener("click", () => this.attempt(act));
    return made;
  }

  async attempt(act) {
    try {
      await act();
    } catch (error) {
      if (!(error instanceof Refused)) throw error;
      this.refuse(error);
    }
  }

  /** Fetch what there is, and begin a new machine or show the chosen one. */
  async begin(chosen = NEW) {
    const {own, kinds} = await get("/api/platforms");
    Object.assign(this, {kinds, own: own.map(({name}) => name)});
    this.kind.replaceChildren(...Object.keys(kinds).map((kind) => element("option", {value: kind}, kind)));
    this.list.replaceChildren(element("option", {value: NEW}, "a new one"), ...this.own.map((name) => element("option", {value: name}, name)));
    this.list.value = chosen;
    await this.open(chosen);
  }

  async open(name) {
    this.reach.replaceChildren();
    this.drop.hidden = name === NEW;
    this.kind.disabled = name !== NEW;
    if (name === NEW) return this.show(this.kind.value, this.kinds[this.kind.value].values);
    this.name.value = name.replace(/\.toml$/, "");
    const {kind, values} = await get(`/api/platforms/${encodeURIComponent(name)}`);
    this.kind.value = kind;
    return this.show(kind, values);
  }

  /** Build the form of a kind of machine. */
  async show(kind, values) {
    const {properties, text} = this.kinds[kind], groups = new Map();
    this.about.textContent = text;
    this.fields = {};
    for (const [name, property] of Object.entries(properties)) {
      const field = new Field(PREFIX + name, property, () => { field.mark(); this.attempt(() => this.check()); });
      this.fields[name] = field;
      field.base(values[name]);
      field.write(values[name]);
      groups.set(property["x-group"], [...(groups.get(property["x-group"]) ?? []), field]);
    }
    this.parts = [...groups].map(([title, fields]) => ({title, fields, said: element("small")}));
    this.groups.replaceChildren(...this.parts.map(({title, fields, said}, k) => element("details", {open: k === 0}, element("summary", {}, element("h3", {}, title), " ", said), ...fields.map(({root}) => root))));
    await this.check();
  }

  values() { return Object.fromEntries(Object.entries(this.fields).map(([name, field]) => [name, field.read()])); }

  path() { return `/api/platforms/${encodeURIComponent(`${this.name.value.trim()}.toml`)}`; }

  /** Say beside every group what stands in it, so that a closed one can be read. */
  sum() {
    for (const {fields, said} of this.parts) {
      const [low, high] = fields;
      if (!low.name.endsWith("_low")) continue;  // no axis
      said.textContent = low.read() === null ? "not there" : `−${low.read()} to ${high.read()} ${low.property["x-unit"]}`;
    }
  }

  /** Let the server judge the form; only the latest answer counts. */
  async check() {
    const number = this.asked += 1;
    this.sum();
    const {field, sentence} = await post(`${this.path()}/check`, {kind: this.kind.value, values: this.values()});
    if (number !== this.asked) return;
    if (sentence) this.refuse({message: sentence, field});
    else this.say("✓ the file is in order", false);
  }

  say(text, bad) {
    if (!bad) for (const field of Object.values(this.fields)) field.refuse("");
    if (this.verdict.textContent !== text) this.verdict.textContent = text;
    this.verdict.classList.toggle("bad", bad);
    this.save.disabled = bad;
  }

  refuse({message, field}) {
    this.say(`✗ ${message}`, true);
    for (const [name, one] of Object.entries(this.fields)) one.refuse(name === field ? message : "");
    this.fields[field]?.root.closest("details")?.setAttribute("open", "");
  }

  async keep() {
    this.say("looking at what it reaches …", false);
    this.save.disabled = true;
    const {name, sentences} = await put(this.path(), {kind: this.kind.value, values: this.values()});
    await this.begin(name);
    this.reach.replaceChildren(...sentences.map((text) => element("li", {}, text)));
    this.tell({level: "info", text: `platform file ${name} is saved`});
    await this.saved(name, this.fields.description.read());
  }

  async delete() {
    const name = this.list.value;
    await remove(`/api/platforms/${encodeURIComponent(name)}`);
    this.tell({level: "info", text: `platform file ${name} is deleted`});
    await this.dropped(name);
    await this.begin();
  }
}
