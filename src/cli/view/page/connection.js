// The connection: what the program sends, and what the page asks for.
class Connection {
  constructor(onPicture, onState) {
    Object.assign(this, { onPicture, onState, asked: new Map(), socket: null });
    this.open();
  }

  open() {
    this.socket = new WebSocket(`ws://${location.host}/live${location.search}`);
    this.socket.binaryType = "arraybuffer";
    this.socket.onopen = () => this.onState(true);
    this.socket.onmessage = ({ data }) => {
      const length = new DataView(data).getUint32(0, true);
      const about = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 4, length)));
      this.onPicture(about, new Uint8ClampedArray(data, 4 + length));
      this.send("shown");
    };
    this.socket.onclose = () => {
      this.onState(false);
      setTimeout(() => this.open(), 1000);
    };
  }

  send(message) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(message));
  }

  // Asks once per frame of the screen. `merge` joins what was asked before with `value`.
  ask(name, value, merge = (_, next) => next) {
    if (this.asked.size === 0) requestAnimationFrame(() => this.flush());
    this.asked.set(name, this.asked.has(name) ? merge(this.asked.get(name), value) : value);
  }

  flush() {
    for (const [name, value] of this.asked) this.send(Connection.message(name.split("."), value));
    this.asked.clear();
  }

  // `move.pan` with a value is {"move": {"pan": value}}.
  static message(names, value) {
    return names.reduceRight((inner, name) => ({ [name]: inner }), value);
  }
}
