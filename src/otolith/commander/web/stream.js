// The websocket: decodes frames, answers each one, and comes back by itself when the line breaks.
import {AT, HEADER_BYTES, MAGIC, PROTOCOL, VERSION} from "/web/frames.js";

const PAUSES = [0.5, 1, 2, 4];  // [s] before another attempt

/** Return a frame; `signals[k]` is a view of column k, not a copy. */
export function decode(buffer) {
  const head = new DataView(buffer);
  const number = (at, bits) => head[`getUint${bits}`](at, true);
  const magic = String.fromCharCode(...new Uint8Array(buffer, 0, MAGIC.length));
  if (magic !== MAGIC || number(AT.version, 16) !== VERSION) {
    throw new Error("a frame of another version arrived: load this page again");
  }
  const rows = number(AT.rows, 32), columns = number(AT.columns, 16);
  if (buffer.byteLength !== HEADER_BYTES + 4 * rows * columns) throw new Error("a frame of the wrong length arrived");
  const signals = [];
  for (let k = 0; k < columns; k += 1) signals.push(new Float32Array(buffer, HEADER_BYTES + 4 * rows * k, rows));
  return {
    kind: number(AT.kind, 16), sequence: number(AT.sequence, 32), age: head.getFloat64(AT.age, true), rows, signals,
  };
}

/** Events: "frame" (a decoded frame), one per kind of text message, "open", "closed" (seconds to the next attempt). */
export class Stream extends EventTarget {
  constructor() {
    super();
    this.attempts = 0;
    this.heard = performance.now();  // when the last message came [ms]
    this.wanted = "envelope";
    this.open();
  }

  get connected() { return this.socket.readyState === WebSocket.OPEN; }

  open() {
    const scheme = location.protocol === "https:" ? "wss:" : "ws:";
    this.socket = new WebSocket(`${scheme}//${location.host}/stream`, PROTOCOL);
    this.socket.binaryType = "arraybuffer";
    this.socket.addEventListener("open", () => {
      this.attempts = 0;
      this.send({want: this.wanted});
      this.tell("open");
    });
    this.socket.addEventListener("message", ({data}) => this.hear(data));
    this.socket.addEventListener("close", () => {
      const pause = PAUSES[Math.min(this.attempts, PAUSES.length - 1)];
      this.attempts += 1;
      this.tell("closed", pause);
      setTimeout(() => this.open(), 1000 * pause);
    });
  }

  hear(data) {
    if (typeof data === "string") {
      const message = JSON.parse(data);
      this.tell(message.kind, message);
    } else {
      const frame = decode(data);
      this.heard = performance.now();
      this.tell("frame", frame);
    }
  }

  tell(kind, detail) { this.dispatchEvent(new CustomEvent(kind, {detail})); }

  /** Send a message if the line is open; return whether it was. */
  send(message) {
    if (this.connected) this.socket.send(JSON.stringify(message));
    return this.connected;
  }

  /** Tell the server that a frame was drawn or dropped: it sends no more than three ahead. */
  acknowledge(sequence) { this.send({ack: sequence}); }

  /** Ask for "envelope" or "raw" samples, also after the line breaks. */
  want(kind) {
    this.wanted = kind;
    this.send({want: kind});
  }

  /** Ask for columns by their names; the schema comes again, and what is kept of the past. */
  choose(columns) { this.send({want: this.wanted, columns}); }
}
