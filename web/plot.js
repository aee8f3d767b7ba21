// Curves on a canvas, to zoom in. uPlot is a global of its own script.
/* global uPlot */
import { el, text } from "./dom.js";
import { gestures } from "./gestures.js";

/** No plot is narrower, px. */
const NARROWEST = 240;
const dark = matchMedia("(prefers-color-scheme: dark)");
/** @returns {Record<string, string>} */
const palette = () =>
  dark.matches
    ? { data: "#4f7da3", fit: "#ff8a3d", third: "#2fc79a", fourth: "#9aa4af", ink: "#e3e6ea", grid: "#2c333b", shade: "rgba(88,166,230,0.13)" }
    : { data: "#8fb4d0", fit: "#d55e00", third: "#009e73", fourth: "#59636e", ink: "#22272d", grid: "#e4e6e9", shade: "rgba(0,114,178,0.08)" };

/** Digits of a value of any size. @param {number | null | undefined} value */
export function short(value) {
  if (value === null || value === undefined) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  return size >= 1e5 || size < 1e-3 ? value.toExponential(3) : String(Number(value.toPrecision(5)));
}

/**
 * A plot that is as wide as its place.
 * @param {HTMLElement} host where it stands
 * @param {object} what
 * @param {string} what.description in words, for those who do not see it
 * @param {string} what.x label of the horizontal axis
 * @param {string} what.y label of the vertical axis
 * @param {Numbers} what.along values of the horizontal axis
 * @param {{label: string, values: Float64Array | (number | null)[], color: string, width?: number, dash?: number[], points?: boolean}[]} what.series
 * @param {uPlot.Hooks.Arrays} [what.hooks]
 * @param {number} [what.height]
 * @param {number} [what.width] of its place, where that is known before it is in the page
 * @returns {Plot & {first: number, last: number}}
 */
export function plot(host, { description, x, y, along, series, hooks = {}, height = 280, width }) {
  const colors = palette();
  /** @param {string} label @param {number} size @returns {uPlot.Axis} */
  const axis = (label, size) => ({
    label,
    labelSize: 22,
    size,
    stroke: colors.ink,
    grid: { stroke: colors.grid, width: 1 },
    ticks: { stroke: colors.grid, width: 1 },
    values: (_, ticks) => ticks.map(short),
    font: "12px system-ui, sans-serif",
    labelFont: "12px system-ui, sans-serif",
  });
  const frame = el("div", { class: "plot", role: "group", "aria-label": description });
  host.append(frame);
  const drawn = new uPlot(
    {
      width: Math.max(NARROWEST, width ?? frame.clientWidth),
      height,
      scales: { x: { time: false } },
      axes: [axis(x, 36), axis(y, 64)],
      series: [
        { label: x, value: (_, v) => short(v) },
        ...series.map(({ label, color, width = 1.5, dash, points }) => ({
          label,
          stroke: colors[color],
          width,
          dash,
          points: { show: points ?? false },
          spanGaps: false,
          value: (/** @type {unknown} */ _, /** @type {number | null} */ v) => short(v),
        })),
      ],
      hooks,
      legend: { live: true },
    },
    [along, ...series.map((s) => s.values)],
    frame,
  );
  const canvas = frame.querySelector("canvas");
  canvas?.setAttribute("role", "img");
  canvas?.setAttribute("aria-label", description);
  const [first, last] = [along[0], along[along.length - 1]];
  /** Keeps what is shown inside what there is. @param {number} low @param {number} high */
  const show = (low, high) => {
    const length = Math.min(last - first, Math.max((last - first) / 2000, high - low));
    const min = Math.min(Math.max(first, low), last - length);
    drawn.setScale("x", { min, max: min + length });
  };
  const limits = () => [drawn.scales.x.min ?? first, drawn.scales.x.max ?? last];
  gestures(drawn.over, {
    zoom(factor, about) {
      const [min, max] = limits();
      const box = drawn.over.getBoundingClientRect();
      const at = about ? drawn.posToVal(about.x - box.left, "x") : (min + max) / 2;
      show(at - factor * (at - min), at + factor * (max - at));
    },
    pan(right) {
      const [min, max] = limits();
      show(min + right * (max - min), max + right * (max - min));
    },
    all: () => show(first, last),
  });
  drawn.over.setAttribute("role", "group");
  drawn.over.setAttribute("aria-label", description);
  const resized = new ResizeObserver(() => {
    const wide = Math.max(NARROWEST, frame.clientWidth);
    if (wide !== drawn.width) drawn.setSize({ width: wide, height });
  });
  resized.observe(frame);
  const redraw = () => drawn.redraw();
  dark.addEventListener("change", redraw);
  return {
    drawn,
    first,
    last,
    all: () => show(first, last),
    remove() {
      resized.disconnect();
      dark.removeEventListener("change", redraw);
      drawn.destroy();
      frame.remove();
    },
  };
}

