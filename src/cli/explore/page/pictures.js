// Pictures, fetched a few at a time: those in sight first, and then the others from the top. Of those in sight all are
// rough before one is finished. The server draws what is asked for and gives up what nobody waits for, so the order here
// is the order of the work.

/** Requests at a time. The server draws two, of those that wait the last one first: so no more than one may wait. */
const AT_A_TIME = 3;

export class Pictures {
  /** `changed` is called with the number of a picture whose state is new. */
  constructor(changed) {
    this.changed = changed;
    this.known = new Map();
    this.running = new Map();
    this.wanted = [];
    this.seen = new Set();
  }

  /** What is known of a picture: its `url` and whether that is `rough`, its `fault`, or nothing. */
  of(id) {
    return this.known.get(id) ?? {};
  }

  /** Whether there is nothing better to come. */
  isDone(id) {
    const { url, rough, fault } = this.of(id);
    return Boolean(fault || (url && !rough));
  }

  isRunning(id) {
    return this.running.has(id);
  }

  /** These are wanted, in this order; what else is under way is given up. */
  want(ids) {
    this.wanted = ids;
    for (const [id, control] of this.running) if (!ids.includes(id)) control.abort();
    this.next();
  }

  /** A picture came into sight, or left it. */
  sight(id, isSeen) {
    if (isSeen) this.seen.add(id);
    else this.seen.delete(id);
    this.next();
  }

  next() {
    const rank = (id) => 2 * !this.seen.has(id) + this.known.has(id);
    const waiting = this.wanted.filter((id) => !this.isDone(id) && !this.running.has(id));
    waiting.sort((a, b) => rank(a) - rank(b));
    const free = AT_A_TIME - this.running.size;
    // What is out of sight makes room.
    const hidden = [...this.running].filter(([id]) => !this.seen.has(id));
    const first = waiting.filter((id) => this.seen.has(id));
    hidden.slice(0, Math.max(0, first.length - free)).forEach(([, control]) => control.abort());
    for (const id of waiting.slice(0, free)) this.fetch(id);
  }

  async fetch(id) {
    const control = new AbortController();
    const before = this.known.get(id);
    this.running.set(id, control);
    this.changed(id);
    try {
      this.known.set(id, await picture(`${before ? "thumb" : "rough"}/${id}.png`, control.signal));
      if (before) URL.revokeObjectURL(before.url);
    } catch {
      // Given up, or not connected: asked for again if it is wanted again.
      if (!control.signal.aborted) await new Promise((later) => setTimeout(later, 1000));
    }
    this.running.delete(id);
    this.changed(id);
    this.next();
  }
}

/** A picture of the server: its `url` and whether that is `rough`, or the `fault` for which there is none. */
export async function picture(address, signal) {
  const answer = await fetch(address, { signal });
  const rough = answer.headers.get("picture") === "rough";
  if (answer.ok) return { url: URL.createObjectURL(await answer.blob()), rough };
  const { message, hint } = await answer.json();
  return { fault: hint ? `${message} (${hint})` : message };
}
