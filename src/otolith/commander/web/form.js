// Fields made from the JSON schema of the settings: unit, bounds, and what a setting does.
import {element, shown} from "/web/look.js";

/** Return the parts of a property's type: an optional number is [number, null]. */
function kinds(property) {
  return (property.anyOf ?? [property]).reduce((sum, part) => ({...sum, ...part, none: sum.none || part.type === "null", type: part.type === "null" ? sum.type : part.type ?? sum.type}), {});
}

/** Return the bounds of a number in few words. */
function ends({type, minimum, maximum, enum: choices}, unit = "") {
  if (choices || minimum === undefined || (type !== "number" && type !== "integer")) return unit;
  return `${minimum} to ${maximum} ${unit}`;
}

/** One setting: `read` and `write` its value, `refuse` shows a sentence. Changes act on release, not while dragging. */
export class Field {
  constructor(name, property, onChange) {
    Object.assign(this, {name, property, live: Boolean(property["x-live"]), type: kinds(property)});
    this.input = this.control();
    this.input.id = `field-${name}`;
    this.input.setAttribute("aria-describedby", `about-${name} error-${name}`);
    this.error = element("p", {className: "error", id: `error-${name}`, role: "alert"});
    this.undo = element("button", {type: "button", className: "undo", title: "Back to the preset", "aria-label": `Reset ${property.title}`}, "↺");
    this.undo.addEventListener("click", () => { this.write(this.preset); onChange(this); });
    this.input.addEventListener("change", () => { this.copy(this.input, this.slider); onChange(this); });
    const entry = element("span", {className: "entry"}, this.input, element("small", {}, ends(this.type, property["x-unit"])), this.undo);
    this.root = element("div", {className: "field"},
      element("label", {htmlFor: this.input.id}, property.title ?? name), entry, ...this.drag(onChange),
      element("p", {className: "about", id: `about-${name}`}, property.description ?? ""), this.error);
  }

  control() {
    const {type, enum: choices, minimum, maximum} = this.type;
    if (choices) return element("select", {}, ...choices.map((choice) => element("option", {value: choice}, choice || "–")));
    if (type === "boolean") return element("input", {type: "checkbox"});
    if (type !== "number" && type !== "integer") return element("input", {type: "text", spellcheck: false});
    const input = element("input", {type: "number", step: type === "integer" ? 1 : "any"});
    if (minimum !== undefined) input.min = minimum;
    if (maximum !== undefined) input.max = maximum;
    return input;
  }

  /** Return a slider where the setting has both bounds; it copies to the number while dragged and acts on release. */
  drag(onChange) {
    const {type, none, enum: choices, minimum, maximum} = this.type;
    if (none || choices || type !== "number" || minimum === undefined || maximum === undefined) return [];
    this.slider = element("input", {type: "range", min: minimum, max: maximum, step: (maximum - minimum) / 100, "aria-label": `${this.property.title}, slider`});
    this.slider.addEventListener("input", () => this.copy(this.slider, this.input));
    this.slider.addEventListener("change", () => onChange(this));
    return [this.slider];
  }

  copy(from, to) {
    if (to) to.value = from.value;
  }

  read() {
    const {type, none, enum: choices} = this.type, {value} = this.input;
    if (type === "boolean" && !choices) return this.input.checked;
    if (value === "" && none) return null;
    return type === "number" || type === "integer" ? (value === "" ? null : Number(value)) : value;
  }

  write(value) {
    if (this.type.type === "boolean" && !this.type.enum) this.input.checked = value;
    else this.input.value = value ?? "";
    this.copy(this.input, this.slider);
    this.refuse("");
    this.mark();
  }

  /** Take the value that counts as unchanged. */
  base(value) { this.preset = value ?? null; this.mark(); }

  mark() {
    const same = JSON.stringify(this.read()) === JSON.stringify(this.preset ?? null);
    this.root.classList.toggle("changed", !same);
    this.undo.hidden = same;
    this.undo.title = `Back to ${this.preset === null ? "none" : this.preset}`;
  }

  refuse(sentence) {
    this.error.textContent = sentence;
    this.input.setAttribute("aria-invalid", String(Boolean(sentence)));
  }

  enable(on) {
    for (const part of [this.input, this.slider, this.undo]) if (part) part.disabled = !on;
  }
}

/** Return a table of the settings that differ between named sets of values. */
export function differences(properties, sets) {
  const names = Object.keys(properties).filter((name) => new Set(sets.map(([, values]) => JSON.stringify(values[name] ?? null))).size > 1);
  if (!names.length) return element("p", {}, "They are equal.");
  const text = (value) => (value === null || value === undefined || value === "" ? "none" : typeof value === "number" ? shown(value) : String(value));
  return element("table", {className: "plain"},
    element("thead", {}, element("tr", {}, element("th", {}, "setting"), ...sets.map(([title]) => element("th", {}, title)))),
    element("tbody", {}, ...names.map((name) => element("tr", {}, element("th", {scope: "row"}, properties[name].title ?? name), ...sets.map(([, values]) => element("td", {}, text(values[name])))))));
}
