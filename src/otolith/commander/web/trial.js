// The tests before a ride: this computer, and every axis alone, watched by whoever stands beside the platform.
import {element} from "/web/look.js";

const TITLES = {check: "Testing this computer", axis: "Every axis alone"};
const MARKS = {yes: "✓", no: "✗"};

export class Trial {
  /** `order` sends a word of the errand. */
  constructor(root, {order}) {
    Object.assign(this, {root, open: false});
    this.title = element("h2");
    this.axes = element("ol", {className: "trials"});
    this.asks = element("p", {className: "asks", role: "status", "aria-live": "assertive"});
    const button = (text, word, className = "") => {
      const made = element("button", {type: "button", className, id: `trial-${word}`}, text);
      made.addEventListener("click", () => { made.disabled = true; order(word); });
      return made;
    };
    this.buttons = {move: button("Move it", "move", "go"), yes: button("Yes, that is what it did", "yes", "go"), no: button("No", "no")};
    this.stop = element("p", {className: "about"}, "STOP, Escape or the held space bar end it at any time; the platform then brakes, returns and parks.");
    this.bar = element("progress", {max: 60, "aria-label": "Time of the test"});
    this.said = element("ol", {className: "reach"});
    root.append(this.title, this.axes, this.asks, this.bar, element("div", {className: "row end"}, ...Object.values(this.buttons)), this.stop, this.said);
  }

  /** Show where a test stands: `shown` is what the errand states, `said` what its session told. */
  follow({busy, shown, said}) {
    this.root.hidden = !(busy in TITLES);
    if (this.root.hidden) return;
    const {asks = "", axis, seen, axes = [], answers = {}} = shown;
    this.title.textContent = TITLES[busy];
    this.axes.replaceChildren(...axes.map((name) => element("li", {className: `${answers[name] ?? ""}${name === axis ? " now" : ""}`}, element("b", {}, MARKS[answers[name]] ?? "○"), ` ${name}`)));
    const text = busy === "check" ? this.host(shown) : {
      ready: `Next: ${axis}. The platform will move ${seen}, and back, within 5 s. Is nobody aboard or in reach, and a hand at the emergency stop?`,
      moves: `${axis} moves ${seen}, and back: watch it.`, saw: `Did the platform move ${seen}, and back?`, starts: "The session starts; the platform will rise to neutral by itself.",
    }[asks] ?? "";
    if (this.asks.textContent !== text) this.asks.textContent = text;
    this.bar.hidden = busy !== "check";
    const key = `${asks} ${axis}`;
    if (key !== this.key) for (const one of Object.values(this.buttons)) one.disabled = false;
    this.key = key;
    this.buttons.move.hidden = asks !== "ready";
    for (const word of ["yes", "no"]) this.buttons[word].hidden = asks !== "saw";
    this.said.replaceChildren(...said.map((one) => element("li", {}, one)));
  }

  host({passed = 0, of = 60}) {
    this.bar.max = of;
    this.bar.value = passed;
    return `A session with a platform in software runs for ${of} s, to see whether this computer wakes in time. Nothing moves. ${passed} s have passed.`;
  }
}
