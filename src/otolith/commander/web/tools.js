// What stands above the plots: span, hold and replay, more plots, 1 kHz; and Pause in the top bar.
import {post, Refused} from "/web/api.js";
import {byId, element} from "/web/look.js";
import {tellEvent} from "/web/state.js";

export class Tools {
  constructor(page) {
    Object.assign(this, {page, time: null});  // the time [s] that is held, or null
    const {plots} = page;
    plots.addEventListener("moved", () => { page.dirty = true; });
    plots.addEventListener("point", ({detail}) => { page.cursor = detail; page.dirty = true; });
    plots.addEventListener("changed", () => this.offer());
    byId("add").addEventListener("change", ({target}) => { if (target.value) plots.add(target.value); });
    byId("span").addEventListener("change", ({target}) => { plots.span = Number(target.value); this.hold(false); });
    byId("raw").addEventListener("change", ({target}) => this.raw(target));
    byId("hold").addEventListener("click", () => this.hold(this.time === null));
    byId("scrub").addEventListener("input", ({target}) => this.seek(Number(target.value)));
    byId("pause").addEventListener("click", ({target}) => this.pause(target.dataset.word));
  }

  /** Ask for every sample; the server ends this by itself after 10 s. */
  raw(box) {
    this.page.stream.want(box.checked ? "raw" : "envelope");
    clearTimeout(this.rawEnds);
    if (box.checked) this.rawEnds = setTimeout(() => { box.checked = false; this.raw(box); }, 10000);
  }

  /** List the plots that can be added. */
  offer() {
    const {plots} = this.page, closed = plots.all.filter(({title}) => !plots.open.has(title));
    byId("add").replaceChildren(element("option", {value: ""}, "a plot …"), ...closed.map(({title}) => element("option", {value: title}, title)));
    this.page.dirty = true;
  }

  /** Hold the picture, so that the slider replays what is kept, or follow the run again. */
  hold(held) {
    const {history, plots} = this.page, scrub = byId("scrub");
    byId("hold").setAttribute("aria-pressed", String(held));
    scrub.disabled = !held;
    plots.fixed = held ? plots.range() : null;
    this.time = plots.held = held ? history.last || 0 : null;
    if (held) {
      Object.assign(scrub, {min: history.start || 0, max: this.time || 1});
      scrub.value = this.time;
    }
    this.page.dirty = true;
  }

  seek(time) {
    const {plots} = this.page, [low, high] = plots.range(), span = high - low;
    this.time = plots.held = time;
    if (time < low) plots.fixed = [time, time + span];
    if (time > high) plots.fixed = [time - span, time];
    this.page.dirty = true;
  }

  follow({busy, state}, mode) {
    const paused = /pause/i.test(state), button = byId("pause");
    button.hidden = mode !== "offline" || !(busy && /running|paused/.test(state));
    button.textContent = paused ? "Resume" : "Pause";
    button.dataset.word = paused ? "resume" : "pause";
  }

  async pause(word) {
    try {
      await post("/api/word", {word});
    } catch (error) {
      if (!(error instanceof Refused)) throw error;
      tellEvent({level: "warn", text: error.message});
    }
  }
}
