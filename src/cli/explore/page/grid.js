// The pictures of a generation, side by side.

import { make, novelty, origin, spoken } from "./values.js";

export class Grid {
  /** `on` has what happens when a picture is opened, starred or looked at. */
  constructor(element, pictures, on) {
    this.element = element;
    this.pictures = pictures;
    this.on = on;
    this.figures = new Map();
    this.sight = new IntersectionObserver((entries) => {
      for (const { target, isIntersecting } of entries) pictures.sight(Number(target.dataset.id), isIntersecting);
    }, { rootMargin: "200px" });
  }

  /** Shows these specimens. */
  show(gallery, ids) {
    this.gallery = gallery;
    this.ids = ids;
    for (const [id, figure] of this.figures) {
      if (ids.includes(id)) continue;
      this.sight.unobserve(figure);
      this.pictures.sight(id, false);
      figure.remove();
      this.figures.delete(id);
    }
    for (const id of ids) {
      if (!this.figures.has(id)) this.add(id);
      this.update(id);
    }
    if (!ids.includes(this.here)) this.here = ids[0];
    this.rove();
  }

  add(id) {
    const figure = make("figure", "specimen");
    figure.dataset.id = id;
    figure.setAttribute("role", "group");
    const [frame, image, fault, star] = [make("div", "picture"), make("img"), make("p", "fault"), make("button", "star")];
    [image.width, image.height] = this.gallery.size;
    frame.style.aspectRatio = this.gallery.size.join(" / ");
    image.alt = "";
    fault.hidden = true;
    star.tabIndex = -1;
    frame.append(image, fault);
    const caption = make("figcaption");
    caption.append(make("b", "", id), make("span", "", origin(this.gallery, id)));
    figure.append(frame, star, caption);
    const news = novelty(this.gallery, id);
    if (news) {
      const line = make("p", "novelty", news);
      line.title = news;
      figure.append(line);
    }
    frame.onclick = () => this.on.open(id);
    star.onclick = () => this.on.star(id);
    figure.onfocus = () => this.look(id);
    figure.onpointerenter = () => this.on.look(id);
    figure.onpointerleave = () => this.on.look(this.here);
    this.figures.set(id, figure);
    this.element.append(figure);
    this.sight.observe(figure);
  }

  /** Shows what is known of a picture by now. */
  update(id) {
    const figure = this.figures.get(id);
    if (!figure) return;
    const { url, rough, fault } = this.pictures.of(id);
    const image = figure.querySelector("img");
    if (url && image.src !== url) image.src = url;
    figure.querySelector(".fault").hidden = !fault;
    figure.querySelector(".fault").textContent = fault ?? "";
    figure.classList.toggle("rough", Boolean(url && rough));
    figure.classList.toggle("drawn", Boolean(url && !rough));
    figure.classList.toggle("failed", Boolean(fault));
    figure.classList.toggle("drawing", this.pictures.isRunning(id));
    figure.setAttribute("aria-busy", String(!this.pictures.isDone(id)));
    const starred = this.gallery.stars.includes(id);
    figure.classList.toggle("starred", starred);
    const star = figure.querySelector(".star");
    star.setAttribute("aria-pressed", String(starred));
    star.textContent = starred ? "★" : "☆";
    star.title = starred ? "No longer a favourite (S)" : "Favourite (S)";
    star.setAttribute("aria-label", star.title);
    figure.setAttribute("aria-label", spoken(this.gallery, id) + (rough ? ", rough so far" : ""));
  }

  look(id) {
    this.here = id;
    this.rove();
    this.on.look(id);
  }

  /** One picture can be reached by the tabulator key; arrows reach the others. */
  rove() {
    for (const [id, figure] of this.figures) figure.tabIndex = id === this.here ? 0 : -1;
  }

  focus(id) {
    this.figures.get(id)?.focus();
  }

  /** Moves the focus as a key says; whether it does. */
  move(key) {
    const at = this.ids.indexOf(this.here);
    const columns = getComputedStyle(this.element).gridTemplateColumns.split(" ").length;
    const steps = { ArrowLeft: -1, ArrowRight: 1, ArrowUp: -columns, ArrowDown: columns, Home: -at, End: this.ids.length - 1 - at };
    if (!(key in steps)) return false;
    // The first key only shows where the focus is.
    const isThere = document.activeElement === this.figures.get(this.here);
    this.focus(isThere ? (this.ids[at + steps[key]] ?? this.here) : this.here);
    return true;
  }
}
