// The picture: frames are decoded, drawn into the canvas, and wiped against each other.

import { drawn } from "./statistics.js";

/** Longest side of a picture that is asked for, in pixels. */
const LONGEST_SIDE = 2560;
const SIDES = ["chosen", "vanilla"];

export class Picture {
  // The latest picture of each side: `{ bitmap, header }`.
  #shown = { chosen: null, vanilla: null };
  #line = 0.5;
  #wipe = false;
  #state = null;
  // Grows with every connection: frames of an earlier one are numbered otherwise.
  #connection = 0;

  /**
   * `stage` is the room for the picture, `frame` the box that is fitted into it. Calls
   * `onShown(header)` when a frame has been drawn or dropped.
   */
  constructor(stage, frame, canvas, handle, onShown) {
    Object.assign(this, { stage, frame, canvas, handle, onShown });
    this.context = canvas.getContext("2d");
    this.#line = Number(sessionStorage.getItem("line") ?? 0.5);
    this.#moveHandle();
    this.#dragHandle();
  }

  /** Returns the pixels of the screen that a picture can fill. */
  room() {
    const { clientWidth, clientHeight } = this.stage;
    const scale = window.devicePixelRatio || 1;
    const [width, height] = [clientWidth * scale, clientHeight * scale];
    const reduced = Math.min(1, LONGEST_SIDE / Math.max(width, height));
    return [width, height].map((side) => Math.max(1, Math.round(side * reduced)));
  }

  /** Takes note of what the next frames show. */
  setState(state) {
    this.#state = state;
    this.#wipe = state.settings.wipe;
    this.handle.hidden = !this.#wipe;
    if (!this.#wipe) this.#forget("vanilla");
    this.layOut();
  }

  /** Another connection numbers frames and epochs anew; what is drawn stays until then. */
  reset() {
    this.#connection += 1;
    SIDES.forEach((side) => this.#forget(side));
  }

  /** Fits the picture into the stage: pixel by pixel if it fits, and reduced otherwise. */
  layOut() {
    if (!this.#state) return;
    const { width, height } = this.#state;
    const [roomWidth, roomHeight] = this.room();
    const { clientWidth, clientHeight } = this.stage;
    const scale = Math.min(1, roomWidth / width, roomHeight / height);
    const unit = clientWidth / roomWidth;
    const [w, h] = [width * scale * unit, height * scale * unit];
    Object.assign(this.frame.style, {
      width: `${w}px`,
      height: `${h}px`,
      left: `${(clientWidth - w) / 2}px`,
      top: `${(clientHeight - h) / 2}px`,
    });
  }

  /** Returns the point of the picture below a point of the window. */
  at(clientX, clientY) {
    const { left, top, width, height } = this.canvas.getBoundingClientRect();
    return [(clientX - left) / width, (clientY - top) / height];
  }

  /** Returns the height of the picture in pixels of the window. */
  get height() {
    return this.canvas.getBoundingClientRect().height || 1;
  }

  /** Decodes a frame and draws it. */
  async show(header, bytes) {
    const connection = this.#connection;
    let bitmap = null;
    try {
      const blob = new Blob([bytes], { type: header.media });
      bitmap = await createImageBitmap(blob, { colorSpaceConversion: "none" });
    } catch {
      // Half a picture cannot be shown; the next one will come.
    }
    const before = this.#shown[header.side]?.header;
    const isNewer = connection === this.#connection && (!before || header.id > before.id);
    // A frame of an earlier epoch shows other settings.
    if (bitmap && isNewer && header.epoch >= this.#state.epoch) {
      this.#forget(header.side);
      this.#shown[header.side] = { bitmap, header };
      this.#draw();
      document.getElementById("denoised").hidden = !header.denoised;
      drawn(header);
    } else {
      bitmap?.close();
    }
    this.onShown(header);
  }

  #forget(side) {
    this.#shown[side]?.bitmap.close();
    this.#shown[side] = null;
  }

  #draw() {
    if (!this.#state) return;
    const { canvas, context } = this;
    const { width, height } = this.#state;
    if (canvas.width !== width || canvas.height !== height) {
      Object.assign(canvas, { width, height });
    }
    context.imageSmoothingEnabled = true;
    context.globalCompositeOperation = "copy";
    for (const side of SIDES) {
      const picture = this.#shown[side];
      if (!picture || picture.header.epoch < this.#state.epoch) continue;
      context.save();
      if (side === "vanilla") {
        context.beginPath();
        context.rect(0, 0, Math.round(this.#line * width), height);
        context.clip();
      }
      context.drawImage(picture.bitmap, 0, 0, width, height);
      context.restore();
    }
  }

  #moveLine(line) {
    this.#line = Math.min(1, Math.max(0, line));
    sessionStorage.setItem("line", this.#line);
    this.#moveHandle();
    this.#draw();
  }

  #moveHandle() {
    this.handle.style.left = `${100 * this.#line}%`;
    this.handle.setAttribute("aria-valuenow", Math.round(100 * this.#line));
    this.handle.setAttribute("aria-valuetext", `${Math.round(100 * this.#line)} percent vanilla`);
  }

  #dragHandle() {
    const { handle } = this;
    handle.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      handle.setPointerCapture(event.pointerId);
      handle.focus();
      event.preventDefault();
    });
    handle.addEventListener("pointermove", (event) => {
      if (handle.hasPointerCapture(event.pointerId)) {
        this.#moveLine(this.at(event.clientX, event.clientY)[0]);
      }
    });
    handle.addEventListener("keydown", (event) => {
      const step = event.shiftKey ? 0.1 : 0.01;
      const moved = {
        ArrowLeft: this.#line - step,
        ArrowDown: this.#line - step,
        ArrowRight: this.#line + step,
        ArrowUp: this.#line + step,
        PageDown: this.#line - 0.1,
        PageUp: this.#line + 0.1,
        Home: 0,
        End: 1,
      }[event.key];
      if (moved === undefined) return;
      this.#moveLine(moved);
      event.preventDefault();
    });
  }
}
