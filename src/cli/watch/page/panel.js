// The controls beside the picture, and messages on it.

export const LAYERS = ["light", "normals", "cost", "depth", "albedo"];
const CASTERS = ["auto", "beam", "sphere", "speculative", "segment", "affine", "reduced", "standard", "interval", "octree", "bent"];

export const by = (id) => document.getElementById(id);

/** An element with a class and a text. */
function make(tag, name, text) {
  const element = document.createElement(tag);
  if (name) element.className = name;
  if (text !== undefined) element.textContent = text;
  return element;
}

/** How long reports of older values are passed over, in milliseconds. */
const SETTLING = 1500;

/** A number as people like to read it. */
const short = (value) => String(Number(value.toPrecision(6)));

export class Panel {
  constructor(link) {
    this.link = link;
    this.controls = new Map();
    this.asked = new Map();
    for (const layer of LAYERS) {
      const button = make("button", "", layer);
      button.setAttribute("role", "radio");
      button.dataset.layer = layer;
      button.onclick = () => this.layer(layer);
      by("layers").append(button);
    }
    const components = make("button", "", "components");
    components.id = "components";
    components.title = "Each component of the solid in a colour of its own (6)";
    components.setAttribute("role", "radio");
    components.onclick = () => link.do({ components: true });
    by("layers").append(components);
    for (const caster of CASTERS) by("caster").append(new Option(caster, caster));
    by("caster").onchange = (e) => link.do({ caster: e.target.value });
    by("size").onchange = () => this.resize();
    by("reset").onclick = () => {
      this.asked.clear();
      link.do({ reset: null });
    };
    by("write").onclick = () => link.send("write");
    by("snap").onclick = () => link.do("snap_back");
    by("play").onclick = () => link.do({ play: !this.report?.playing });
    for (const id of ["time", "seconds"]) {
      by(id).oninput = (e) => Number.isFinite(e.target.valueAsNumber) && link.do({ time: e.target.valueAsNumber });
    }
    addEventListener("resize", () => by("size").value === "fit" && this.resize());
  }

  /** Shows a layer, and components as they are. */
  layer(layer) {
    if (this.report?.components) this.link.do({ components: false });
    this.link.do({ layer });
  }

  resize() {
    const chosen = by("size").value;
    const ratio = devicePixelRatio || 1;
    const stage = by("stage");
    const fit = [stage.clientWidth, stage.clientHeight].map((side) => Math.round(side * ratio));
    this.link.do({ size: chosen === "" ? null : chosen === "fit" ? fit : chosen.split("x").map(Number) });
  }

  show(report) {
    this.report = report;
    by("script").textContent = report.script;
    document.title = `${report.script} – orogen`;
    by("progress").value = report.stage === "done" ? 1 : report.progress;
    by("stage-text").textContent = status(report);
    by("camera").textContent = report.camera;
    by("caster").value = report.caster;
    for (const button of by("layers").children) {
      button.setAttribute("aria-checked", String(button.id === "components" ? report.components
        : !report.components && button.dataset.layer === report.layer));
    }
    by("play").setAttribute("aria-pressed", String(report.playing));
    by("play").textContent = report.playing ? "Pause" : "Play";
    by("time").max = String(Math.max(10, Number(by("time").max), Math.ceil(report.time / 10) * 10));
    for (const id of ["time", "seconds"]) {
      if (document.activeElement !== by(id) || report.playing) by(id).value = short(report.time);
    }
    for (const id of ["png", "exr"]) by(id).setAttribute("aria-disabled", String(report.stage !== "done"));
    by("printed").hidden = report.output.length === 0;
    by("printed").querySelector("pre").textContent = report.output.join("\n");
    this.params(report.params);
    this.messages(report.messages);
  }

  params(params) {
    const key = JSON.stringify(params.map(({ name, kind, names }) => [name, kind, names]));
    if (key !== this.key) {
      this.key = key;
      this.controls.clear();
      by("sliders").replaceChildren(...params.map((p) => this.control(p)));
    }
    by("params").hidden = params.length === 0;
    for (const p of params) {
      const { box, inputs } = this.controls.get(p.name);
      const settled = this.settled(p);
      box.classList.toggle("changed", p.value !== p.default);
      for (const input of inputs) {
        if (p.kind === "number") limit(input, p);
        if (settled) put(input, p.value);
      }
    }
  }

  /** Whether a value is no older than what was asked for here. */
  settled({ name, value }) {
    const asked = this.asked.get(name);
    if (asked && asked.value !== value && performance.now() < asked.until) return false;
    this.asked.delete(name);
    return true;
  }

