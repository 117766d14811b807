// Parameters by group, and presets: load, save, delete, compare.
import {put, get, Refused, remove} from "/web/api.js";
import {differences} from "/web/form.js";
import {element} from "/web/look.js";
import {CHAIN} from "/web/setup.js";

const LIVE = "While it runs";  // the group of what may be changed then

export class Tune {
  constructor(root, {fields, properties, settings, tell, presets, mode}) {
    Object.assign(this, {fields, properties, settings, tell, live: mode === "live"});
    const groups = new Map([[LIVE, []]]);
    for (const [name, property] of Object.entries(properties)) {
      if (CHAIN.includes(name)) continue;
      const group = fields[name].live ? LIVE : property["x-group"];
      groups.set(group, [...(groups.get(group) ?? []), fields[name].root]);
    }
    this.note = element("p", {className: "note", role: "status"});
    const box = this.presetBox();
    root.append(...(this.live ? [] : [box]), this.note, ...[...groups].map(([title, parts], k) => element("details", {open: k === 0}, element("summary", {}, element("h2", {}, title)), ...parts)));
    this.show(presets);
  }

  presetBox() {
    this.list = element("select", {id: "preset"});
    this.name = element("input", {type: "text", id: "preset-name", maxLength: 40, placeholder: "name", "aria-label": "Name of a new preset"});
    this.table = element("div", {className: "compared", role: "status"});
    const button = (text, act) => {
      const made = element("button", {type: "button"}, text);
      made.addEventListener("click", () => this.attempt(act));
      return made;
    };
    return element("section", {}, element("h2", {}, element("label", {htmlFor: "preset"}, "Preset")), element("div", {className: "row"}, this.list), element("div", {className: "row"},
      button("Load", () => this.load()), button("Compare", () => this.compare()), button("Delete", () => this.drop())),
    element("div", {className: "row"}, this.name, button("Save", () => this.save())), this.table);
  }

  async attempt(act) {
    try {
      await act();
    } catch (error) {
      if (!(error instanceof Refused)) throw error;
      this.tell({level: "warn", text: error.message});
    }
  }

  show(presets) {
    this.presets = new Map(presets.map(({name, values}) => [name, values]));
    const chosen = this.list.value;
    this.list.replaceChildren(...(presets.length ? [] : [element("option", {value: ""}, "none saved yet")]), ...[...this.presets.keys()].map((name) => element("option", {value: name}, name)));
    if (this.presets.has(chosen)) this.list.value = chosen;
  }

  async refresh() {
    const presets = await get("/api/presets");
    this.show(presets.presets ?? presets);
  }

  chosen() {
    const values = this.presets.get(this.list.value);
    if (!values) throw new Refused("no preset is chosen");
    return values;
  }

  async load() {
    const values = this.chosen();
    this.settings.base(values);
    await this.settings.set(values);
  }

  async save() {
    const name = this.name.value.trim();
    if (!name) throw new Refused("a preset needs a name");
    await put(`/api/presets/${encodeURIComponent(name)}`, this.settings.values());
    await this.refresh();
    this.list.value = name;
    this.settings.base(this.settings.values());
  }

  async drop() {
    this.chosen();
    await remove(`/api/presets/${encodeURIComponent(this.list.value)}`);
    await this.refresh();
  }

  compare() {
    this.table.replaceChildren(differences(this.properties, [[this.list.value, this.chosen()], ["now", this.settings.values()]]));
  }

  /** In a run only some settings can change; the others wait for the next. */
  follow({busy: running, control}) {
    for (const [name, field] of Object.entries(this.fields)) field.enable(!running || (control && field.live && !CHAIN.includes(name)));
    const how = this.live ? "A change begins at the next decision and comes about gradually, the whole range in 5 s." : "A change takes effect at the next step. Grey settings wait for the next run.";
    const text = running ? (control ? how : "Another window is in control.") : "";
    if (this.note.textContent !== text) this.note.textContent = text;
  }
}
