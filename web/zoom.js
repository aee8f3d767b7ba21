// A panel that the core has drawn, to look at closely: its axes say where its numbers lie.
import { el } from "./dom.js";
import { gestures } from "./gestures.js";

const SVG = "http://www.w3.org/2000/svg";
/** The least share of an axis that is shown: points of a line are a hundredth of a unit apart. */
const CLOSEST = 1 / 50;
/** A dot nearer to the pointer than this, in units of the picture, is meant. */
const NEAR = 14;

/** @typedef {{kind: string, low: number, high: number, label: string}} Axis */

/** @param {string} told `log;0.1;20;amplitude [mm]` */
function axis(told) {
  const [kind, low, high, ...label] = told.split(";");
  return { kind, low: Number(low), high: Number(high), label: label.join(";") };
}

/**
 * The number at a share of an axis.
 * @param {Axis} along
 * @param {number} share
 */
function valueAt({ kind, low, high }, share) {
  return kind === "log" ? low * (high / low) ** share : low + share * (high - low);
}

/** @param {number} value @param {number} digits */
const written = (value, digits) => {
  const plain = Math.abs(value) >= 1e5 || (value !== 0 && Math.abs(value) < 1e-4);
  return (plain ? value.toExponential(2) : String(Number(value.toPrecision(digits)))).replace("-", "−");
};

/**
 * Numbers to write along a part of an axis, with their shares of the whole axis.
 * @param {Axis} along
 * @param {number} from
 * @param {number} to
 * @param {number} wanted
 * @returns {{share: number, label: string}[]}
 */
export function ticks(along, from, to, wanted) {
  const [low, high] = [valueAt(along, from), valueAt(along, to)];
  const step = [1, 2, 5, 10].map((s) => s * 10 ** Math.floor(Math.log10((high - low) / wanted))).find((s) => s * wanted >= 0.999 * (high - low)) ?? high - low;
  let values = Array.from({ length: 2 * wanted + 2 }, (_, i) => (Math.ceil(low / step - 1e-6) + i) * step);
  if (along.kind === "log" && high / low > 8) {
    const decades = Math.log10(high / low) > 3 ? [1] : [1, 2, 5];
    const exponents = Array.from({ length: 40 }, (_, i) => Math.floor(Math.log10(low)) + i);
    values = exponents.flatMap((e) => decades.map((m) => m * 10 ** e));
  }
  const inside = values.filter((v) => v >= low - 1e-6 * step && v <= high + 1e-6 * step);
  const digits = Math.max(2, Math.min(12, 1 + Math.ceil(Math.log10(Math.max(Math.abs(low), Math.abs(high)) / step))));
  return inside.map((v) => {
    const value = Math.abs(v) < 1e-9 * step ? 0 : v;
    const share = along.kind === "log" ? Math.log(value / along.low) / Math.log(along.high / along.low) : (value - along.low) / (along.high - along.low);
    return { share, label: written(value, digits) };
  });
}

/**
 * Name, number and unit, as `time 12.3 s`.
 * @param {Axis} along
 * @param {number} share
 */
function said(along, share) {
  if (along.kind === "names") return "";
  const cut = along.label.lastIndexOf(" [");
  const [name, unit] = cut > 0 ? [along.label.slice(0, cut), along.label.slice(cut + 2, -1)] : [along.label, ""];
  return `${name} ${written(valueAt(along, share), 4)} ${unit}`.trim();
}

let made = 0;

/**
 * Lets a panel be zoomed and tells the values in it.
 * @param {SVGSVGElement} svg
 * @returns {{value: HTMLElement, zoom: (factor: number) => void, all: () => void} | null} where the values stand, and
 *   what buttons do; none where the picture has no axes of its own
 */
