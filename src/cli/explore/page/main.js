// The page: a gallery, with what can be done with its favourites beside it.

import { Grid } from "./grid.js";
import { Large } from "./large.js";
import { Pictures } from "./pictures.js";
import { changes, make, origin, settings, values, word } from "./values.js";

const by = (id) => document.getElementById(id);
/** What makes something of the favourites. */
const MAKERS = ["narrow", "breed", "clear"];
let gallery;
let shown = 0;

const pictures = new Pictures((id) => {
  grid.update(id);
  large.better(id);
  stars();
  status();
});
const grid = new Grid(by("grid"), pictures, { open, star, look });
const large = new Large(by("large"), pictures, {
  star,
  save,
  copy,
  command,
  closed: (id) => grid.focus(id),
});

/** The pictures that are shown. */
const members = () => gallery.generations[shown].members;

/** Whether a picture is of another text than the script has. */
const isChanged = (id) => Boolean(gallery.specimens[id].changes);

function command(id) {
  // What has other expressions is rendered from its own script, with its values as the defaults.
  if (isChanged(id)) return `orogen render ${word(`${gallery.name}-${id}.rhai`)}${gallery.options}`;
  return gallery.command + settings(gallery, id);
}

/** Asks the server for something; what it cannot do is shown. */
async function ask(address, options) {
  try {
    const answer = await fetch(address, options);
    if (answer.ok) return answer;
    const { message, hint } = await answer.json();
    notice(message, hint, true);
  } catch {
    notice("not connected", "is orogen explore still running?", true);
  }
}

/** Has something done, and shows what came of it; whether it was done. */
async function act(command) {
  const answer = await ask("do", {
    method: "POST",
    headers: { "content-type": "application/json" },
    body: JSON.stringify(command),
  });
  if (answer) show(await answer.json());
  return Boolean(answer);
}

/** Makes a generation, and shows it. */
async function begin(command) {
  for (const id of MAKERS) by(id).disabled = true;
  by("drawn").textContent = "making a generation";
  if (await act(command)) turn(gallery.generations.length - 1);
  else show(gallery);
}

function show(news) {
  gallery = news;
  document.title = `${gallery.script} – orogen explore`;
  by("script").textContent = gallery.script;
  grid.show(gallery, members());
  pictures.want([...members(), ...gallery.stars.filter((id) => !members().includes(id))]);
  stars();
  generations();
  status();
  look(grid.here);
  if (large.isOpen) large.show(gallery);
  for (const id of MAKERS) by(id).disabled = gallery.stars.length === 0;
  document.body.dataset.generation = shown;
  document.body.dataset.specimens = gallery.specimens.length;
}

/** Shows another generation. */
function turn(to) {
  if (!gallery.generations[to]) return;
  shown = to;
  by("stage").scrollTop = 0;
  show(gallery);
}

function stars() {
  if (!gallery) return;
  by("none").hidden = gallery.stars.length > 0;
  by("stars").hidden = gallery.stars.length === 0;
  by("stars").replaceChildren(...gallery.stars.map((id) => {
    const button = make("button", "", pictures.of(id).url ? undefined : id);
    button.title = `Picture ${id}`;
    button.setAttribute("aria-label", button.title);
    button.onclick = () => open(id);
    if (pictures.of(id).url) {
      const image = make("img");
      Object.assign(image, { src: pictures.of(id).url, alt: "" });
      button.append(image);
    }
    return button;
  }));
}

function generations() {
  by("generations").replaceChildren(...gallery.generations.map(({ way, from, members }, i) => {
    const button = make("button");
    const how = way === "narrow" ? "narrowed to" : way.evolve === undefined ? "bred from" : "evolved from";
    const made = way === "sample" ? "sample" : `${how} ${from.join(", ")}`;
    button.append(make("span", "", `${i + 1}  ${made}`), make("span", "", members.length));
    button.title = made;
    button.setAttribute("role", "radio");
    button.setAttribute("aria-checked", String(i === shown));
    button.onclick = () => turn(i);
    return button;
  }));
}

