// The card about the pixel under the pointer, or about one that is pinned.

const METERS = "m";

export class Inspector {
  #pinned = null;
  #hovered = null;
  // One question at a time: the next is asked when the answer is there.
  #isAsking = false;
  #isStale = false;
  #isEnabled = true;

  /** `ask(at)` sends a question; `say(text)` is for screen readers. */
  constructor(picture, ask, say) {
    Object.assign(this, { picture, ask, say });
    const element = (name) => document.getElementById(name);
    this.card = element("inspector");
    this.rows = element("inspector-rows");
    this.title = element("inspector-title");
    this.mark = element("inspector-mark");
    this.pin = element("pin");
    this.pin.addEventListener("keydown", (event) => this.#keyDown(event));
    this.pin.addEventListener("click", () => this.unpin());
  }

  set enabled(isEnabled) {
    this.#isEnabled = isEnabled;
    this.#hovered = null;
    this.#refresh();
  }

  get isPinned() {
    return this.#pinned !== null;
  }

  /** The pointer is over a point of the picture, or has left it. */
  hover(at) {
    this.#hovered = this.#isEnabled && at && isInside(at) ? at : null;
    this.#refresh();
  }

  togglePin(at, focus = false) {
    if (this.#pinned && near(this.#pinned, at)) return this.unpin();
    this.#pinned = this.#centered(at);
    this.#placePin();
    if (focus) this.pin.focus();
    this.#refresh();
  }

  unpin() {
    if (!this.#pinned) return;
    const hadFocus = document.activeElement === this.pin;
    this.#pinned = null;
    this.pin.hidden = true;
    if (hadFocus) this.picture.canvas.focus({ preventScroll: true });
    this.#refresh();
  }

  /** What the picture shows has changed: ask again. */
  refresh() {
    this.#refresh();
  }

  /** The connection was cut: no answer will come. */
  reset() {
    this.#isAsking = false;
  }

  #refresh() {
    const at = this.#pinned ?? this.#hovered;
    if (!at) {
      this.card.hidden = true;
      return;
    }
    if (this.#isAsking) {
      this.#isStale = true;
      return;
    }
    this.#isAsking = true;
    this.#isStale = false;
    this.ask(at);
  }

  /** Shows an answer. */
  answer({ pixel, value, hit }) {
    this.#isAsking = false;
    if (this.#isStale) this.#refresh();
    if (!this.#pinned && !this.#hovered) return;
    this.title.textContent = `Pixel ${pixel[0]}, ${pixel[1]}`;
    this.mark.textContent = this.#pinned ? "pinned" : "";
    const rows = describe(value, hit);
    this.rows.replaceChildren(...rows.map(([name, text]) => {
      const row = document.createElement("tr");
      const head = document.createElement("th");
      head.scope = "row";
      head.textContent = name;
      const cell = document.createElement("td");
      cell.textContent = text;
      row.append(head, cell);
      return row;
    }));
    this.card.hidden = false;
    if (this.#pinned && document.activeElement === this.pin) {
      this.say(`Pixel ${pixel.join(", ")}: ${hit ? `${hit.kind} ${hit.element} of ${named(hit.shape)}, t ${number(hit.t)} meters` : "no surface"}`);
    }
  }

  /** Returns the center of the pixel at a point, or of one that is so many pixels off. */
  #centered([u, v], right = 0, down = 0) {
    const center = (x, size, step) => {
      const pixel = Math.floor(x * size) + step;
      return (Math.min(size - 1, Math.max(0, pixel)) + 0.5) / size;
    };
    const { width, height } = this.picture.canvas;
    return [center(u, width, right), center(v, height, down)];
  }

  #placePin() {
    const [u, v] = this.#pinned;
    this.pin.style.left = `${100 * u}%`;
    this.pin.style.top = `${100 * v}%`;
    this.pin.hidden = false;
  }

  #keyDown(event) {
    const step = event.shiftKey ? 10 : 1;
    const [dx, dy] = {
      ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1],
    }[event.key] ?? [0, 0];
    if (!dx && !dy) return;
    event.preventDefault();
    this.#pinned = this.#centered(this.#pinned, dx * step, dy * step);
    this.#placePin();
    this.#refresh();
  }
}

function describe(value, hit) {
  const rows = [["value", value ? `${value.slice(0, 3).map(number).join("  ")}${value[3] < 1 ? `  alpha ${number(value[3])}` : ""}` : "not yet"]];
  if (!hit) return [...rows, ["hit", "no surface"]];
  return [
    ...rows,
    ["instance", named(hit.instance)],
    ["shape", named(hit.shape)],
    ["material", `${named(hit.material)}, ${hit.material_kind}`],
    ["element", `${hit.element} of ${hit.kind}, ${hit.method}`],
    ["t", `${number(hit.t)} ${METERS}`],
    ["position", vector(hit.position)],
    ["error", `\u2264 ${hit.error.toExponential(2)} ${METERS}`],
    ["normal", vector(hit.normal)],
    ["shading", vector(hit.shading_normal)],
    ["uv", vector(hit.uv)],
    ["texcoord", vector(hit.texcoord)],
  ];
}

function named([index, name]) {
  return name ? `${name} (${index})` : `${index}`;
}

function vector(values) {
  return values.map(number).join("  ");
}

/** Returns a number with five digits, as a person writes it. */
export function number(value) {
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size < 1e-4 || size >= 1e6) return value.toExponential(3);
  return Number(value.toPrecision(5)).toString();
}

function isInside(at) {
  return at.every((x) => x >= 0 && x <= 1);
}

function near(a, b) {
  return Math.hypot(a[0] - b[0], a[1] - b[1]) < 0.01;
}
