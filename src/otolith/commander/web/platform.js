// The right side: the platform as a picture and in numbers, at the newest sample or under the cursor.
import {get} from "/web/api.js";
import {colour, HexapodView} from "/web/hexapod.js";
import {byId, element, onLook, shown} from "/web/look.js";

const POSE = {x: "surge", y: "sway", z: "heave", roll: "roll", pitch: "pitch", yaw: "yaw"};
const WORDS = {"--fault": "end", "--warn": "near", "--good": ""};

export class Platform {
  constructor() {
    this.view = new HexapodView(byId("hexapod"));
    this.pose = this.table("pose", Object.values(POSE), 2);
    onLook(() => this.view.draw());
  }

  /** Fill a table with rows of a name and a number; return the cells of the numbers. */
  table(id, names, across = 1) {
    const cells = names.map(() => element("td"));
    const body = byId(id).tBodies[0], rows = [];
    for (let k = 0; k < names.length / across; k += 1) {
      const row = [];
      for (let n = k; n < names.length; n += names.length / across) row.push(element("th", {scope: "row"}, names[n]), cells[n]);
      rows.push(element("tr", {}, ...row));
    }
    body.replaceChildren(...rows);
    return cells;
  }

  async describe(columns) {
    this.poses = Object.keys(POSE).map((name) => columns.findIndex((column) => column.name === `pose_${name}`));
    this.legs = [1, 2, 3, 4, 5, 6];
    const geometry = await get("/api/hexapod");
    this.geometry = geometry?.base ? geometry : null;
    byId("legs").hidden = !this.geometry;
    if (this.geometry) this.describeLegs();
    this.view.describe(this.geometry);
  }

  describeLegs() {
    this.meters = this.legs.map((number) => element("meter", {min: 0, max: 1, low: 0.15, high: 0.85, optimum: 0.5, "aria-label": `${this.geometry.cranks ? "crank" : "leg"} ${number}`}));
    const body = byId("legs").tBodies[0];
    this.cells = this.legs.map(() => [element("td"), element("td")]);
    body.replaceChildren(...this.cells.map(([length, use], k) => element("tr", {}, element("th", {scope: "row"}, String(k + 1)), element("td", {className: "wide"}, this.meters[k]), length, use)));
  }

  /** Show a row of the history; `all` also writes the numbers, which change too fast to read 30 times a second. */
  show(history, row, all) {
    const known = this.poses[0] < 0 || Number.isFinite(history.value(this.poses[0], row));
    const pose = this.poses.map((k) => (known && (k < 0 || !history.awake[k]) ? 0 : history.value(k, row)));
    if (pose.every(Number.isFinite)) this.view.draw(pose);
    if (!all) return;
    pose.forEach((value, k) => { this.pose[k].textContent = k < 3 ? `${shown(value)} m` : `${shown(value, 2)}°`; });
    if (!this.geometry) return;
    const [low, high] = this.geometry.stroke, lengths = pose.every(Number.isFinite) ? this.view.lengths() : null;
    this.legs.forEach((_, k) => {
      const share = lengths ? (lengths[k] - low) / (high - low) : NaN;
      this.meters[k].value = lengths ? share : 0;
      this.cells[k][0].textContent = lengths ? (this.geometry.cranks ? `${lengths[k].toFixed(1)}°` : `${lengths[k].toFixed(3)} m`) : "–";
      this.cells[k][1].textContent = lengths ? `${Math.round(100 * share)} % ${WORDS[colour(share)]}` : "–";
    });
  }
}
