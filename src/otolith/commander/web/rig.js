// A rig from nothing, step by step: the machine first.
import {element} from "/web/look.js";
import {Machine} from "/web/machine.js";

export class Rig {
  constructor(root, {settings, setup, tell, open}) {
    Object.assign(this, {settings, setup, running: false});
    this.machine = new Machine({tell, saved: (name, text) => this.saved(name, text), dropped: (name) => setup.without(name)});
    root.append(element("section", {}, element("h2", {}, "1 Your machine"), this.machine.root));
    document.getElementById("tab-rig").addEventListener("click", () => this.begin(), {once: true});
  }

  /** Ask for what there is when the tab is opened for the first time. */
  async begin() { await this.machine.begin(); }

  /** Offer a saved platform file for runs, and choose it unless one goes on. */
  async saved(name, text) {
    this.setup.platform(name, text);
    if (!this.running) await this.settings.set({platform: name});
  }

  follow({busy}) { this.running = busy; }
}
