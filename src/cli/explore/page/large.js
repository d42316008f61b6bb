// One picture, large, with its values and what can be done with it.

import { picture } from "./pictures.js";
import { changes, origin, values } from "./values.js";

export class Large {
  /** `on` has what the buttons do, and `command` the command line of a picture. */
  constructor(dialog, pictures, on) {
    this.dialog = dialog;
    this.pictures = pictures;
    this.on = on;
    this.known = new Map();
    this.part = (name) => dialog.querySelector(name);
    for (const [name, act] of [["star", on.star], ["export", on.save], ["copy", on.copy]]) {
      this.part(`.${name}`).onclick = () => act(this.id);
    }
    this.part(".back").onclick = () => this.step(-1);
    this.part(".forth").onclick = () => this.step(1);
    this.part(".close").onclick = () => dialog.close();
    dialog.onclick = (e) => e.target === dialog && dialog.close();
    dialog.onclose = () => {
      this.control?.abort();
      on.closed(this.id);
    };
  }

  get isOpen() {
    return this.dialog.open;
  }

  open(gallery, ids, id) {
    Object.assign(this, { ids, id });
    if (!this.isOpen) this.dialog.showModal();
    this.show(gallery);
    this.draw();
  }

  step(by) {
    const next = this.ids[this.ids.indexOf(this.id) + by];
    if (next !== undefined) this.open(this.gallery, this.ids, next);
  }

  /** Shows what there is to say of it. */
  show(gallery) {
    this.gallery = gallery;
    const { id } = this;
    const about = origin(gallery, id);
    this.part("h2").textContent = about ? `${id}, ${about}` : `Picture ${id}`;
    this.part(".values").replaceChildren(...values(gallery, id));
    this.part(".changes").replaceChildren(...changes(gallery, id));
    const starred = gallery.stars.includes(id);
    this.part(".star").setAttribute("aria-pressed", String(starred));
    this.part(".star").textContent = starred ? "★ Starred" : "☆ Star";
    this.part(".command").textContent = this.on.command(id);
    const at = this.ids.indexOf(id);
    this.part(".back").disabled = at <= 0;
    this.part(".forth").disabled = at < 0 || at === this.ids.length - 1;
  }

  /** Shows the small picture until the large one is there. */
  async draw() {
    const { id } = this;
    this.control?.abort();
    const control = (this.control = new AbortController());
    this.put(this.known.get(id) ?? this.pictures.of(id), !this.known.has(id));
    if (this.known.has(id)) return;
    try {
      this.known.set(id, await picture(`large/${id}.png`, control.signal));
    } catch {
      // Given up, or not connected.
    }
    if (!control.signal.aborted) this.put(this.known.get(id) ?? this.pictures.of(id), false);
  }

  /** A better small picture is there, which will do until the large one is. */
  better(id) {
    if (this.isOpen && id === this.id && this.dialog.dataset.state === "drawing") this.put(this.pictures.of(id), true);
  }

  put({ url, fault }, waits) {
    const image = this.part(".frame img");
    [image.width, image.height] = this.gallery.size;
    image.hidden = !url;
    if (url) image.src = url;
    this.part(".frame .fault").hidden = !fault;
    this.part(".frame .fault").textContent = fault ?? "";
    this.part(".wait").hidden = !waits;
    this.dialog.dataset.state = waits ? "drawing" : "done";
  }
}