/**
 * The record with its fit and the two edges of the decay; `choose` is told of a moved edge.
 * @param {HTMLElement} host
 * @param {Trace} trace
 * @param {Apply} choose
 * @param {number} width of its place
 * @returns {Plot}
 */
export function record(host, trace, choose, width) {
  const { time_s: along, signal, fitted, unit, used_s: used } = trace;
  const edges = used.slice();
  const colors = palette();
  /** @param {uPlot} u */
  const shade = (u) => {
    const [left, right] = edges.map((t) => u.valToPos(t, "x", true));
    const { ctx, bbox } = u;
    const from = Math.max(left, bbox.left);
    const to = Math.min(right, bbox.left + bbox.width);
    if (to > from) {
      ctx.save();
      ctx.fillStyle = colors.shade;
      ctx.fillRect(from, bbox.top, to - from, bbox.height);
      ctx.restore();
    }
  };
  const names = ["start_s", "end_s"];
  const [first, last] = [along[0], along[along.length - 1]];
  /** @type {HTMLElement[]} */
  let handles = [];
  /** @param {uPlot} u */
  const place = (u) => {
    handles.forEach((handle, i) => {
      const at = u.valToPos(edges[i], "x");
      handle.style.left = `${at}px`;
      handle.hidden = at < -1 || at > u.over.clientWidth + 1;
      handle.setAttribute("aria-valuenow", String(edges[i]));
      handle.setAttribute("aria-valuetext", `${short(edges[i])} s`);
    });
  };
  const label = `${text("figures.record")}: ${text("figures.time")} [s], ${text("figures.signal")} [${unit}]`;
  const shown = plot(host, {
    description: label,
    x: `${text("figures.time")} [s]`,
    y: unit ? `${text("figures.signal")} [${unit}]` : text("figures.signal"),
    along,
    series: [
      { label: text("figures.signal"), values: signal, color: "data", width: 3 },
      { label: text("figures.fit"), values: fitted, color: "fit", width: 1.2 },
    ],
    hooks: { drawClear: [shade], draw: [place] },
    width,
  });
  const u = shown.drawn;
  /** @param {number} i @param {number} to */
  const move = (i, to) => {
    const other = edges[1 - i];
    const bounded = Math.min(Math.max(to, first), last);
    if (i === 0 ? bounded < other : bounded > other) edges[i] = bounded;
    u.redraw();
  };
  handles = names.map((name, i) => {
    const handle = el("div", {
      class: "edge",
      role: "slider",
      tabindex: "0",
      "aria-label": text(i === 0 ? "figures.start" : "figures.end"),
      "aria-valuemin": first,
      "aria-valuemax": last,
      "aria-orientation": "horizontal",
    });
    /** @type {number | null} */
    let begun = null;
    handle.addEventListener("pointerdown", (event) => {
      event.stopPropagation();
      handle.setPointerCapture(event.pointerId);
      begun = edges[i];
    });
    handle.addEventListener("pointermove", (event) => {
      if (begun === null) return;
      move(i, u.posToVal(event.clientX - u.over.getBoundingClientRect().left, "x"));
    });
    handle.addEventListener("pointerup", () => {
      if (begun !== null && edges[i] !== begun) choose(name, edges[i]);
      begun = null;
    });
    for (const kind of ["mousedown", "mousemove", "mouseup"]) handle.addEventListener(kind, (e) => e.stopPropagation());
    handle.addEventListener("keydown", (event) => {
      const step = (((u.scales.x.max ?? last) - (u.scales.x.min ?? first)) / 100) * (event.shiftKey ? 10 : 1);
      /** @type {Record<string, number>} */
      const steps = { ArrowLeft: -step, ArrowRight: step, ArrowDown: -step, ArrowUp: step };
      const by = steps[event.key];
      if (by) {
        event.preventDefault();
        move(i, edges[i] + by);
      } else if (event.key === "Enter" && edges[i] !== used[i]) {
        choose(name, edges[i]);
      }
    });
    handle.addEventListener("blur", () => {
      if (begun === null && edges[i] !== used[i]) choose(name, edges[i]);
    });
    u.over.append(handle);
    return handle;
  });
  place(u);
  return shown;
}
