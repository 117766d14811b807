// Colours of the style sheet for what is drawn on canvases, and small helpers for elements.

let colours = {};
const changed = new Set();
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
  colours = {};
  for (const redraw of changed) redraw();
});

/** Return the value of a CSS variable of the present look, light or dark. */
export function css(name) {
  colours[name] ??= getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  return colours[name];
}

/** Call a function whenever light turns to dark or back. */
export const onLook = (redraw) => changed.add(redraw);

export const byId = (id) => document.getElementById(id);

/** Return a new element: properties, then children (elements or texts). */
export function element(tag, properties = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (name in made && !name.startsWith("aria")) made[name] = value; else made.setAttribute(name, value);
  }
  made.append(...children);
  return made;
}

/** Return a number with digits that suit its size, a dash if it is none. */
export function shown(value, digits = 3) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  const places = size >= 100 ? 0 : size >= 10 ? 1 : digits;
  return value.toFixed(places).replace("-", "−");
}
