// What the page shows, and times that it measures of itself, in milliseconds. Tests read them.

export const statistics = {
  // From the start of the navigation to the first request, and to the first picture on the screen.
  asked: null,
  firstPicture: null,
  // From an input event to the screen, by the number of the input.
  inputs: {},
  // From a change of the settings to the screen, in order.
  settings: [],
  // Moments at which previews came to the screen.
  previews: [],
  frames: 0,
  // The number of the last input, the state and status of the viewer, and the header of the frame
  // that is drawn for each side.
  sent: 0,
  state: null,
  status: null,
  shown: {},
};
window.rotundStatistics = statistics;

// A page that is open for days keeps the latest ones.
const MOST = 4000;

const waiting = new Map();

/** Remembers when the event happened that an input comes from. */
export function inputSent(number, moment) {
  statistics.sent = number;
  waiting.set(number, moment);
  if (waiting.size > MOST) waiting.delete(waiting.keys().next().value);
}

/** Forgets inputs that nobody will answer. */
export function connectionLost() {
  statistics.sent = 0;
  waiting.clear();
}

/** Takes note of a picture that has just been drawn; it is on the screen with the next frame. */
export function drawn(header) {
  statistics.shown[header.side] = header;
  requestAnimationFrame(() => {
    const now = performance.now();
    statistics.frames += 1;
    statistics.firstPicture ??= now;
    for (const [number, moment] of waiting) {
      if (number > header.input) continue;
      statistics.inputs[number] = now - moment;
      waiting.delete(number);
      delete statistics.inputs[number - MOST];
    }
    if (header.preview) {
      statistics.previews.push(now);
      if (statistics.previews.length > MOST) statistics.previews.shift();
    }
  });
}

/** Takes note that a change of the settings, sent at `moment`, has just been drawn. */
export function settingsDrawn(moment) {
  requestAnimationFrame(() => statistics.settings.push(performance.now() - moment));
}
