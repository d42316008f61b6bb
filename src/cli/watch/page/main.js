// The page: a picture with controls beside it.

import { Link } from "./link.js";
import { KEYS, Steer } from "./steer.js";
import { Probe } from "./probe.js";
import { LAYERS, Panel, by } from "./panel.js";

const canvas = by("picture");
const brush = canvas.getContext("2d", { alpha: false });
let revision = 0;

const link = new Link({
  connected(yes) {
    by("offline").hidden = yes;
    if (yes) probe.again();
  },
  report(report) {
    if (report.revision !== revision) keep();
    revision = report.revision;
    panel.show(report);
    frame(report);
    document.body.dataset.region = report.region ?? "";
    if (document.body.dataset.stage !== report.stage) probe.refresh();
    document.body.dataset.stage = report.stage;
    document.body.dataset.revision = report.revision;
  },
  notice: (notice) => panel.notice(notice),
  picked: (picked) => probe.show(picked),
  blocks(size, blocks) {
    if (canvas.width !== size[0] || canvas.height !== size[1]) [canvas.width, canvas.height] = size;
    for (const { x, y, image } of blocks) brush.putImageData(image, x, y);
    canvas.dataset.painted = Number(canvas.dataset.painted ?? 0) + 1;
  },
});
const panel = new Panel(link);
const steer = new Steer(canvas, by("frame"), link);
const probe = new Probe(canvas, link);

/** Keeps the picture as it is, to compare the next one with. */
function keep() {
  const before = by("before").querySelector("canvas");
  [before.width, before.height] = [canvas.width, canvas.height];
  before.getContext("2d").drawImage(canvas, 0, 0);
}

/** Shows the region that is worked on first. */
function frame({ region, size }) {
  if (steer.selecting || steer.box) return;
  const [x, y, width, height] = (region ?? []).map((side, i) => side / size[i % 2]);
  steer.show(region && { x, y, width, height });
  by("region").setAttribute("aria-pressed", String(steer.region || Boolean(region)));
}

/** Turns the drawing of rectangles on, or off and the region away. */
function region() {
  steer.region = !(steer.region || panel.report?.region);
  steer.box = null;
  if (steer.region) canvas.focus({ preventScroll: true });
  canvas.classList.toggle("region", steer.region);
  if (!steer.region) {
    steer.show(null);
    link.do({ region: null });
  }
  by("region").setAttribute("aria-pressed", String(steer.region));
}

function compare() {
  const hidden = (by("before").hidden = !by("before").hidden);
  by("now").querySelector("figcaption").hidden = hidden;
  by("compare").setAttribute("aria-pressed", String(!hidden));
}

function fold() {
  const folded = document.body.classList.toggle("folded");
  by("fold").setAttribute("aria-expanded", String(!folded));
  by("fold").textContent = folded ? "☰" : "×";
}

async function copy() {
  const text = panel.report?.camera ?? "";
  try {
    await navigator.clipboard.writeText(text);
    panel.notice({ error: false, message: `copied: ${text}`, hints: [] });
  } catch {
    // Without a clipboard the text is there to be copied by hand.
    getSelection().selectAllChildren(by("camera"));
    panel.notice({ error: false, message: "the camera's text is selected", hints: ["copy it with Ctrl+C"] });
  }
}

by("region").onclick = region;
by("compare").onclick = compare;
by("fold").onclick = fold;
by("copy").onclick = copy;
by("help").onclick = () => by("keys").showModal();
by("keys").querySelector("dl").append(...KEYS.flatMap(([keys, meaning]) => {
  const [dt, dd] = [document.createElement("dt"), document.createElement("dd")];
  [dt.textContent, dd.textContent] = [keys, meaning];
  return [dt, dd];
}));
addEventListener("resize", () => panel.report && frame(panel.report));

const SHORTCUTS = {
  r: () => link.do("snap_back"),
  c: copy,
  f: region,
  b: compare,
  p: fold,
  escape: () => steer.region && region(),
  6: () => by("components").click(),
  "?": () => by("keys").showModal(),
  " ": () => by("play").click(),
};

addEventListener("keydown", (e) => {
  if (e.ctrlKey || e.metaKey || e.altKey || e.target.matches("input, select, textarea")) return;
  if (e.key === " " && e.target.matches("button, a")) return;
  const layer = LAYERS[Number(e.key) - 1];
  if (layer) panel.layer(layer);
  else if (SHORTCUTS[e.key.toLowerCase()]) SHORTCUTS[e.key.toLowerCase()]();
  else return;
  e.preventDefault();
});
