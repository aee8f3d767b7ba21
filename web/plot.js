// Curves on a canvas, to zoom in. uPlot is a global of its own script.
/* global uPlot */
import { el, text } from "./dom.js";

const dark = matchMedia("(prefers-color-scheme: dark)");
const palette = () =>
  dark.matches
    ? { data: "#4f7da3", fit: "#ff8a3d", third: "#2fc79a", fourth: "#9aa4af", ink: "#e3e6ea", grid: "#2c333b", shade: "rgba(88,166,230,0.13)" }
    : { data: "#8fb4d0", fit: "#d55e00", third: "#009e73", fourth: "#59636e", ink: "#22272d", grid: "#e4e6e9", shade: "rgba(0,114,178,0.08)" };

/** Digits of a value of any size. */
export function short(value) {
  if (value === null || value === undefined) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  return size >= 1e5 || size < 1e-3 ? value.toExponential(3) : String(Number(value.toPrecision(5)));
}

/**
 * A plot that is as wide as its place.
 * @param host where it stands
 * @param description in words, for those who do not see it
 * @param x label of the horizontal axis
 * @param y label of the vertical axis
 * @param series `{label, values, color, width, dash}` over `values` of the axis
 */
export function plot(host, { description, x, y, along, series, hooks = {}, height = 280 }) {
  const colors = palette();
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
      width: Math.max(240, frame.clientWidth),
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
          value: (_, v) => short(v),
        })),
      ],
      hooks,
      legend: { live: true },
    },
    [along, ...series.map((s) => s.values)],
    frame,
  );
  const canvas = frame.querySelector("canvas");
  canvas.setAttribute("role", "img");
  canvas.setAttribute("aria-label", description);
  const resized = new ResizeObserver(() => drawn.setSize({ width: Math.max(240, frame.clientWidth), height }));
  resized.observe(frame);
  const redraw = () => drawn.redraw();
  dark.addEventListener("change", redraw);
  return {
    drawn,
    remove() {
      resized.disconnect();
      dark.removeEventListener("change", redraw);
      drawn.destroy();
      frame.remove();
    },
  };
}

/** The record with its fit and the two edges of the decay; `choose(option, value)` is told of a moved edge. */
export function record(host, trace, choose) {
  const { time_s: along, signal, fitted, unit, used_s: used } = trace;
  const edges = used.slice();
  const colors = palette();
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
  let handles = [];
  const place = (u) => {
    handles.forEach((handle, i) => {
      const at = u.valToPos(edges[i], "x");
      handle.style.left = `${at}px`;
      handle.hidden = at < -1 || at > u.over.clientWidth + 1;
      handle.setAttribute("aria-valuenow", edges[i]);
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
  });
  const u = shown.drawn;
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
      const step = ((u.scales.x.max - u.scales.x.min) / 100) * (event.shiftKey ? 10 : 1);
      const by = { ArrowLeft: -step, ArrowRight: step, ArrowDown: -step, ArrowUp: step }[event.key];
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
  shown.all = () => u.setScale("x", { min: first, max: last });
  return shown;
}
