// The hand on the picture: mouse, pen, fingers and keys become movements of the camera.
//
// Movements are summed, and sent at most once for each frame of the screen.

import { connectionLost, inputSent } from "./statistics.js";

/** Pixels within which a press counts as a click. */
const CLICK = 5;
const DOUBLE_CLICK = 350;
/** After the last turn of the wheel, the hand lets go. */
const WHEEL_REST = 150;
/** Pixels of the wheel that halve the distance. */
const WHEEL_STEP = 500;
/** Movement in a second while a key is held: heights of the picture, doublings, distances. */
const SPEED = { orbit: 0.35, look: 0.25, zoom: 1.5, fly: 0.7 };

const KEYS = {
  ArrowLeft: ["turn", -1, 0], ArrowRight: ["turn", 1, 0],
  ArrowUp: ["turn", 0, -1], ArrowDown: ["turn", 0, 1],
  KeyA: ["fly", -1, 0, 0], KeyD: ["fly", 1, 0, 0],
  KeyQ: ["fly", 0, -1, 0], KeyE: ["fly", 0, 1, 0],
  KeyS: ["fly", 0, 0, -1], KeyW: ["fly", 0, 0, 1],
};
/** Keys by what is printed on them, since their places differ. */
const SIGNS = { "+": ["zoom", 1], "=": ["zoom", 1], "-": ["zoom", -1], "_": ["zoom", -1] };

export class Hand {
  #pointers = new Map();
  // What the keys that are held do, by their codes.
  #keys = new Map();
  #isHeld = false;
  #motion = null;
  #begun = 0;
  #input = 0;
  #frame = 0;
  #lastFrame = 0;
  #wheelTimer = 0;
  #press = null;
  #lastClick = { moment: -Infinity, x: 0, y: 0 };

