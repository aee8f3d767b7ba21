// Wheel, pinch and keys as wishes to see more or less of a plot.

/** Of the part shown, for each press of a key. */
const KEY_ZOOM = 0.7;
const KEY_PAN = 0.15;
const WHEEL_ZOOM = 0.0022;

/**
 * @typedef {object} View
 * @property {(factor: number, at: {x: number, y: number} | null) => void} zoom `factor` of what is shown, about a point
 *   of the window; about the middle without one
 * @property {(right: number, up: number) => void} pan by these shares of what is shown
 * @property {() => void} all
 */

/**
 * Lets a plot be looked at closely. The wheel is taken where the plot has the focus, or Ctrl is held: it scrolls the
 * page otherwise.
 * @param {Element & HTMLOrSVGElement} target
 * @param {View} view
 */
export function gestures(target, view) {
  target.tabIndex = 0;
  const listen = /** @type {HTMLElement} */ (/** @type {unknown} */ (target));
  listen.addEventListener(
    "wheel",
    (event) => {
      if (!event.ctrlKey && !target.contains(document.activeElement)) return;
      event.preventDefault();
      const lines = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 16 : 1;
      view.zoom(Math.exp(WHEEL_ZOOM * lines * event.deltaY), { x: event.clientX, y: event.clientY });
    },
    { passive: false },
  );
  listen.addEventListener("keydown", (event) => {
    if (event.target !== target || event.ctrlKey || event.metaKey || event.altKey) return;
    /** @type {Record<string, () => void>} */
    const keys = {
      "+": () => view.zoom(KEY_ZOOM, null),
      "=": () => view.zoom(KEY_ZOOM, null),
      "-": () => view.zoom(1 / KEY_ZOOM, null),
      0: () => view.all(),
      ArrowLeft: () => view.pan(-KEY_PAN, 0),
      ArrowRight: () => view.pan(KEY_PAN, 0),
      ArrowUp: () => view.pan(0, KEY_PAN),
      ArrowDown: () => view.pan(0, -KEY_PAN),
    };
    if (!keys[event.key]) return;
    event.preventDefault();
    keys[event.key]();
  });
  listen.addEventListener("dblclick", () => view.all());
  /** @type {Map<number, {x: number, y: number}>} */
  const fingers = new Map();
  listen.addEventListener("pointerdown", (event) => {
    if (event.pointerType === "touch") fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
  });
  listen.addEventListener("pointermove", (event) => {
    const before = fingers.get(event.pointerId);
    if (!before) return;
    const now = { x: event.clientX, y: event.clientY };
    const other = [...fingers].find(([id]) => id !== event.pointerId)?.[1];
    if (other) {
      /** @param {{x: number, y: number}} p */
      const away = (p) => Math.max(8, Math.hypot(p.x - other.x, p.y - other.y));
      view.zoom(away(before) / away(now), { x: (now.x + other.x) / 2, y: (now.y + other.y) / 2 });
    }
    fingers.set(event.pointerId, now);
  });
  for (const kind of /** @type {const} */ (["pointerup", "pointercancel", "pointerleave"])) {
    listen.addEventListener(kind, (event) => fingers.delete(event.pointerId));
  }
}
