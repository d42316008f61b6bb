// What is under the pointer.

import { by } from "./panel.js";

export class Probe {
  constructor(canvas, link) {
    Object.assign(this, { canvas, link, asking: false });
    canvas.addEventListener("pointermove", (e) => e.buttons === 0 && this.point(e));
    canvas.addEventListener("click", (e) => this.point(e));
    canvas.addEventListener("keydown", (e) => e.key === "i" && this.middle());
  }

  /** One question at a time; the latest place is asked about next. */
  point(e) {
    const box = this.canvas.getBoundingClientRect();
    this.next = [(e.clientX - box.left) / box.width, (e.clientY - box.top) / box.height];
    this.ask();
  }

  middle() {
    this.next = [0.5, 0.5];
    this.ask();
  }

  ask() {
    if (this.asking || !this.next) return;
    this.asking = true;
    this.link.send({ pick: this.next });
    [this.last, this.next] = [this.next, null];
  }

  /** A new connection answers no old questions. */
  again() {
    this.asking = false;
    this.ask();
  }

  /** Another picture: what is at the place that was asked about last? */
  refresh() {
    this.next ??= this.last;
    this.ask();
  }

  show(picked) {
    this.asking = false;
    by("probe").hidden = false;
    const rows = picked?.hit ? facts(picked.hit, picked.certified) : [["", "nothing but sky"]];
    by("probe").querySelector("dl").replaceChildren(...rows.flatMap(([name, value]) => {
      const [dt, dd] = [document.createElement("dt"), document.createElement("dd")];
      [dt.textContent, dd.textContent] = [name, value];
      return [dt, dd];
    }));
    this.ask();
  }
}

const short = (value) => (value === null ? "none" : String(Number(value.toPrecision(5))));
const vector = (v) => (v === null ? "none" : v.map(short).join(", "));

/** Names and values of what is known of a point. */
function facts({ point, value, gradient, distance, footprint, color, component, dominant }, certified) {
  const rows = [
    ["point", vector(point)],
    ["distance", `${short(distance)}${certified ? "" : ", not proven"}`],
    ["value", short(value)],
    ["gradient", vector(gradient)],
    ["pixel", short(footprint)],
  ];
  if (color) rows.push(["colour", vector(color)]);
  if (component !== null) rows.push(["component", String(component)]);
  if (dominant) {
    const { share, file, line, text } = dominant;
    rows.push([`${Math.round(100 * share)} %`, `${file ? `${file}, ` : ""}line ${line}: ${text}`]);
  }
  return rows;
}