  /** `send` takes requests; `events` has `click(at)`, `hover(at | null)` and `moving(bool)`. */
  constructor(picture, send, events) {
    Object.assign(this, { picture, send, events });
    const { canvas } = picture;
    canvas.addEventListener("pointerdown", (event) => this.#down(event));
    canvas.addEventListener("pointermove", (event) => this.#move(event));
    for (const name of ["pointerup", "pointercancel", "lostpointercapture"]) {
      canvas.addEventListener(name, (event) => this.#up(event, name === "pointerup"));
    }
    canvas.addEventListener("pointerleave", () => this.events.hover(null));
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("wheel", (event) => this.#wheel(event), { passive: false });
    document.addEventListener("keydown", (event) => this.#keyDown(event));
    document.addEventListener("keyup", (event) => this.#keyUp(event));
    window.addEventListener("blur", () => this.#releaseKeys());
  }

  /** Lets go of everything: the connection was cut. */
  reset() {
    this.#pointers.clear();
    this.#keys.clear();
    this.#motion = null;
    this.#isHeld = false;
    connectionLost();
  }

  #grab(at) {
    if (!this.#isHeld) this.events.moving(true);
    this.#isHeld = true;
    this.send({ type: "grab", at });
  }

  #release() {
    if (!this.#isHeld || this.#pointers.size || this.#keys.size || this.#wheelTimer) return;
    this.#flush();
    this.#isHeld = false;
    this.send({ type: "release" });
    this.events.moving(false);
  }

  #down(event) {
    const { canvas } = this.picture;
    canvas.focus({ preventScroll: true });
    canvas.setPointerCapture(event.pointerId);
    const pans = event.button !== 0 || event.shiftKey;
    this.#pointers.set(event.pointerId, { x: event.clientX, y: event.clientY, pans });
    const [x, y] = this.#center();
    this.#press = this.#pointers.size === 1 && event.button === 0 && !event.shiftKey
      ? { x, y, moved: false }
      : null;
    this.#grab(this.picture.at(x, y));
    event.preventDefault();
  }

  #move(event) {
    const pointer = this.#pointers.get(event.pointerId);
    const { clientX, clientY } = event;
    if (!pointer) {
      if (event.pointerType !== "touch") this.events.hover(this.picture.at(clientX, clientY));
      return;
    }
    const before = [this.#center(), this.#spread()];
    Object.assign(pointer, { x: clientX, y: clientY });
    const after = [this.#center(), this.#spread()];
    const { height } = this.picture;
    const step = [0, 1].map((axis) => (after[0][axis] - before[0][axis]) / height);
    if (this.#press) {
      const far = Math.hypot(clientX - this.#press.x, clientY - this.#press.y);
      this.#press.moved ||= far > CLICK;
      // A click must not turn the camera by the tremble of a hand.
      if (!this.#press.moved) return Object.assign(pointer, { x: this.#press.x, y: this.#press.y });
    }
    const motion = this.#sum(event.timeStamp);
    const kind = this.#pointers.size > 1 || pointer.pans ? "pan" : this.#flies() ? "look" : "orbit";
    motion[kind][0] += step[0];
    motion[kind][1] += step[1];
    if (this.#pointers.size > 1 && before[1] > 0 && after[1] > 0) {
      motion.zoom += Math.log2(after[1] / before[1]);
      motion.at = this.picture.at(...after[0]);
    }
  }

  #up(event, isClick) {
    if (!this.#pointers.delete(event.pointerId)) return;
    if (this.#pointers.size) {
      // The fingers that are left take hold anew.
      this.#flush();
      this.#press = null;
      return this.#grab(this.picture.at(...this.#center()));
    }
    const press = this.#press;
    this.#press = null;
    this.#release();
    if (isClick && press && !press.moved) this.#click(event, press);
  }

  #click(event, { x, y }) {
    const { moment, x: lastX, y: lastY } = this.#lastClick;
    const isDouble = event.timeStamp - moment < DOUBLE_CLICK
      && Math.hypot(x - lastX, y - lastY) < 4 * CLICK;
    this.#lastClick = { moment: isDouble ? -Infinity : event.timeStamp, x, y };
    const at = this.picture.at(x, y);
    if (isDouble) this.send({ type: "focus", at });
    this.events.click(at, isDouble);
  }

  #center() {
    const all = [...this.#pointers.values()];
    const sum = (axis) => all.reduce((total, pointer) => total + pointer[axis], 0) / all.length;
    return [sum("x"), sum("y")];
  }

  /** Returns the distance of two fingers. */
  #spread() {
    const [a, b] = this.#pointers.values();
    return b ? Math.hypot(a.x - b.x, a.y - b.y) : 0;
  }

  #wheel(event) {
    event.preventDefault();
    const unit = [1, 33, 400][event.deltaMode];
    const at = this.picture.at(event.clientX, event.clientY);
    if (!this.#isHeld) this.#grab(at);
    clearTimeout(this.#wheelTimer);
    this.#wheelTimer = setTimeout(() => {
      this.#wheelTimer = 0;
      this.#release();
    }, WHEEL_REST);
    const motion = this.#sum(event.timeStamp);
    // A pinch on a touchpad comes as a wheel with Ctrl and small steps.
    motion.zoom -= (event.deltaY * unit * (event.ctrlKey ? 5 : 1)) / WHEEL_STEP;
    motion.at = at;
  }

  #flies() {
    return [...this.#keys.values()].some(([kind]) => kind === "fly");
  }

  #keyDown(event) {
    const action = KEYS[event.code] ?? SIGNS[event.key];
    if (!action || event.ctrlKey || event.metaKey || event.altKey) return;
    if (takesKeys(event.target)) return;
    event.preventDefault();
    if (this.#keys.has(event.code)) return;
    if (!this.#isHeld) {
      this.#grab([0.5, 0.5]);
      this.#lastFrame = performance.now();
    }
    this.#keys.set(event.code, action);
    this.shift = event.shiftKey;
    this.#sum(event.timeStamp);
  }

  #keyUp(event) {
    this.shift = event.shiftKey;
    if (this.#keys.delete(event.code)) this.#release();
  }

  #releaseKeys() {
    this.#keys.clear();
    this.#release();
  }

  /** Returns the sum of the movements that the next frame of the screen sends. */
  #sum(moment) {
    if (!this.#motion) {
      this.#motion = { orbit: [0, 0], pan: [0, 0], look: [0, 0], fly: [0, 0, 0], zoom: 0 };
      this.#begun = moment;
    }
    this.#frame ||= requestAnimationFrame((now) => this.#tick(now));
    return this.#motion;
  }

  #tick(now) {
    this.#frame = 0;
    if (this.#keys.size) {
      // After a frame that was late, the camera must not jump.
      const seconds = Math.min(0.1, Math.max(0.004, (now - this.#lastFrame) / 1000));
      this.#hold(seconds);
    }
    this.#lastFrame = now;
    this.#flush();
    if (this.#keys.size) this.#sum(performance.now());
  }

  /** Adds what the held keys move in this time. */
  #hold(seconds) {
    const motion = this.#sum(performance.now());
    for (const [kind, ...direction] of this.#keys.values()) {
      if (kind === "zoom") {
        motion.zoom += direction[0] * SPEED.zoom * seconds;
        continue;
      }
      const target = kind === "fly" ? "fly" : this.shift ? "look" : "orbit";
      const speed = SPEED[target] * (kind === "fly" && this.shift ? 4 : 1) * seconds;
      direction.forEach((part, axis) => { motion[target][axis] += part * speed; });
    }
  }

  #flush() {
    const motion = this.#motion;
    this.#motion = null;
    if (!motion) return;
    const request = { type: "move" };
    for (const [kind, value] of Object.entries(motion)) {
      if ([value].flat().some((part) => part !== 0)) request[kind] = value;
    }
    if (Object.keys(request).length === 1) return;
    this.#input += 1;
    request.input = this.#input;
    inputSent(this.#input, this.#begun);
    this.send(request);
  }
}

/** Returns true if an element needs the keys itself. One in a dialog that has just closed may still
    have the focus. */
export function takesKeys(target) {
  const own = "input:not([type=checkbox]), select, textarea, dialog[open], [role=slider], #pin";
  return target instanceof Element && target.closest(own) !== null;
}
