// The connection: opens again by itself, and hands over what arrives.

/** Waits between attempts, in milliseconds: soon at first, then patiently. */
const WAITS = [100, 250, 500, 1000, 2000];

export class Link {
  /** Calls `heard.report`, `heard.notice`, `heard.picked`, `heard.blocks` and `heard.connected`. */
  constructor(heard) {
    this.heard = heard;
    this.attempts = 0;
    this.open();
  }

  open() {
    const address = new URL("live", location.href);
    address.protocol = address.protocol.replace("http", "ws");
    this.socket = new WebSocket(address);
    this.socket.binaryType = "arraybuffer";
    this.socket.onopen = () => { this.attempts = 0; this.heard.connected(true); };
    this.socket.onmessage = (event) => this.hear(event.data);
    this.socket.onclose = () => {
      this.heard.connected(false);
      setTimeout(() => this.open(), WAITS[Math.min(this.attempts++, WAITS.length - 1)]);
    };
  }

  hear(data) {
    if (typeof data === "string") {
      const { report, notice, picked } = JSON.parse(data);
      if (report) this.heard.report(report);
      if (notice) this.heard.notice(notice);
      if (picked !== undefined) this.heard.picked(picked);
      return;
    }
    const { tick, size, blocks } = unpack(data);
    this.heard.blocks(size, blocks);
    // The next picture is sent when this one can be seen. A page in the background draws no frames.
    if (document.hidden) this.send({ shown: tick });
    else requestAnimationFrame(() => this.send({ shown: tick }));
  }

  send(message) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(message));
  }

  /** Wants something of the picture. */
  do(command) {
    this.send({ do: command });
  }
}

/** A message with packed blocks. */
function unpack(data) {
  const view = new DataView(data);
  const tick = Number(view.getBigUint64(0, true));
  const size = [view.getUint16(8, true), view.getUint16(10, true)];
  const blocks = [];
  let at = 12;
  while (at < data.byteLength) {
    const [x, y, width, height, side] = [0, 2, 4, 6, 8].map((i) => view.getUint16(at + i, true));
    const across = Math.ceil(width / side);
    const colors = new Uint8Array(data, at + 10, 3 * across * Math.ceil(height / side));
    blocks.push({ x, y, image: image(width, height, side, across, colors) });
    at += 10 + colors.length;
  }
  return { tick, size, blocks };
}

/** The pixels of a block, from the colours of its cells. */
function image(width, height, side, across, colors) {
  const image = new ImageData(width, height);
  for (let y = 0, to = 0; y < height; y++) {
    const row = Math.floor(y / side) * across;
    for (let x = 0; x < width; x++, to += 4) {
      const from = 3 * (row + Math.floor(x / side));
      image.data[to] = colors[from];
      image.data[to + 1] = colors[from + 1];
      image.data[to + 2] = colors[from + 2];
      image.data[to + 3] = 255;
    }
  }
  return image;
}