export function zoomable(svg) {
  const frames = svg.querySelectorAll(".frame");
  if (frames.length !== 1) return null;
  const frame = /** @type {SVGRectElement} */ (frames[0]);
  const [left, top, width, height] = ["x", "y", "width", "height"].map((name) => Number(frame.getAttribute(name)));
  const bottom = top + height;
  const across = axis(frame.dataset.x ?? "");
  const upward = axis(frame.dataset.y ?? "");
  const dots = [...svg.querySelectorAll(".data circle")].map((dot) => ({
    dot,
    x: Number(dot.getAttribute("cx")),
    y: Number(dot.getAttribute("cy")),
    note: dot.querySelector("title")?.textContent ?? "",
  }));
  const paths = [...svg.querySelectorAll(".data path")];
  const tickGroup = svg.querySelector(".ticks");
  const original = tickGroup ? [...tickGroup.childNodes] : [];
  const grid = tickGroup?.querySelector("path");
  const number = tickGroup?.querySelector("text");

  // Nothing is drawn beyond the axes.
  const clip = document.createElementNS(SVG, "clipPath");
  clip.id = `axes-${++made}`;
  const hole = document.createElementNS(SVG, "rect");
  for (const [name, value] of Object.entries({ x: left, y: top, width, height })) hole.setAttribute(name, String(value));
  clip.append(hole);
  svg.prepend(clip);

  // Shares of the axes that are shown; a share grows to the right and upward.
  let shown = { left: 0, right: 1, low: 0, high: 1 };
  const whole = () => shown.left === 0 && shown.right === 1 && shown.low === 0 && shown.high === 1;

  const drawTicks = () => {
    if (!tickGroup || !grid || !number) return;
    if (whole()) return tickGroup.replaceChildren(...original);
    const line = (/** @type {string} */ d) => {
      const path = /** @type {Element} */ (grid.cloneNode());
      path.setAttribute("d", d);
      return path;
    };
    const words = (/** @type {string} */ label, /** @type {number} */ x, /** @type {number} */ y, /** @type {string} */ anchor) => {
      const element = /** @type {Element} */ (number.cloneNode());
      for (const [name, value] of Object.entries({ x, y, "text-anchor": anchor })) element.setAttribute(name, String(value));
      element.textContent = label;
      return element;
    };
    const drawn = [];
    for (const { share, label } of across.kind === "names" ? [] : ticks(across, shown.left, shown.right, 6)) {
      const x = left + ((share - shown.left) / (shown.right - shown.left)) * width;
      drawn.push(line(`M${x} ${top}L${x} ${bottom}`), words(label, x, bottom + 18, "middle"));
    }
    for (const { share, label } of upward.kind === "names" ? [] : ticks(upward, shown.low, shown.high, 5)) {
      const y = bottom - ((share - shown.low) / (shown.high - shown.low)) * height;
      drawn.push(line(`M${left} ${y}L${left + width} ${y}`), words(label, left - 7, y + 5, "end"));
    }
    tickGroup.replaceChildren(...drawn);
  };

  const draw = () => {
    const [sx, sy] = [1 / (shown.right - shown.left), 1 / (shown.high - shown.low)];
    const tx = left * (1 - sx) - shown.left * width * sx;
    const ty = bottom * (1 - sy) + shown.low * height * sy;
    for (const path of paths) path.setAttribute("transform", `matrix(${sx} 0 0 ${sy} ${tx} ${ty})`);
    for (const { dot, x, y } of dots) {
      dot.setAttribute("cx", String(sx * x + tx));
      dot.setAttribute("cy", String(sy * y + ty));
    }
    for (const group of svg.querySelectorAll(".data")) {
      if (whole()) group.removeAttribute("clip-path");
      else group.setAttribute("clip-path", `url(#${clip.id})`);
    }
    svg.classList.toggle("zoomed", !whole());
    drawTicks();
  };

  /** @param {{x: number, y: number}} client a point of the window; gives shares of the frame */
  const place = ({ x, y }) => {
    const at = new DOMPoint(x, y).matrixTransform(svg.getScreenCTM()?.inverse());
    return { at, right: (at.x - left) / width, up: (bottom - at.y) / height };
  };
  /** @param {number} low @param {number} high @returns {[number, number]} */
  const bounded = (low, high) => {
    const length = Math.min(1, Math.max(CLOSEST, high - low));
    const first = Math.min(Math.max(0, low), 1 - length);
    return [first, first + length];
  };
  /** @param {[number, number]} x @param {[number, number]} y */
  const show = (x, y) => {
    [shown.left, shown.right] = bounded(...x);
    [shown.low, shown.high] = bounded(...y);
    draw();
  };
  const view = {
    /** @param {number} factor @param {{x: number, y: number} | null} about */
    zoom(factor, about) {
      const { right, up } = about ? place(about) : { right: 0.5, up: 0.5 };
      /** @param {number} low @param {number} high @param {number} share @returns {[number, number]} */
      const scaled = (low, high, share) => {
        const length = Math.min(1, Math.max(CLOSEST, factor * (high - low)));
        const first = low + Math.min(1, Math.max(0, share)) * (high - low - length);
        return [first, first + length];
      };
      show(scaled(shown.left, shown.right, right), scaled(shown.low, shown.high, up));
    },
    /** @param {number} right @param {number} up */
    pan(right, up) {
      const [dx, dy] = [right * (shown.right - shown.left), up * (shown.high - shown.low)];
      show([shown.left + dx, shown.right + dx], [shown.low + dy, shown.high + dy]);
    },
    all() {
      shown = { left: 0, right: 1, low: 0, high: 1 };
      draw();
    },
  };
  gestures(svg, view);

  const value = el("p", { class: "value soft" });
  /** @param {{clientX: number, clientY: number}} event */
  const tell = ({ clientX: x, clientY: y }) => {
    const { at, right, up } = place({ x, y });
    let nearest = NEAR ** 2;
    let note = "";
    for (const { dot, note: own } of dots) {
      if (!own) continue;
      const away = (Number(dot.getAttribute("cx")) - at.x) ** 2 + (Number(dot.getAttribute("cy")) - at.y) ** 2;
      if (away < nearest) [nearest, note] = [away, own];
    }
    const inside = right >= 0 && right <= 1 && up >= 0 && up <= 1;
    const under = () => [said(across, shown.left + right * (shown.right - shown.left)), said(upward, shown.low + up * (shown.high - shown.low))].filter(Boolean).join(", ");
    value.textContent = note ? note.replaceAll("\n", ", ") : inside ? under() : "";
  };
  svg.addEventListener("pointerleave", () => (value.textContent = ""));

  // A mouse drags out what is to be seen; one finger moves what is zoomed.
  const mark = document.createElementNS(SVG, "rect");
  mark.setAttribute("class", "mark");
  /** @type {{right: number, up: number, touch: boolean} | null} */
  let begun = null;
  svg.addEventListener("pointerdown", (event) => {
    tell(event);
    // Two fingers zoom.
    if (!event.isPrimary) begun = null;
    if (!event.isPrimary || event.button !== 0) return;
    const { right, up } = place({ x: event.clientX, y: event.clientY });
    if (right < 0 || right > 1 || up < 0 || up > 1) return;
    begun = { right, up, touch: event.pointerType === "touch" };
    if (!begun.touch) svg.setPointerCapture(event.pointerId);
  });
  svg.addEventListener("pointermove", (event) => {
    tell(event);
    if (!begun || !event.isPrimary) return;
    const now = place({ x: event.clientX, y: event.clientY });
    if (begun.touch) {
      if (!whole()) {
        view.pan(begun.right - now.right, begun.up - now.up);
        begun = { ...now, touch: true };
      }
      return;
    }
    /** @param {number} share */
    const inside = (share) => Math.min(1, Math.max(0, share));
    const x = [begun.right, inside(now.right)].sort((a, b) => a - b);
    const y = [begun.up, inside(now.up)].sort((a, b) => a - b);
    const box = { x: left + x[0] * width, y: bottom - y[1] * height, width: (x[1] - x[0]) * width, height: (y[1] - y[0]) * height };
    for (const [name, size] of Object.entries(box)) mark.setAttribute(name, String(size));
    svg.append(mark);
  });
  svg.addEventListener("pointerup", (event) => {
    if (begun && !begun.touch && mark.isConnected) {
      const now = place({ x: event.clientX, y: event.clientY });
      const [x, y] = [[begun.right, now.right], [begun.up, now.up]].map(([a, b]) => [Math.min(a, b), Math.max(a, b)]);
      // A click with an unsteady hand is no wish.
      if (x[1] - x[0] > 0.02 && y[1] - y[0] > 0.02) {
        const [w, h] = [shown.right - shown.left, shown.high - shown.low];
        show([shown.left + x[0] * w, shown.left + Math.min(1, x[1]) * w], [shown.low + y[0] * h, shown.low + Math.min(1, y[1]) * h]);
      }
    }
    mark.remove();
    begun = null;
  });
  svg.addEventListener("pointercancel", () => {
    mark.remove();
    begun = null;
  });
  return { value, zoom: (factor) => view.zoom(factor, null), all: view.all };
}
