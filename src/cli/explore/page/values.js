// What the values of a picture are, and where in their ranges.

/** An element with a class and a text. */
export function make(tag, name, text) {
  const element = document.createElement(tag);
  if (name) element.className = name;
  if (text !== undefined) element.textContent = text;
  return element;
}

/** A number as people like to read it. */
const short = (value) => String(Number(value.toPrecision(6)));

/** A value as it is written. */
const said = (value) => (typeof value === "number" ? short(value) : String(value));

/** Where a value is among all that there are, from 0 to 1. */
function place({ kind, least, most, logarithmic, names }, value) {
  if (kind === "switch") return value ? 0.75 : 0.25;
  if (kind === "choice") return (names.indexOf(value) + 0.5) / names.length;
  return logarithmic ? Math.log(value / least) / Math.log(most / least) : (value / 2 - least / 2) / (most / 2 - least / 2);
}

/** A mark on the track of an axis; colours stand side by side. */
function mark(axis, value, name) {
  const dot = make("i", name);
  if (axis.kind === "color") dot.style.background = value;
  else dot.style.left = `${100 * place(axis, value)}%`;
  return dot;
}

/** What values an axis has. */
function reach({ kind, least, most, names }) {
  if (kind === "number") return `from ${short(least)} to ${short(most)}`;
  return kind === "choice" ? names.join(", ") : kind === "switch" ? "true or false" : "a colour";
}

/** All values of a specimen: a track for each, with the script's own value and those of the favourites. */
export function values({ axes, specimens, stars }, id) {
  return axes.map((axis, i) => {
    const value = specimens[id].values[i];
    const box = make("div", `value ${value === axis.default ? "" : "changed"}`);
    const name = make("div", "name");
    name.append(make("span", "", axis.name), make("span", "number", said(value)));
    const track = make("div", axis.kind === "color" ? "track colors" : "track");
    track.title = `${reach(axis)}; the script has ${said(axis.default)}`;
    track.append(mark(axis, axis.default, "script"),
                 ...stars.map((star) => mark(axis, specimens[star].values[i], "favourite")), mark(axis, value, "this"));
    box.append(name, track);
    return box;
  });
}

/** What a specimen is, in a few words. */
export function origin({ specimens, generations }, id) {
  const { parents, generation } = specimens[id];
  if (id === 0) return "the script as it is";
  if (parents.length > 1) return `${parents[0]} × ${parents[1]}`;
  if (parents.length === 1) return `from ${parents[0]}`;
  return generations[generation].way === "narrow" ? "narrowed" : "";
}

/** The last change of the expressions of a specimen, in a few words; none where they are the script's. */
export function novelty({ specimens }, id) {
  const last = specimens[id].changes?.at(-1);
  return last ? `${last.what}, line ${last.line}` : "";
}

/** All changes of the expressions of a specimen, with the lines as they were and became. */
export function changes({ specimens }, id) {
  return (specimens[id].changes ?? []).map(({ line, what, before, after }) => {
    const box = make("div", "change");
    box.append(make("p", "", `${what}, line ${line}`), make("del", "", before), make("ins", "", after));
    return box;
  });
}

/** A specimen for those who cannot see it. */
export function spoken({ axes, specimens, stars }, id) {
  const list = axes.map((axis, i) => `${axis.name} ${said(specimens[id].values[i])}`);
  const news = novelty({ specimens }, id);
  return `Picture ${id}${stars.includes(id) ? ", favourite" : ""}: ${list.join(", ")}${news && `; ${news}`}`;
}

/** A value as it can be typed into a shell. */
export function word(value) {
  const text = String(value);
  return /^[\p{L}\p{N}./_+,#\\:-]*$/u.test(text) ? text : `'${text.replaceAll("'", "'\\''")}'`;
}

/** The options of the command line that a specimen is rendered with, where it differs from the script. */
export function settings({ axes, specimens }, id) {
  const changed = axes.map((axis, i) => [axis, specimens[id].values[i]]).filter(([axis, value]) => value !== axis.default);
  return changed.map(([{ name }, value]) => ` --set ${name}=${word(value)}`).join("");
}
