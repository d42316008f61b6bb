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

/** Where a value is in its range, from 0 to 1. */
function place({ least, most, logarithmic }, value) {
  return logarithmic ? Math.log(value / least) / Math.log(most / least) : (value / 2 - least / 2) / (most / 2 - least / 2);
}

/** A mark on the track of an axis. */
function mark(axis, value, name) {
  const dot = make("i", name);
  dot.style.left = `${100 * place(axis, value)}%`;
  return dot;
}

/** All values of a specimen: a track for each, with the script's own value and those of the favourites. */
export function values({ axes, specimens, stars }, id) {
  return axes.map((axis, i) => {
    const value = specimens[id].values[i];
    const box = make("div", `value ${value === axis.default ? "" : "changed"}`);
    const name = make("div", "name");
    name.append(make("span", "", axis.name), make("span", "number", short(value)));
    const track = make("div", "track");
    track.title = `from ${short(axis.least)} to ${short(axis.most)}; the script has ${short(axis.default)}`;
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

/** A specimen for those who cannot see it. */
export function spoken({ axes, specimens, stars }, id) {
  const list = axes.map((axis, i) => `${axis.name} ${short(specimens[id].values[i])}`);
  return `Picture ${id}${stars.includes(id) ? ", favourite" : ""}: ${list.join(", ")}`;
}

/** The options of the command line that a specimen is rendered with, where it differs from the script. */
export function settings({ axes, specimens }, id) {
  const changed = axes.map((axis, i) => [axis, specimens[id].values[i]]).filter(([axis, value]) => value !== axis.default);
  return changed.map(([{ name }, value]) => ` --set ${name}=${value}`).join("");
}