function status() {
  if (!gallery) return;
  const all = members();
  const done = all.filter((id) => pictures.isDone(id)).length;
  const rough = all.filter((id) => pictures.of(id).rough).length;
  const failed = all.filter((id) => pictures.of(id).fault).length;
  by("progress").value = done / all.length;
  const count = done === all.length ? `${done} picture${done === 1 ? "" : "s"}` : `${done} of ${all.length} pictures`;
  const notes = [count, failed && `${failed} with errors`, rough && `${rough} rough so far`];
  by("drawn").textContent = notes.filter(Boolean).join(", ");
  document.body.dataset.state = done === all.length ? "done" : "drawing";
}

/** Shows the values of a picture. */
function look(id) {
  const about = origin(gallery, id);
  by("here").hidden = false;
  by("here").querySelector("h2").textContent = about ? `${id}, ${about}` : `Picture ${id}`;
  by("here").querySelector(".values").replaceChildren(...values(gallery, id));
  by("here").querySelector(".changes").replaceChildren(...changes(gallery, id));
}

function open(id) {
  large.open(gallery, members().includes(id) ? members() : gallery.stars, id);
}

function star(id) {
  return act({ star: { id, on: !gallery.stars.includes(id) } });
}

/** Saves the script of a picture. */
async function save(id) {
  const answer = await ask(`script/${id}.rhai`);
  if (!answer) return;
  const link = make("a");
  link.href = URL.createObjectURL(await answer.blob());
  link.download = `${gallery.name}-${id}.rhai`;
  link.click();
  notice(`saved ${link.download}`, gallery.company ? `keep it beside ${gallery.script}: it reads other files there` : "");
}

async function copy(id) {
  try {
    await navigator.clipboard.writeText(command(id));
    notice("copied", isChanged(id) ? `${command(id)} (it needs the saved script)` : command(id));
  } catch {
    // Without a clipboard the text is there to be copied by hand.
    if (!large.isOpen) open(id);
    getSelection().selectAllChildren(by("large").querySelector(".command"));
    notice("the command is selected", "copy it with Ctrl+C");
  }
}

/** Something to say that goes away by itself. */
function notice(message, hint, error) {
  const box = make("div", `message ${error ? "error" : ""}`);
  box.append(make("p", "", message));
  if (hint) box.append(make("p", "hint", hint));
  // A dialog that is open hides all that is not in it.
  (large.isOpen ? by("large") : document.body).append(by("messages"));
  by("messages").append(box);
  setTimeout(() => box.remove(), error ? 9000 : 4000);
}

function strength() {
  by("strength-text").textContent = `${Math.round(100 * by("strength").valueAsNumber)} %`;
}

by("more").onclick = () => act({ more: shown });
by("narrow").onclick = () => begin("narrow");
by("breed").onclick = () => begin({ [by("expressions").checked ? "evolve" : "breed"]: by("strength").valueAsNumber });
by("clear").onclick = () => act("clear");
by("strength").oninput = strength;
by("help").onclick = () => by("keys").showModal();

/** Keys, what they mean, and what they do with the picture in focus. */
const KEYS = [
  ["← → ↑ ↓", "another picture"],
  ["Enter", "open it large"],
  ["S", "star it, or no longer", star],
  ["E", "save its script", save],
  ["C", "copy the command that renders it", copy],
  ["M", "more pictures for this generation", () => by("more").click()],
  ["N", "narrow: a generation from around the favourites", () => by("narrow").click()],
  ["B", "breed: a generation of their children", () => by("breed").click()],
  ["X", "breed the expressions as well, or no longer", () => by("expressions").click()],
  ["[", "the generation before", () => turn(shown - 1)],
  ["]", "the generation after", () => turn(shown + 1)],
  ["?", "these keys", () => by("keys").showModal()],
];
by("keys").querySelector("dl").append(...KEYS.flatMap(([key, meaning]) => [make("dt", "", key), make("dd", "", meaning)]));

addEventListener("keydown", (e) => {
  if (e.ctrlKey || e.metaKey || e.altKey || !gallery || by("keys").open) return;
  const id = large.isOpen ? large.id : grid.here;
  const known = KEYS.find(([key, , does]) => does && key === e.key.toUpperCase());
  if (known) known[2](id);
  else if (e.key === "Enter" && e.target.matches(".specimen")) open(id);
  else if (large.isOpen && e.key === "ArrowLeft") large.step(-1);
  else if (large.isOpen && e.key === "ArrowRight") large.step(1);
  else if (large.isOpen || e.target.matches("input") || !grid.move(e.key)) return;
  e.preventDefault();
});

strength();
const first = await ask("gallery");
if (first) show(await first.json());
