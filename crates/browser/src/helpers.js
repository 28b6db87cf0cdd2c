// What the checks ask of the page, in terms of what a person sees.

function find(name) {
  return document.getElementById(name);
}

function middle(selector) {
  const element = document.querySelector(selector);
  element?.scrollIntoView({ block: "nearest" });
  const box = element?.getBoundingClientRect();
  return box ? [box.left + box.width / 2, box.top + box.height / 2] : null;
}

/** All wanted samples of what the viewer shows are drawn. */
function isDone() {
  const { state, shown, sent } = window.rotundStatistics ?? {};
  if (!state) return false;
  const isWhole = (header) => header?.epoch === state.epoch && !header.preview
    && header.samples === state.settings.samples && header.input === sent;
  return isWhole(shown.chosen) && (!state.settings.wipe || isWhole(shown.vanilla));
}

function epoch() {
  return window.rotundStatistics?.state?.epoch ?? -1;
}

/** Returns a text that differs if the viewer was asked for another picture. */
function mark() {
  return `${epoch()}, ${window.rotundStatistics?.sent}`;
}

function view() {
  const parts = new URLSearchParams(location.hash.slice(1));
  return Object.fromEntries([...parts].map(([name, value]) => [name, JSON.parse(value)]));
}

function eye() {
  return view().camera?.frame.slice(9) ?? null;
}

/** Returns a number that differs if a pixel of a part of the picture differs. */
function hash(left = 0, right = 1) {
  const canvas = find("picture");
  const from = Math.round(left * canvas.width);
  const to = Math.round(right * canvas.width);
  const { data } = canvas.getContext("2d").getImageData(from, 0, to - from, canvas.height);
  return fold(new Uint32Array(data.buffer));
}

function fold(words) {
  return words.reduce((sum, word) => Math.imul(sum ^ word, 16777619) >>> 0, 2166136261);
}

/** Returns how many of the shown pixels differ from those of a picture, or -1 for another size. */
async function differing(blob) {
  const bitmap = await createImageBitmap(blob, { colorSpaceConversion: "none" });
  const canvas = find("picture");
  if (bitmap.width !== canvas.width || bitmap.height !== canvas.height) return -1;
  const other = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
  other.drawImage(bitmap, 0, 0);
  const pixels = (context) => {
    const { data } = context.getImageData(0, 0, bitmap.width, bitmap.height);
    return new Uint32Array(data.buffer);
  };
  const [a, b] = [pixels(canvas.getContext("2d")), pixels(other)];
  return a.reduce((count, word, index) => count + (word !== b[index]), 0);
}

/** Sets a control as a person does. */
function set(name, value) {
  const control = document.querySelector(`[name=${name}]`) ?? find(name);
  if (control.type === "checkbox") control.checked = value;
  else control.value = value;
  control.dispatchEvent(new Event("input", { bubbles: true }));
  control.dispatchEvent(new Event("change", { bubbles: true }));
}

function notices() {
  return [...document.querySelectorAll("#notices p")].map((it) => it.textContent).join(" | ");
}

function summary() {
  const { id, tagName } = document.activeElement;
  const focus = `the focus is on ${id || tagName}`;
  const parts = [find("activity")?.textContent, find("samples")?.textContent, notices(), focus];
  return parts.join("; ");
}
