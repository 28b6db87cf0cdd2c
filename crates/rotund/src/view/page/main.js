// The page of the viewer: joins the picture, the hand, the panel and the connection.

import { flushAddress, isForeign, readAddress, writeAddress } from "./address.js";
import { Connection } from "./connection.js";
import { Hand, takesKeys } from "./hand.js";
import { Inspector } from "./inspector.js";
import { Panel } from "./panel.js";
import { Picture } from "./picture.js";
import { settingsDrawn, statistics } from "./statistics.js";

const element = (name) => document.getElementById(name);
const send = (request) => connection.send(request);

let session = 0;
// The view to ask for when the connection opens: that of the address, or the last one.
let wanted = readAddress();
// Settings that were sent and have not been drawn, with the moment, and their epoch once known.
let change = null;

const picture = new Picture(
  element("stage"), element("frame"), element("picture"), element("wipe"), onShown,
);
const panel = new Panel({
  settings(settings) {
    change = { text: JSON.stringify(settings), moment: performance.now(), epoch: null };
    send({ type: "settings", settings });
  },
  request: send,
  size: askForSize,
  say,
});
const inspector = new Inspector(picture, (at) => send({ type: "inspect", at }), say);
const hand = new Hand(picture, send, {
  click(at, isDouble) {
    if (isDouble) inspector.unpin();
    else inspector.togglePin(at);
  },
  hover: (at) => inspector.hover(at),
  moving: (isMoving) => !isMoving && inspector.refresh(),
});
if (wanted.size) panel.size = wanted.size;

const connection = new Connection({
  open() {
    statistics.asked ??= performance.now();
    clearNotice("connection");
    picture.reset();
    askForSize();
    if (wanted.settings) send({ type: "settings", settings: wanted.settings });
    if (wanted.camera) send({ type: "camera", camera: wanted.camera });
  },
  event: onEvent,
  frame: (header, bytes) => picture.show(header, bytes),
  lost(sentence) {
    if (panel.state) wanted = view(panel.state);
    hand.reset();
    inspector.reset();
    element("loading").hidden = true;
    panel.showNothing("Not connected");
    showNotice("connection", sentence, false);
  },
});

function onEvent(event) {
  switch (event.type) {
    case "greeting":
      session = event.session;
      return panel.greet(event);
    case "state":
      return onState(event);
    case "status":
      statistics.status = event;
      return panel.showStatus(event);
    case "inspection":
      return inspector.answer(event);
    case "loading":
      element("loading").hidden = false;
      element("loading-text").textContent = `${event.what}, ${event.seconds.toFixed(1)} s`;
      return;
    case "problem":
      element("loading").hidden = true;
      panel.revert();
      if (!panel.state) panel.showNothing("No scene");
      return showNotice("problem", event.text, true);
    case "solved":
      return clearNotice("problem");
  }
}

function onState(state) {
  const settings = JSON.stringify(state.settings);
  const isSame = panel.state && settings === JSON.stringify(panel.state.settings);
  if (change && change.text === settings) change.epoch ??= state.epoch;
  statistics.state = state;
  picture.setState(state);
  panel.setState(state);
  element("loading").hidden = true;
  writeAddress(view(state));
  if (inspector.isPinned || !isSame) inspector.refresh();
}

function view({ camera, settings }) {
  return { camera, settings, size: panel.size };
}

function onShown(header) {
  if (change?.epoch && header.epoch >= change.epoch) {
    settingsDrawn(change.moment);
    change = null;
  }
  const shown = () => send({ type: "shown", frame: header.id });
  // Nobody sees a hidden page, so the next picture can wait.
  if (!document.hidden) return shown();
  document.addEventListener("visibilitychange", shown, { once: true });
}

function askForSize() {
  const { camera } = panel.size;
  const [width, height] = camera ? [camera, camera] : picture.room();
  send({ type: "size", width, height, keep_aspect: camera !== undefined });
  picture.layOut();
}

let resized = 0;
new ResizeObserver(() => {
  picture.layOut();
  clearTimeout(resized);
  resized = setTimeout(askForSize, 100);
}).observe(element("stage"));
window.addEventListener("pagehide", flushAddress);
window.addEventListener("hashchange", () => {
  if (!isForeign()) return;
  wanted = readAddress();
  if (wanted.size) panel.size = wanted.size;
  askForSize();
  if (wanted.settings) send({ type: "settings", settings: wanted.settings });
  if (wanted.camera) send({ type: "camera", camera: wanted.camera });
});

