// The controls: what is set goes to the viewer, what the viewer says is shown.

import { number } from "./inspector.js";

const KINDS = ["points", "lines", "quads"];
/** Milliseconds for which the viewer may still answer with older settings. */
const ECHO = 1500;

export class Panel {
  #state = null;
  #settings = null;
  #sentAt = -Infinity;
  #frame = 0;
  #activity = "";

  /** `actions` has `settings(settings)`, `request(request)`, `size()` and `say(text)`. */
  constructor(actions) {
    this.actions = actions;
    this.form = element("settings");
    const { form } = this;
    form.addEventListener("submit", (event) => event.preventDefault());
    for (const control of form.querySelectorAll("[name]")) {
      const name = control.type === "range" ? "input" : "change";
      control.addEventListener(name, () => this.#changed());
    }
    element("cameras").addEventListener("change", ({ target }) => {
      actions.request({ type: "scene-camera", index: Number(target.value) });
    });
    for (const name of ["field", "aperture", "focus"]) {
      element(name).addEventListener("change", () => this.#cameraChanged(name));
    }
    element("frame-all").addEventListener("click", () => actions.request({ type: "frame-all" }));
    element("size").addEventListener("change", () => this.#sizeChanged());
    element("pixels").addEventListener("change", () => this.#sizeChanged());
  }

  get state() {
    return this.#state;
  }

  /** Size as it is chosen: `{ camera: pixels }` of the longer side, or `{}` for the window. */
  get size() {
    if (element("size").value === "window") return {};
    const pixels = Math.round(Number(element("pixels").value));
    return { camera: pixels >= 1 ? pixels : 720 };
  }

  set size({ camera }) {
    element("size").value = camera ? "camera" : "window";
    if (camera) element("pixels").value = camera;
    element("pixels-row").hidden = !camera;
  }

  greet({ program, views, without_denoiser }) {
    element("program").textContent = program;
    this.form.elements.denoise.disabled = without_denoiser !== null;
    element("denoise-text").hidden = without_denoiser === null;
    element("denoise-text").textContent = without_denoiser && sentence(without_denoiser);
    const select = this.form.elements.view;
    select.replaceChildren(...views.map(([name]) => new Option(name.replaceAll("-", " "), name)));
    this.views = new Map(views);
    if (this.#settings) this.#showSettings(this.#settings);
    this.showNothing("Loading");
  }

  setState(state) {
    const before = this.#state;
    this.#state = state;
    element("scene").textContent = state.scene;
    document.title = `${state.scene} \u2013 Rotund`;
    const [points, lines, , quads] = state.elements;
    [points, lines, quads].forEach((count, index) => {
      element(`count-${KINDS[index]}`).textContent = count.toLocaleString("en");
      this.form.elements[KINDS[index]].disabled = count === 0;
    });
    if (JSON.stringify(before?.cameras) !== JSON.stringify(state.cameras)) {
      const options = state.cameras.map((name, index) => new Option(name || `camera ${index}`, index));
      const own = new Option("moved", "", true, true);
      own.hidden = true;
      element("cameras").replaceChildren(own, ...options);
    }
    const index = state.cameras.indexOf(state.camera.name);
    element("cameras").value = index >= 0 ? index : "";
    this.#showWarnings(state.warnings);
    this.#showCamera(state.camera);
    // A control that was changed in this frame has not been read yet.
    if (this.#frame) return;
    const isEcho = JSON.stringify(state.settings) === JSON.stringify(this.#settings);
    if (isEcho || performance.now() - this.#sentAt > ECHO) this.#showSettings(state.settings);
    else setTimeout(() => this.#state === state && this.#showSettings(state.settings), ECHO);
  }

  /** The viewer has refused something: the controls show again what is in force. */
  revert() {
    this.#sentAt = -Infinity;
    if (this.#state) this.#showSettings(this.#state.settings, true);
    if (this.#state) this.#showCamera(this.#state.camera, true);
  }

  /** Sets one of the check boxes to the contrary. */
  toggle(name) {
    const control = this.form.elements[name];
    if (control.disabled) return;
    control.checked = !control.checked;
    this.#changed();
    this.actions.say(`${name} ${control.checked ? "on" : "off"}`);
  }

  showStatus({ activity, samples, wanted, rays_per_second, seconds, noise, fireflies }) {
    const words = { loading: "Loading", moving: "Moving", refining: "Refining", done: "Done" };
    element("activity").textContent = words[activity];
    element("samples").textContent = activity === "loading" ? "" : `${samples} of ${wanted} samples`;
    const progress = element("progress");
    progress.value = wanted ? samples / wanted : 0;
    element("speed").textContent = rays_per_second > 0
      ? `${(rays_per_second / 1e6).toFixed(2)} Mrays/s, ${time(seconds)}` : "\u00a0";
    const parts = [];
    if (noise !== null) parts.push(`noise ${(100 * noise).toPrecision(2)} %`);
    if (fireflies) parts.push(`${fireflies.toLocaleString("en")} fireflies`);
    element("noise").textContent = parts.join(", ");
    if (activity === "done" && this.#activity !== "done") this.actions.say(`Done, ${samples} samples`);
    this.#activity = activity;
  }

  /** There is no status: the connection is lost, or there is no scene. */
  showNothing(why) {
    element("activity").textContent = why;
    element("samples").textContent = "";
  }

  #changed() {
    this.#frame ||= requestAnimationFrame((now) => {
      this.#frame = 0;
      const settings = this.#read();
      if (!settings) return;
      this.#settings = settings;
      this.#sentAt = now;
      this.#describe(settings);
      this.actions.settings(settings);
    });
  }

  /** Returns the settings of the controls; a control with no number keeps what is in force. */
  #read() {
    const before = this.#settings;
    if (!before) return null;
    const { elements } = this.form;
    const integer = (name) => {
      const value = elements[name].value.trim();
      return /^\d+$/.test(value) && Number.isSafeInteger(Number(value)) ? Number(value) : before[name];
    };
    const clamp = elements.clamp.value.trim();
    const settings = {
      ...before,
      points: elements.points.checked,
      lines: elements.lines.checked,
      quads: elements.quads.checked,
      overlap: elements.overlap.value,
      wipe: elements.wipe.checked,
      view: elements.view.value || before.view,
      samples: integer("samples"),
      bounces: integer("bounces"),
      clamp: clamp === "" ? null : Number(clamp) > 0 ? Number(clamp) : before.clamp,
      independent: elements.independent.value !== "",
      seed: integer("seed"),
      background: elements.background.checked,
      exposure: Number(elements.exposure.value),
      filmic: elements.filmic.value !== "",
      denoise: elements.denoise.checked,
    };
    for (const name of ["samples", "bounces", "seed"]) elements[name].value = settings[name];
    elements.clamp.value = settings.clamp ?? "";
    return settings;
  }

  #showSettings(settings, force = false) {
    this.#settings = settings;
    const { elements } = this.form;
    const set = (name, value) => {
      const control = elements[name];
      if (control.type === "checkbox") control.checked = value;
      else if (force || document.activeElement !== control || control.type === "select-one") {
        control.value = value;
      }
    };
    for (const name of [...KINDS, "wipe", "background", "denoise", "overlap", "view", "samples", "bounces",
      "seed", "exposure"]) {
      set(name, settings[name]);
    }
    set("clamp", settings.clamp ?? "");
    set("independent", settings.independent ? "independent" : "");
    set("filmic", settings.filmic ? "filmic" : "");
    this.#describe(settings);
  }

  #describe({ denoise, exposure, view }) {
    element("save-denoised").hidden = !denoise;
    const sign = exposure > 0 ? "+" : "";
    element("exposure-text").textContent = `${sign}${exposure.toFixed(1)}`;
    element("view-text").textContent = this.views?.get(view) ?? "";
  }

  #showCamera(camera, force = false) {
    const set = (name, value) => {
      const control = element(name);
      if (force || document.activeElement !== control) control.value = number(value);
    };
    const { orthographic, film, lens } = camera;
    element("field-label").textContent = orthographic ? "Width" : "Field of view";
    element("field-unit").textContent = orthographic ? "m" : "\u00b0";
    set("field", orthographic ? film / lens : (360 / Math.PI) * Math.atan(film / lens / 2));
    set("aperture", 1000 * camera.aperture);
    set("focus", camera.focus);
  }

  #cameraChanged(name) {
    if (!this.#state) return;
    const camera = { ...this.#state.camera };
    const value = Number(element(name).value);
    const isPositive = element(name).value !== "" && value > 0;
    if (name === "field" && isPositive) {
      camera.lens = camera.orthographic
        ? camera.film / value
        : camera.film / (2 * Math.tan((Math.min(value, 179) * Math.PI) / 360));
    } else if (name === "aperture" && (isPositive || value === 0)) {
      camera.aperture = value / 1000;
    } else if (name === "focus" && isPositive) {
      camera.focus = value;
    } else {
      return this.#showCamera(this.#state.camera, true);
    }
    this.actions.request({ type: "camera", camera });
  }

  #sizeChanged() {
    const isCamera = element("size").value === "camera";
    element("pixels-row").hidden = !isCamera;
    this.actions.size();
  }

  #showWarnings(warnings) {
    const details = element("warnings");
    details.hidden = warnings.length === 0;
    const summary = warnings.length === 1 ? "1 warning" : `${warnings.length} warnings`;
    details.querySelector("summary").textContent = summary;
    details.querySelector("ul").replaceChildren(...warnings.map((text) => {
      const item = document.createElement("li");
      item.textContent = text;
      return item;
    }));
  }
}

function element(name) {
  return document.getElementById(name);
}

function sentence(text) {
  return `${text[0].toUpperCase()}${text.slice(1)}.`;
}

function time(seconds) {
  if (seconds < 60) return `${seconds.toFixed(1)} s`;
  const whole = Math.round(seconds);
  const pad = (part) => String(part).padStart(2, "0");
  const minutes = Math.floor(whole / 60);
  return minutes < 60 ? `${minutes}:${pad(whole % 60)} min`
    : `${Math.floor(minutes / 60)}:${pad(minutes % 60)} h`;
}
