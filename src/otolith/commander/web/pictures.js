// The five pictures of the experiment that shows the axes of a game, seen from above; forward is up.

const SVG = "http://www.w3.org/2000/svg";

function svg(tag, attributes, ...children) {
  const made = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children);
  return made;
}

/** Return a car at a place, turned to the left by an angle [deg]. */
function car(x, y, turn = 0) {
  return svg("g", {transform: `translate(${x} ${y}) rotate(${-turn})`, class: "car"},
    svg("rect", {x: -9, y: -17, width: 18, height: 34, rx: 6}), svg("path", {d: "M -6 -7 L 6 -7 L 5 -2 L -5 -2 Z", class: "glass"}));
}

/** Return an arrow along a path; its head points the way of its end, [deg] to the left of forward. */
function arrow(d, x, y, turn) {
  return svg("g", {class: "way"}, svg("path", {d, fill: "none"}), svg("path", {d: "M -6 7 L 0 -5 L 6 7", fill: "none", transform: `translate(${x} ${y}) rotate(${-turn})`}));
}

const DRAWN = {
  stand: () => [car(60, 45), svg("path", {d: "M 30 68 H 90 M 30 22 H 90", class: "mark"})],
  accelerate: () => [car(60, 62), arrow("M 60 36 V 8", 60, 10, 0)],
  brake: () => [car(60, 28), arrow("M 60 54 V 80", 60, 78, 180), svg("path", {d: "M 42 8 H 78", class: "mark"})],
  circle: () => [arrow("M 88 45 A 30 30 0 1 0 78 67", 79, 66, 305), car(88, 45)],
  turn: () => [car(84, 66), arrow("M 84 42 V 34 A 14 14 0 0 0 70 20 H 30", 31, 20, 90)],
};

/** What to do in each part, and how its value is told. */
export const PARTS = {
  stand: ["Stand still, level", " s", 1, "at rest"],
  accelerate: ["Accelerate straight ahead, several times", "", 2, "r"],
  brake: ["Brake straight, several times", "", 2, "r"],
  circle: ["Drive a circle to the left", "", 2, "r"],
  turn: ["Turn by 90° and drive on", "°", 0, "turned"],
};

export function picture(part) {
  return svg("svg", {viewBox: "0 0 120 90", role: "img", "aria-label": PARTS[part][0]}, ...DRAWN[part]());
}
