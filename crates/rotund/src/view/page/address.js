// Camera and settings in the address of the page, so that a link or a reload shows the same view.

// Browsers limit how often an address may change.
const PAUSE = 400;

let timer = 0;
let latest = "";

/** Returns `{ camera, settings, size }` of the address, each `undefined` if it is not there. */
export function readAddress() {
  const found = {};
  for (const [name, value] of new URLSearchParams(location.hash.slice(1))) {
    if (!["camera", "settings", "size"].includes(name)) continue;
    try {
      found[name] = JSON.parse(value);
    } catch {
      // A link that was cut shows what is left of it.
    }
  }
  return found;
}

/** Puts `{ camera, settings, size }` into the address, some time later. */
export function writeAddress(view) {
  const parts = new URLSearchParams();
  for (const [name, value] of Object.entries(view)) parts.set(name, JSON.stringify(value));
  latest = `#${parts}`;
  timer ||= setTimeout(flushAddress, PAUSE);
}

/** Puts what was written last into the address now. */
export function flushAddress() {
  clearTimeout(timer);
  timer = 0;
  if (latest && latest !== location.hash) history.replaceState(null, "", latest);
}

/** Returns true if the address was changed by hand since it was written. */
export function isForeign() {
  return latest !== "" && latest !== location.hash;
}
