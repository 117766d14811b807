// The values of the form, and what happens when one of them changes.
import {post, Refused} from "/web/api.js";
import {Field} from "/web/form.js";

export class Settings {
  /** `onChecks` gets what the server checked; `tell` gets events. */
  constructor(properties, {tell, onChecks, live}) {
    Object.assign(this, {properties, tell, onChecks, live, running: false, asked: 0});
    this.fields = Object.fromEntries(Object.entries(properties).map(([name, property]) => [name, new Field(name, property, (field) => this.changed(field))]));
  }

  values() { return Object.fromEntries(Object.entries(this.fields).map(([name, field]) => [name, field.read()])); }

  /** Take values as those that count as unchanged. */
  base(values) { for (const [name, field] of Object.entries(this.fields)) if (name in values) field.base(values[name]); }

  /** Write values without sending them, as of a run that goes on. */
  show(values) {
    for (const [name, value] of Object.entries(values)) {
      this.fields[name]?.write(value);
      this.fields[name]?.told?.();
    }
  }

  /** Show what a live session was asked for, by whichever page, where it is another than before. */
  follow(values) {
    const said = JSON.stringify(values);
    if (said !== this.said) this.show(values);
    this.said = said;
  }

  /** Write values and have them checked; in a run those that may change then are sent. */
  async set(values) {
    this.show(values);
    if (this.running) await this.send(Object.fromEntries(Object.entries(values).filter(([name]) => this.fields[name]?.live)));
    await this.check();
  }

  async changed(field) {
    field.mark();
    field.refuse("");
    if (field.name === "scenario" && field.read()) this.fields.log?.write("");
    if (this.running && field.live) await this.send({[field.name]: field.read()});
    await this.check();
  }

  async send(values) {
    await this.attempt(async () => {
      const {applied} = await post("/api/parameters", values);
      for (const [name, value] of Object.entries(applied)) this.fields[name]?.write(value);
    });
  }

  /** Ask the server what it thinks of the values; only the latest answer counts. */
  async check() {
    if (this.live) return;  // nothing is to be started
    const number = this.asked += 1;
    let answer;
    try {
      answer = await post("/api/check", this.values());
    } catch (error) {
      if (!(error instanceof Refused)) throw error;
      const field = this.fields[error.field];
      if (number === this.asked) field?.refuse(error.message);
      answer = {checks: [{name: field?.property.title ?? "settings", ok: false, sentence: error.message}], command: ""};
    }
    if (number !== this.asked) return;
    if (answer.checks.every(({ok}) => ok)) for (const field of Object.values(this.fields)) field.refuse("");
    this.onChecks(answer.checks, answer.command);
  }

  async run() { await this.attempt(() => post("/api/run", this.values())); }

  /** Show a refusal beside the field that it is about, else among the events. */
  async attempt(act) {
    try {
      await act();
    } catch (error) {
      if (!(error instanceof Refused)) throw error;
      const field = this.fields[error.field];
      if (field) field.refuse(error.message);
      this.tell({level: "warn", text: error.message});
    }
  }
}
