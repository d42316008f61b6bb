// Mouse, touch and keys on the picture.

/** Keys and what they do, for the list of keys. */
export const KEYS = [
  ["arrows, drag", "turn around the target"],
  ["shift + arrows, right drag, two fingers", "pan"],
  ["+ −, wheel, pinch", "zoom towards the pointer"],
  ["W A S D, Q E", "walk: ahead, aside, down and up"],
  ["alt + drag", "look around"],
  ["R", "snap back to the script's camera"],
  ["C", "copy the camera as script text"],
  ["F", "region first: drag a rectangle, or move it with arrows, size it with shift + arrows, enter; again for none"],
  ["I", "what is in the middle; elsewhere point at it, or tap"],
  ["B", "before and after the last save"],
  ["1 … 6", "light, normals, cost, depth, albedo, components"],
  ["space", "play and pause"],
  ["P", "fold the controls"],
  ["?", "this list"],
];

/** Share of the picture's height that an arrow key turns or pans. */
const STEP = 0.03;

/** Steps of a walk in a second, while a key is held. */
const PACE = 8;

export class Steer {
  constructor(canvas, frame, link) {
    Object.assign(this, { canvas, frame, link, pointers: new Map(), region: false, held: new Set() });
    this.pending = this.box = null;
    canvas.addEventListener("pointerdown", (e) => this.down(e));
    canvas.addEventListener("pointermove", (e) => this.drag(e));
    canvas.addEventListener("pointerup", (e) => this.up(e));
    canvas.addEventListener("pointercancel", (e) => this.cancel(e));
    canvas.addEventListener("contextmenu", (e) => e.preventDefault());
    canvas.addEventListener("wheel", (e) => this.wheel(e), { passive: false });
    canvas.addEventListener("keydown", (e) => this.key(e));
    canvas.addEventListener("keyup", (e) => this.held.delete(e.key.toLowerCase()));
    canvas.addEventListener("blur", () => this.held.clear());
  }

  /** A place as shares of width and height. */
  place(e) {
    const box = this.canvas.getBoundingClientRect();
    return [(e.clientX - box.left) / box.width, (e.clientY - box.top) / box.height];
  }

  /** A way in heights of the picture. */
  way(dx, dy) {
    const { height } = this.canvas.getBoundingClientRect();
    return [dx / height, dy / height];
  }

  /** Sends movements once a frame; those of one kind in a row become one. */
  move(move) {
    const kind = Object.keys(move)[0];
    const last = this.pending && Object.keys(this.pending)[0];
    if (last && last !== kind) this.flush();
    if (!this.pending) {
      this.pending = move;
      requestAnimationFrame(() => this.flush());
      return;
    }
    const [old, add] = [this.pending[kind], move[kind]];
    if (kind === "zoom") Object.assign(old, { by: old.by * add.by, at: add.at });
    else if (kind === "pan") old.by = old.by.map((c, i) => c + add.by[i]);
    else this.pending[kind] = old.map((c, i) => c + add[i]);
  }

  flush() {
    if (this.pending) this.link.do({ move: this.pending });
    this.pending = null;
  }

  down(e) {
    if (this.selecting) return;
    this.canvas.focus({ preventScroll: true });
    this.canvas.setPointerCapture(e.pointerId);
    this.pointers.set(e.pointerId, { x: e.clientX, y: e.clientY });
    this.start = { at: this.place(e), button: e.button };
    this.selecting = (this.region || e.ctrlKey || e.metaKey) && e.button === 0;
    e.preventDefault();
  }

  drag(e) {
    const last = this.pointers.get(e.pointerId);
    if (!last) return;
    const others = [...this.pointers].filter(([id]) => id !== e.pointerId);
    const by = this.way(e.clientX - last.x, e.clientY - last.y);
    if (this.selecting) this.show(this.rectangle(e));
    else if (others.length > 0) this.pinch(e, last, others[0][1], by);
    else if (this.start.button === 2 || this.start.button === 1 || e.shiftKey) {
      this.move({ pan: { by, at: this.start.at } });
    } else this.move(e.altKey ? { look: by } : { orbit: by });
    this.pointers.set(e.pointerId, { x: e.clientX, y: e.clientY });
  }

  /** Two fingers: their distance zooms, their middle pans. */
  pinch(e, last, other, by) {
    const distance = (p) => Math.hypot(p.x - other.x, p.y - other.y);
    const at = this.place({ clientX: (e.clientX + other.x) / 2, clientY: (e.clientY + other.y) / 2 });
    const now = distance({ x: e.clientX, y: e.clientY });
    this.move({ pan: { by: by.map((c) => c / 2), at } });
    if (now > 0) this.move({ zoom: { by: distance(last) / now, at } });
  }