  /** A parameter's name with what turns, picks or switches it, and the way back. */
  control(param) {
    const { name } = param;
    const box = make("div", `param ${param.kind}`);
    const line = make("div", "name");
    const [label, back] = [make("label", "", name), make("button", "back", "↺")];
    const inputs = inputsOf(param);
    label.htmlFor = inputs[0].id = `param-${name}`;
    for (const input of inputs) {
      input.dataset.param = name;
      input.setAttribute("aria-label", name);
      input.oninput = () => {
        const value = valueOf(input);
        if (Number.isNaN(value)) return;
        for (const other of inputs) if (other !== input) put(other, value);
        this.asked.set(name, { value, until: performance.now() + SETTLING });
        this.link.do({ set: { [name]: value } });
      };
    }
    back.title = `${name} as the script has it`;
    back.setAttribute("aria-label", back.title);
    back.onclick = () => {
      // What was asked for before is no longer wanted.
      this.asked.delete(name);
      this.link.do({ reset: [name] });
    };
    line.append(label, back, inputs[0]);
    box.append(line, ...inputs.slice(1));
    this.controls.set(name, { box, inputs });
    return box;
  }

  messages(messages) {
    const key = JSON.stringify(messages);
    if (key === this.shown) return;
    this.shown = key;
    by("messages").querySelectorAll(".said").forEach((old) => old.remove());
    by("messages").append(...messages.map((m) => message(m)));
  }

  /** Something to say that goes away by itself. */
  notice({ error, message: text, hints }) {
    const box = make("div", `message ${error ? "error" : "good"} notice`);
    box.append(make("p", "", text), ...hints.map((hint) => make("p", "hint", hint)));
    by("messages").append(box);
    setTimeout(() => box.remove(), error ? 9000 : 4000);
  }
}

/** What a parameter is set with: a number by two, to type and to turn. */
function inputsOf({ kind, names }) {
  const input = (type) => Object.assign(make("input"), { type });
  switch (kind) {
    case "number": return [input("number"), input("range")];
    case "color": return [input("color")];
    case "switch": return [input("checkbox")];
    default: {
      const select = make("select");
      select.append(...names.map((name) => new Option(name, name)));
      return [select];
    }
  }
}

/** What an input is set to, as the script has it; NaN while it is no number. */
function valueOf(input) {
  if (input.type === "checkbox") return input.checked;
  return input.type === "number" || input.type === "range" ? input.valueAsNumber : input.value;
}

/** Shows a value. */
function put(input, value) {
  if (input.type === "checkbox") input.checked = value;
  else input.value = typeof value === "number" && !Number.isInteger(value) ? short(value) : String(value);
}

/** Gives an input the range of a number. */
function limit(input, { least, most, whole }) {
  const step = whole ? 1 : 10 ** Math.floor(Math.log10((most - least) / 200));
  Object.assign(input, { min: least, max: most, step: input.type === "number" && !whole ? "any" : step || "any" });
}

/** How far the picture is, in words. */
function status(report) {
  const size = report.size.join(" × ");
  switch (report.stage) {
    case "done": return `${size}; recognisable after ${report.first.toFixed(2)} s, done after `
      + `${report.whole.toFixed(2)} s; ${report.cost.toFixed(1)} evaluations a pixel${parts(report)}`;
    case "failed": return "the script has an error; the last good picture stays";
    case "drawing": return report.playing ? `${size}, playing` : `${size}, ${Math.floor(100 * report.progress)} %`;
    default: return "reading the script";
  }
}

/** How many components there are. */
function parts({ parts }) {
  if (!parts) return "";
  const [count, proven] = parts;
  return `; ${count} component${count === 1 ? "" : "s"}${proven ? "" : ", not proven"}`;
}

/** A diagnostic with its line, the meant part of it marked. */
function message({ error, message, label, hints, file, line, column, width, text }) {
  const box = make("div", `message said ${error ? "error" : ""}`);
  box.append(make("p", "", message));
  if (file) box.append(make("p", "where", line ? `${file}, line ${line}${column ? `, column ${column}` : ""}` : file));
  if (text !== null) {
    const code = make("pre");
    const characters = [...text];
    const [start, end] = column ? [column - 1, column - 1 + width] : [0, characters.length];
    code.append(characters.slice(0, start).join(""), make("mark", "", characters.slice(start, end).join("")),
                characters.slice(end).join(""));
    box.append(code);
  }
  if (label) box.append(make("p", "hint", label));
  box.append(...hints.map((hint) => make("p", "hint", hint)));
  return box;
}
