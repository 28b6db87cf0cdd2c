// The socket to the viewer: it opens again by itself when it is cut.

const FIRST_PAUSE = 250;
const LONGEST_PAUSE = 4000;
// Lost attempts after which the person learns that the viewer has probably ended.
const PATIENCE = 6;

/**
 * Calls `handlers.open()` when requests can be sent, `handlers.event(event)` and
 * `handlers.frame(header, bytes)` for what comes, and `handlers.lost(sentence)` when it was cut.
 */
export class Connection {
  #socket = null;
  #pause = FIRST_PAUSE;
  #attempts = 0;
  #timer = 0;

  constructor(handlers) {
    this.handlers = handlers;
    // Do not wait when there is reason to hope.
    for (const [target, name] of [[window, "online"], [document, "visibilitychange"]]) {
      target.addEventListener(name, () => this.#timer && this.#connect());
    }
    this.#connect();
  }

  get isOpen() {
    return this.#socket?.readyState === WebSocket.OPEN;
  }

  /** Sends a request; without a connection it is dropped, since the state is sent on opening. */
  send(request) {
    if (this.isOpen) this.#socket.send(JSON.stringify(request));
  }

  #connect() {
    clearTimeout(this.#timer);
    this.#timer = 0;
    const address = new URL("socket", location.href);
    address.protocol = "ws:";
    address.hash = "";
    const socket = new WebSocket(address);
    socket.binaryType = "arraybuffer";
    this.#socket = socket;
    socket.onopen = () => {
      this.#pause = FIRST_PAUSE;
      this.#attempts = 0;
      this.handlers.open();
    };
    socket.onmessage = ({ data }) => this.#receive(data);
    socket.onclose = ({ reason }) => this.#retry(reason);
  }

  #receive(data) {
    if (typeof data === "string") return this.handlers.event(JSON.parse(data));
    const length = new DataView(data).getUint32(0, true);
    const header = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 4, length)));
    this.handlers.frame(header, new Uint8Array(data, 4 + length));
  }

  #retry(reason) {
    this.#attempts += 1;
    const sentence = reason
      ? `The viewer has closed the connection: ${reason}.`
      : this.#attempts < PATIENCE
        ? "The connection is lost; trying again."
        : "The viewer does not answer; if it has ended, start it again and open its new address.";
    this.handlers.lost(sentence);
    this.#timer = setTimeout(() => this.#connect(), this.#pause);
    this.#pause = Math.min(2 * this.#pause, LONGEST_PAUSE);
  }
}
