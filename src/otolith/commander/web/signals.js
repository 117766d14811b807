// Which signals the page needs, and what comes of them: only those on screen are asked for.
const PAUSE = 200;  // [ms] before a new choice is sent, so that several changes are one
const ALWAYS = ["time", "pose_x"];  // the second says where nothing is known: it is NaN in gaps alone
const SHOWN = /^(pose|wanted|felt|felt2)_|^(step_us|changes|residual)$/;  // by platform, errors and effort

export class Signals {
  constructor(stream) {
    Object.assign(this, {stream, offered: [], came: [], asked: ""});
  }

  /** Take a schema: what there is, and what comes, in its order. */
  describe({offered, columns}) {
    this.offered = offered;
    this.came = columns.map(({name}) => offered.findIndex((one) => one.name === name));
    this.asked = columns.map(({name}) => name).join();
  }

  /** Ask for the signals of open plots (their columns) and of all that is always shown, if they move. */
  ask(plotted, awake) {
    const open = new Set(plotted.map(({name}) => name));
    const names = this.offered.filter(({name}, k) => ALWAYS.includes(name) || open.has(name) || (awake[k] && SHOWN.test(name))).map(({name}) => name);
    clearTimeout(this.timer);
    if (!names.length || names.join() === this.asked) return;
    this.timer = setTimeout(() => {
      this.asked = names.join();
      this.stream.choose(names);
    }, PAUSE);
  }

  /** Return all signals of a frame; null is one that does not come. */
  spread(signals) {
    const all = this.offered.map(() => null);
    this.came.forEach((k, n) => { all[k] = signals[n]; });
    return all;
  }
}