// Keys beside those of the hand.
document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey || event.repeat) return;
  if (event.key === "Escape" && !document.querySelector("dialog[open]")) return inspector.unpin();
  if (takesKeys(event.target) && event.target.id !== "pin") return;
  const action = {
    1: () => panel.toggle("points"),
    2: () => panel.toggle("lines"),
    3: () => panel.toggle("quads"),
    4: () => panel.toggle("wipe"),
    f: () => send({ type: "frame-all" }),
    i: () => (inspector.isPinned ? inspector.unpin() : inspector.togglePin([0.5, 0.5], true)),
    p: () => showPanel(document.body.classList.contains("without-panel")),
    "?": () => element("help-dialog").showModal(),
  }[event.key.toLowerCase()];
  if (!action) return;
  event.preventDefault();
  action();
});

// The panel: beside the picture, or a sheet below it.
function showPanel(isShown) {
  document.body.classList.toggle("without-panel", !isShown);
  element("show-panel").hidden = isShown;
  if (isShown) element("hide-panel").focus();
  else element("picture").focus();
}
element("hide-panel").addEventListener("click", () => showPanel(false));
element("show-panel").addEventListener("click", () => showPanel(true));
element("sheet").addEventListener("click", () => {
  const isOpen = document.body.classList.toggle("open-sheet");
  element("sheet").setAttribute("aria-expanded", isOpen);
});
element("inspect").addEventListener("change", ({ target }) => {
  inspector.enabled = target.checked;
});

// Files to keep.
for (const button of document.querySelectorAll("[data-save]")) {
  button.addEventListener("click", () => save(button));
}

async function save(button) {
  const file = button.dataset.save;
  button.disabled = true;
  try {
    const answer = await fetch(`save/${session}/${file}`);
    if (!answer.ok) return showNotice("save", await answer.text(), true);
    const link = document.createElement("a");
    link.href = URL.createObjectURL(await answer.blob());
    const extension = file.replace(/^(picture|report)/, "").replace("denoised", ".denoised");
    link.download = `${panel.state?.scene ?? "picture"}${extension}`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
    clearNotice("save");
  } catch {
    showNotice("save", "The file could not be saved: the viewer does not answer.", true);
  } finally {
    button.disabled = false;
  }
}

element("long-render").addEventListener("click", async () => {
  try {
    const answer = await fetch(`save/${session}/command`);
    const text = await answer.text();
    if (!answer.ok) return showNotice("save", text, true);
    showText("Continue as long render", "Run this in a terminal, in the folder that the viewer was started in; more samples make less noise.", text);
  } catch {
    showNotice("save", "There is no command line: the viewer does not answer.", true);
  }
});
element("copy-camera").addEventListener("click", () => {
  if (!panel.state) return;
  const text = JSON.stringify(panel.state.camera, null, 2).replace(/\s+(?=[^[\]]*\])/g, " ");
  showText("Camera", "An entry for “cameras” in a scene file.", text);
});

function showText(title, note, text) {
  element("text-title").textContent = title;
  element("text-note").textContent = note;
  element("text").value = text;
  element("copy-text").textContent = "Copy";
  element("text-dialog").showModal();
  element("copy-text").focus();
}
element("copy-text").addEventListener("click", async () => {
  const area = element("text");
  area.select();
  try {
    await navigator.clipboard.writeText(area.value);
    element("copy-text").textContent = "Copied";
  } catch {
    // Browsers refuse outside of loopback and HTTPS; the text is selected for the keys.
    element("copy-text").textContent = "Press Ctrl-C";
    area.focus();
  }
});
element("help").addEventListener("click", () => element("help-dialog").showModal());
for (const button of document.querySelectorAll("dialog .close")) {
  button.addEventListener("click", () => button.closest("dialog").close());
}

// Messages above the picture, one of each kind.
function showNotice(kind, text, canClose) {
  let notice = document.querySelector(`[data-notice="${kind}"]`);
  if (!notice) {
    notice = document.createElement("div");
    notice.dataset.notice = kind;
    notice.append(document.createElement("p"));
    if (canClose) {
      const close = document.createElement("button");
      close.type = "button";
      close.className = "icon";
      close.textContent = "\u00d7";
      close.setAttribute("aria-label", "Dismiss");
      close.addEventListener("click", () => notice.remove());
      notice.append(close);
    }
    element("notices").append(notice);
  }
  const paragraph = notice.querySelector("p");
  if (paragraph.textContent !== text) paragraph.textContent = text;
}

function clearNotice(kind) {
  document.querySelector(`[data-notice="${kind}"]`)?.remove();
}

/** Says something to screen readers. */
function say(text) {
  element("live").textContent = text;
}