  up(e) {
    this.pointers.delete(e.pointerId);
    if (this.selecting) this.choose(this.rectangle(e));
  }

  /** Asks for a rectangle to be worked on first. */
  choose({ x, y, width, height }) {
    this.selecting = this.region = false;
    this.box = null;
    this.canvas.classList.remove("region");
    const pixels = [this.canvas.width, this.canvas.height, this.canvas.width, this.canvas.height];
    const region = [x, y, width, height].map((share, i) => Math.round(share * pixels[i]));
    this.link.do({ region: region[2] > 4 && region[3] > 4 ? region : null });
  }

  cancel(e) {
    this.pointers.delete(e.pointerId);
    this.selecting = false;
    this.show(null);
  }

  /** From where the drag began to the pointer, within the picture. */
  rectangle(e) {
    const inside = (p) => p.map((c) => Math.min(Math.max(c, 0), 1));
    const [a, b] = [inside(this.start.at), inside(this.place(e))];
    const [x, y] = a.map((c, i) => Math.min(c, b[i]));
    return { x, y, width: Math.abs(a[0] - b[0]), height: Math.abs(a[1] - b[1]) };
  }

  /** A rectangle by keys: an arrow moves it, or its lower right corner. */
  shape([dx, dy], sized) {
    const box = (this.box ??= { x: 0.25, y: 0.25, width: 0.5, height: 0.5 });
    const within = (c, least, most) => Math.min(Math.max(c, least), most);
    if (sized) {
      box.width = within(box.width + STEP * dx, STEP, 1 - box.x);
      box.height = within(box.height + STEP * dy, STEP, 1 - box.y);
    } else {
      box.x = within(box.x + STEP * dx, 0, 1 - box.width);
      box.y = within(box.y + STEP * dy, 0, 1 - box.height);
    }
    this.show(box);
  }

  /** Shows the frame of a rectangle, given as shares, or none. */
  show(rectangle) {
    this.frame.hidden = !rectangle;
    if (!rectangle) return;
    const { offsetLeft, offsetTop, clientWidth, clientHeight } = this.canvas;
    this.frame.style.left = `${offsetLeft + rectangle.x * clientWidth}px`;
    this.frame.style.top = `${offsetTop + rectangle.y * clientHeight}px`;
    this.frame.style.width = `${rectangle.width * clientWidth}px`;
    this.frame.style.height = `${rectangle.height * clientHeight}px`;
  }

  wheel(e) {
    e.preventDefault();
    const lines = e.deltaMode === 1 ? 16 : 1;
    this.move({ zoom: { by: Math.exp(0.0016 * lines * Math.max(-300, Math.min(300, e.deltaY))), at: this.place(e) } });
  }

  key(e) {
    if (e.ctrlKey || e.metaKey || e.altKey) return;
    const key = e.key.toLowerCase();
    const arrow = { arrowleft: [-1, 0], arrowright: [1, 0], arrowup: [0, -1], arrowdown: [0, 1] }[key];
    if (arrow && this.region) this.shape(arrow, e.shiftKey);
    else if (key === "enter" && this.box) this.choose(this.box);
    else if (arrow) {
      const by = arrow.map((c) => STEP * c);
      this.move(e.shiftKey ? { pan: { by: by.map((c) => -c), at: null } } : { orbit: by });
    } else if (key === "+" || key === "=") this.move({ zoom: { by: 0.9, at: null } });
    else if (key === "-" || key === "_") this.move({ zoom: { by: 1 / 0.9, at: null } });
    else if ("wasdqe".includes(key) && key.length === 1) this.hold(key);
    else return;
    e.preventDefault();
  }

  /** Walks as long as keys are held. */
  hold(key) {
    const walking = this.held.size > 0;
    this.held.add(key);
    if (walking) return;
    let last = performance.now();
    const step = (now) => {
      if (this.held.size === 0) return;
      const way = { w: [0, 0, 1], s: [0, 0, -1], a: [-1, 0, 0], d: [1, 0, 0], q: [0, -1, 0], e: [0, 1, 0] };
      const pace = PACE * Math.max(0.016, Math.min(0.1, (now - last) / 1000));
      const sum = [...this.held].reduce((sum, key) => sum.map((c, i) => c + pace * way[key][i]), [0, 0, 0]);
      last = now;
      this.move({ walk: sum });
      requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }
}
