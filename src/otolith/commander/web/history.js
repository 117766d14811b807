// The samples of the last seconds, one typed array per signal, always in one piece.

const KEPT = 60;  // [s]
const ROWS = 65536;  // more than 60 s of 1 kHz samples

export class History {
  constructor(columns) {
    this.columns = columns;
    this.always = Math.max(1, columns.findIndex(({name}) => name === "pose_x"));
    this.clear();
  }

  clear() {
    this.store = this.columns.map(() => new Float32Array(2 * ROWS));
    this.awake = this.columns.map(() => false);  // signals that have ever been a number other than 0
    this.seen = this.columns.map(() => false);  // signals that have ever been a number
    this.first = 0;
    this.end = 0;
  }

  get length() { return this.end - this.first; }
  get last() { return this.length ? this.store[0][this.end - 1] : NaN; }
  get start() { return this.length ? this.store[0][this.first] : NaN; }

  /**
   * Return what of a frame is newer than all that is kept; what is older fills signals that did not come before.
   * A signal that does not come is null.
   */
  newer(signals) {
    const [time] = signals;
    let from = 0;
    if (this.length) while (from < time.length && time[from] <= this.last) from += 1;
    if (!from) return signals;
    signals.forEach((signal, k) => { if (k && signal) this.fill(k, time.subarray(0, from), signal); });
    return signals.map((signal) => signal && signal.subarray(from));
  }

  /** Fill a signal where it is unknown and surge, which always comes, is not: there it is no gap. */
  fill(k, time, signal) {
    const row = this.store[k], times = this.store[0], always = this.store[this.always];
    for (let at = this.first, j = 0; at < this.end; at += 1) {
      if (!Number.isNaN(row[at]) || Number.isNaN(always[at])) continue;
      while (j + 2 < time.length && Math.abs(time[j + 2] - times[at]) <= Math.abs(time[j] - times[at])) j += 2;
      const second = at > this.first && times[at - 1] === times[at] && j + 1 < time.length;
      row[at] = signal[second ? j + 1 : j];
    }
    this.wake([null, ...this.store.slice(1).map((_, n) => (n + 1 === k ? signal : null))]);
  }

  /** Take the names of signals that the server has seen moving; return whether one is new. */
  know(moving) {
    const asleep = (name) => { const k = this.columns.findIndex((one) => one.name === name); return k > 0 && !this.awake[k] ? k : 0; };
    const woken = moving.map(asleep).filter(Boolean);
    for (const k of woken) this.awake[k] = this.seen[k] = true;
    return woken.length > 0;
  }

  /**
   * Append a frame; `signals[0]` is time, null is NaN throughout. A jump in time leaves a row of NaN, so that no curve bridges it.
   * Return whether a signal moves that did not move before.
   */
  append(signals) {
    const rows = signals[0].length;
    if (!rows) return false;
    if (this.length && signals[0][0] > this.last + 0.1) this.mark(signals[0][0]);
    this.make(rows);
    this.store.forEach((row, k) => { if (signals[k]) row.set(signals[k], this.end); else row.fill(NaN, this.end, this.end + rows); });
    this.end += rows;
    const oldest = this.last - KEPT, time = this.store[0];
    while (time[this.first] < oldest || this.length > ROWS) this.first += 1;
    return this.wake(signals);
  }

  wake(signals) {
    let woken = false;
    signals.forEach((signal, k) => {
      if (!signal) return;
      this.seen[k] ||= signal.some(Number.isFinite);
      if (this.awake[k] || !signal.some((value) => value && Number.isFinite(value))) return;
      this.awake[k] = woken = true;
    });
    return woken;
  }

  mark(at) {
    this.make(1);
    this.store.forEach((row, k) => { row[this.end] = k ? NaN : at; });
    this.end += 1;
  }

  /** Make room for some more rows: move what is kept to the front of the store. */
  make(rows) {
    if (this.end + rows <= 2 * ROWS) return;
    for (const row of this.store) row.copyWithin(0, this.first, this.end);
    this.end -= this.first;
    this.first = 0;
  }

  /** Return a view of one signal. */
  view(k) { return this.store[k].subarray(this.first, this.end); }

  /** Return the index of the last row at or before a time [s], within the views. */
  at(time) {
    const t = this.view(0);
    let low = 0, high = t.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (t[middle] <= time) low = middle + 1; else high = middle;
    }
    return low - 1;
  }

  /** Return one signal at a row: the middle of the pair where samples come as least and largest. */
  value(k, row) {
    const x = this.view(k), t = this.view(0);
    const paired = row > 0 && t[row - 1] === t[row];
    return paired ? 0.5 * (x[row] + x[row - 1]) : x[row];
  }
}
