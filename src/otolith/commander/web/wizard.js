// The wizard that learns the axes of a game: five pictures, what each has shown so far, and a name to save it by.
import {element} from "/web/look.js";
import {picture, PARTS} from "/web/pictures.js";

export class Wizard {
  /** `order` sends a word of the errand, with values. */
  constructor(root, {order}) {
    Object.assign(this, {root, open: false});
    this.title = element("h2");
    this.cards = Object.fromEntries(Object.keys(PARTS).map((part) => [part, this.card(part)]));
    this.missing = element("p", {className: "about wide", role: "status"});
    this.found = element("ul", {className: "reach"});
    this.name = element("input", {type: "text", id: "map-name", maxLength: 50, spellcheck: false});
    this.save = element("button", {type: "button", className: "go", disabled: true}, "Save the axis map");
    this.save.addEventListener("click", () => order("save", {name: this.name.value.trim()}));
    this.cancel = element("button", {type: "button"}, "Cancel");
    this.cancel.addEventListener("click", () => order("cancel"));
    root.append(this.title, element("div", {className: "cards"}, ...Object.values(this.cards).map(({root: one}) => one)), this.missing, this.found,
      element("div", {className: "row end"}, element("label", {htmlFor: "map-name"}, "Name"), this.name, this.save, this.cancel));
  }

  card(part) {
    const [text] = PARTS[part], mark = element("b", {"aria-hidden": "true"}, "○"), value = element("output"), meter = element("meter", {min: 0, max: 1, "aria-label": text});
    return {mark, value, meter, root: element("figure", {}, picture(part), element("figcaption", {}, mark, ` ${text}`), meter, value)};
  }

  /** Show where learning stands: `shown` is what the errand states. */
  follow({busy, shown}) {
    const open = busy === "learn";
    if (open && !this.open) this.name.value = this.suggested;
    this.open = open;
    this.root.hidden = !open;
    if (!open || !shown.parts) return;
    this.title.textContent = `Learning the axes: ${shown.packets} packets on port ${shown.port}${shown.refused ? `, ${shown.refused} refused` : ""}`;
    for (const {part, value, needs, passed} of shown.parts) this.card_(part, value, needs, passed);
    const text = shown.missing ? `Still lacking: ${shown.missing}` : shown.learned.length ? "✓ All of it was shown. Save it, or drive on." : "";
    if (this.missing.textContent !== text) this.missing.textContent = text;
    this.found.replaceChildren(...shown.learned.map((one) => element("li", {}, one)));
    this.save.disabled = !shown.learned.length;
  }

  card_(part, value, needs, passed) {
    const {root, mark, value: output, meter} = this.cards[part], [, unit, digits, what] = PARTS[part];
    root.classList.toggle("passed", passed);
    mark.textContent = passed ? "✓" : "○";
    meter.value = Math.min(1, value / needs);
    output.textContent = `${what} ${value.toFixed(digits)}${unit} of ${needs.toFixed(digits)}${unit}`;
  }
}
